/** How iterations are played, and the keys of the page. */

import { strict as assert } from "node:assert";
import { after, before, describe, test } from "node:test";

import type { Browser } from "playwright-core";

import { Server } from "./server.js";
import { PATIENT, Visit, becomes, browse, says, until } from "./visit.js";

const SLOW = { name: "slow", curve: { points: [[0, 0], [1, 2], [3, 3], [5, 2], [6, 0]] }, method: "transpose", stop: { tolerance: 1e-12, max_iterations: 50 } };

describe("iterations", () => {
  const server = new Server();
  let browser: Browser;

  before(async () => {
    await server.start();
    browser = await browse();
  });
  after(async () => {
    await browser?.close();
    await server.stop();
  });

  const open = async (): Promise<Visit> => {
    const { id } = await server.job(SLOW);
    const visit = await Visit.to(browser, `${server.url}#job=${id}&k=0`);
    await visit.standing(/in 50 iterations/);
    await visit.still();
    return visit;
  };
  /** How long all of them take, in milliseconds. */
  const played = async (visit: Visit): Promise<number> => {
    const begin = Date.now();
    await visit.press(visit.page.locator("#play"));
    await until(async () => (await visit.page.locator("#play").getAttribute("aria-label")) === "Play" && (await visit.iteration())[0] === 50, "it has come to the end");
    return Date.now() - begin;
  };

  test("take about four seconds, and less at four times the speed", PATIENT, async () => {
    const visit = await open();
    const usual = await played(visit);
    assert.ok(usual > 3000 && usual < 9000, `${usual} ms`);
    await visit.page.getByLabel("Speed").selectOption("4×");
    const quick = await played(visit);
    assert.ok(quick < usual * 0.75, `${quick} ms at four times the speed, ${usual} ms at one`);
    await visit.end();
  });

  test("begin again in a loop, and go by single steps", PATIENT, async () => {
    const visit = await open();
    await visit.page.getByLabel("Speed").selectOption("4×");
    await visit.press(visit.page.getByRole("button", { name: "Loop" }));
    await visit.press(visit.page.locator("#play"));
    await until(async () => (await visit.numbers()).lastIndexOf("0") > 10, "it begins again");
    await visit.press(visit.page.locator("#play"));
    const [now] = await visit.iteration();
    await visit.press(visit.page.getByRole("button", { name: "Step forward" }));
    await becomes(async () => (await visit.iteration())[0], Math.min(50, now + 1));
    await visit.press(visit.page.getByRole("button", { name: "Step back" }));
    await becomes(async () => (await visit.iteration())[0], Math.min(50, now + 1) - 1);
    await visit.end();
  });

  test("have keys, which a list names", PATIENT, async () => {
    const visit = await open();
    await visit.page.keyboard.press(">");
    await becomes(() => visit.page.getByLabel("Speed").inputValue(), "2");
    await visit.page.keyboard.press("l");
    await becomes(() => visit.page.getByRole("button", { name: "Loop" }).getAttribute("aria-pressed"), "true");
    await visit.page.keyboard.press("?");
    const dialog = visit.page.getByRole("dialog", { name: "Keys" });
    await says(dialog, /play or pause.*measure between two points/);
    assert.deepEqual(await visit.axe(), []);
    await visit.page.keyboard.press("Escape");
    await becomes(() => dialog.isVisible(), false);
    await visit.press(visit.page.getByRole("button", { name: "Keys" }));
    await becomes(() => dialog.isVisible(), true);
    await visit.end();
  });

  test("are predicted only where the prediction holds", PATIENT, async () => {
    const visit = await open();
    // That of the transpose misses its errors.
    const key = visit.page.locator("#chart .key");
    const isNear = await visit.page.locator("#chart .predicted").count();
    await says(key, isNear > 0 ? /predicted/ : /^computed$/);
    await visit.end();
  });
});

test("the page says what it is and where its reference is", PATIENT, async () => {
  const server = await new Server().start();
  const browser = await browse();
  try {
    const visit = await Visit.to(browser, server.url);
    await says(visit.page.locator("#about"), /B-spline curves and surfaces/);
    for (const link of await visit.page.locator("#about a").all()) {
      const { status } = await fetch(new URL((await link.getAttribute("href"))!, server.url));
      assert.equal(status, 200);
    }
    await visit.end();
  } finally {
    await browser.close();
    await server.stop();
  }
});
