/** The client in a page of another origin, in Chromium. */

import { readFile } from "node:fs/promises";
import { type Server as PageServer, createServer } from "node:http";
import type { AddressInfo } from "node:net";
import { after, before, describe, test } from "node:test";

import { type Browser, type Page, chromium } from "playwright-core";

import { LocalEnvironment } from "./environment.js";
import { scenarios } from "./scenarios/index.js";
import { Server } from "./server.js";
import type { Environment } from "./world.js";

const PACKAGE = new URL("..", import.meta.url);
const CHROMIUM = process.env["CHROMIUM"] ?? "/usr/bin/chromium";

// No bundler: the page loads the published files and their parser.
const IMPORTS = {
  imports: {
    piad: "/dist/index.js",
    "eventsource-parser": "/node_modules/eventsource-parser/dist/index.js",
  },
};
const HTML = `<!doctype html><title>a page</title><script type="importmap">${JSON.stringify(IMPORTS)}</script>`;

/** Runs a scenario in the page, with the servers behind it as functions. */
async function play([name, url, methods]: [string, string, (keyof Environment)[]]): Promise<string | null> {
  const { Client } = await import("piad");
  const { scenarios } = (await import("/build/scenarios/index.js" as string)) as typeof import("./scenarios/index.js");
  const environment = Object.fromEntries(methods.map((method) => [method, Reflect.get(globalThis, method)]));
  try {
    await scenarios[name]!({
      url,
      environment: environment as unknown as Environment,
      client: (options, other = url) => new Client(other, options),
    });
    return null;
  } catch (error) {
    return error instanceof Error ? `${error.name}: ${error.message}\n${error.stack}` : String(error);
  }
}

describe("in a browser", () => {
  const server = new Server(":memory:");
  const environment = new LocalEnvironment();
  const pages = servePages();
  const methods: (keyof Environment)[] = ["durable", "kill", "restart", "proxy", "passed", "cutAfter", "loseAnswer", "nowhere"];
  let browser: Browser;
  let page: Page;

  before(async () => {
    await server.start();
    browser = await chromium.launch({ executablePath: CHROMIUM, args: ["--no-sandbox", "--disable-dev-shm-usage"] });
    page = await browser.newPage();
    for (const method of methods) await page.exposeFunction(method, environment[method]);
    await page.goto(`http://localhost:${(pages.address() as AddressInfo).port}/`);
  });
  after(async () => {
    await browser?.close();
    pages.close();
    await environment.clear();
    await server.kill();
  });

  for (const name of Object.keys(scenarios)) {
    test(name, { timeout: 180_000 }, async () => {
      const wrong = await page.evaluate(play, [name, server.url, methods] as [string, string, (keyof Environment)[]]);
      if (wrong !== null) throw new Error(wrong);
    });
  }
});

/** An empty page, and the scripts of the package. */
function servePages(): PageServer {
  const pages = createServer(async ({ url = "/" }, response) => {
    try {
      const script = url.endsWith(".js") ? await readFile(new URL(`.${url}`, PACKAGE)) : HTML;
      response.setHeader("Content-Type", url.endsWith(".js") ? "text/javascript" : "text/html");
      response.end(script);
    } catch {
      response.writeHead(404).end();
    }
  });
  return pages.listen(0, "127.0.0.1");
}
