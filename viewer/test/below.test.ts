/** The page of a server that clients see below a path. */

import { strict as assert } from "node:assert";
import { after, before, describe, test } from "node:test";

import type { Browser } from "playwright-core";

import { Server } from "./server.js";
import { PATIENT, Visit, browse, until } from "./visit.js";

describe("a server with --base-path", () => {
  const server = new Server(":memory:", "/tools/fits");
  let browser: Browser;

  before(async () => {
    await server.start();
    browser = await browse();
  });
  after(async () => {
    await browser?.close();
    await server.stop();
  });

  test("has its page below the path, and asks for nothing elsewhere", PATIENT, async () => {
    // The slash at the end comes by itself.
    const visit = await Visit.to(browser, `${server.url}tools/fits`);
    await visit.standing(/^converged/);
    await until(async () => (await visit.drawn()).share > 0.02, "the example is drawn");
    await visit.page.getByRole("tab", { name: "Jobs" }).click();
    await until(async () => /Ring/.test((await visit.page.locator("main, aside, body").last().textContent()) ?? ""), "the job is in the list");
    assert.match(visit.page.url(), /\/tools\/fits\/(#.*)?$/);
    const elsewhere = visit.sent.filter(({ path }) => !path.startsWith("/tools/fits"));
    assert.deepEqual(elsewhere, []);
    assert.ok(visit.sent.some(({ path }) => path.startsWith("/tools/fits/v1/jobs/")));
    await visit.end();
  });
});
