/** The client in Node. */

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, describe, test } from "node:test";
import { setFlagsFromString } from "node:v8";
import { runInNewContext } from "node:vm";

import { Client, type ClientOptions } from "piad";

import { LocalEnvironment } from "./environment.js";
import { scenarios } from "./scenarios/index.js";
import { ROOT, Server } from "./server.js";
import { large } from "./shapes.js";

// For users.
const PAGES = new Set(["getPagePart", "getReference", "getReferenceFile"]);

describe("in Node", () => {
  const server = new Server(":memory:");
  const environment = new LocalEnvironment();
  const used = new Set<string>();

  before(() => server.start());
  after(async () => {
    await environment.clear();
    await server.kill();
  });

  /** A client that records its requests. */
  const client = (options: ClientOptions = {}, url = server.url): Client => {
    const { fetch = globalThis.fetch, ...others } = options;
    const noted: ClientOptions["fetch"] = (url, init) => {
      used.add(`${init.method} ${new URL(url).pathname}`);
      return fetch(url, init);
    };
    return new Client(url, { ...others, fetch: noted });
  };

  for (const [name, scenario] of Object.entries(scenarios)) {
    test(name, { timeout: 180_000 }, () => scenario({ url: server.url, environment, client }));
  }

  test("every operation of the API has been used", () => {
    const description = JSON.parse(readFileSync(join(ROOT, "docs/openapi.json"), "utf8"));
    const unused = [];
    for (const [path, operations] of Object.entries<Record<string, { operationId: string }>>(description.paths)) {
      for (const [method, { operationId }] of Object.entries(operations)) {
        const pattern = new RegExp(`^${method.toUpperCase()} ${path.replace(/\{\w+\}/g, "[^/]+")}$`);
        if (!PAGES.has(operationId) && ![...used].some((request) => pattern.test(request))) unused.push(operationId);
      }
    }
    assert.deepEqual(unused, []);
  });

  test("who is slow has no more in memory than what is on its way", { timeout: 180_000 }, async () => {
    const stream = client().createStream(large(400), { view: "control_points" });
    setFlagsFromString("--expose-gc");
    const collect = runInNewContext("gc") as () => void;
    const held = () => {
      collect();
      const { arrayBuffers, heapUsed } = process.memoryUsage();
      return arrayBuffers + heapUsed;
    };
    const start = held();
    let most = 0;
    for await (const { number } of stream) {
      await new Promise((resolve) => setTimeout(resolve, 100));
      most = Math.max(most, held() - start);
      if (number === 20) break;
    }
    // Iterations are a megabyte each; 400 would be 400 MB.
    assert.ok(most < 20e6, `${most} bytes`);
    await (await client().job(stream.job?.id ?? "")).delete();
  });
});
