/** Data points that are too many to be drawn one by one. */

import { strict as assert } from "node:assert";
import { after, before, describe, test } from "node:test";

import type { Browser } from "playwright-core";

import { Server } from "./server.js";
import { PATIENT, Visit, browse, says, until } from "./visit.js";

const COUNT = 40_000;
/** A wave, and a last point far to the left of it; every second one is drawn, and it is not. */
const POINTS = Array.from({ length: COUNT }, (_, i) => (i === COUNT - 1 ? [-3, 0] : [(10 * i) / COUNT, Math.sin(i / 4000)]));

describe("many data points", () => {
  const server = new Server();
  let browser: Browser;
  let id = "";

  before(async () => {
    await server.start();
    browser = await browse();
    ({ id } = await server.job({ name: "many", curve: { points: POINTS }, stop: { tolerance: 1e-3, max_iterations: 20 } }));
  });
  after(async () => {
    await browser?.close();
    await server.stop();
  });

  const open = async (show: string): Promise<Visit> => {
    const visit = await Visit.to(browser, `${server.url}#job=${id}&show=${show}`);
    await until(async () => /in \d+ iterations/.test((await visit.page.locator(".label .state").textContent()) ?? ""), "it is fitted");
    await until(async () => (await visit.drawn()).share > 0.003, "it is drawn");
    return visit;
  };

  test("are drawn in part, and the page says so", PATIENT, async () => {
    const visit = await open("");
    await says(visit.page.locator("#announcer"), /^20\u202f000 of 40\u202f000 data points are drawn\.$/);
    const bare = await visit.drawn();
    await visit.page.locator("[data-layer=data]").click();
    await until(async () => (await visit.difference(bare)) > 0.001, "points are seen");
    await visit.end();
  });

  test("are all there to be looked at and dragged", PATIENT, async () => {
    const visit = await open("data");
    await visit.edit();
    const { mouse } = visit.page;
    const tip = visit.page.locator("#tip");
    let [x, y] = [0, 0];
    // No point is drawn there, where the curve ends. Where points are is found out beside, and not at once.
    await until(async () => {
      [x, y] = await visit.leftmost(170);
      await mouse.move(x + 1, y);
      await mouse.move(x, y);
      return tip.isVisible();
    }, "the point is found");
    await says(tip, new RegExp(`^point${COUNT}x−3y0`));
    const before = await visit.drawn();
    await mouse.down();
    await mouse.move(x + 5, y - 20, { steps: 3 });
    await mouse.move(x + 10, y - 70, { steps: 3 });
    await until(async () => (await visit.difference(before)) > 0.0005, "its mark goes along");
    await mouse.up();
    await until(async () => !visit.page.url().includes(id), "the edit is shown", 60);
    const kept = visit.sent.flatMap(({ path, body }) => (/\/edits/.test(path) && body !== null ? [JSON.parse(body) as { points?: { index: number }[]; ephemeral?: boolean }] : []));
    assert.deepEqual(kept.at(-1)?.points?.map(({ index }) => index), [COUNT - 1]);
    await visit.end();
  });
});
