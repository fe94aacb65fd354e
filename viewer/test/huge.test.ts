/** Fits that leave all bounds: their numbers are shown to the last iteration, and the scene comes back from them. */

import { strict as assert } from "node:assert";
import { after, before, describe, test } from "node:test";

import type { Browser } from "playwright-core";

import { Server } from "./server.js";
import { PATIENT, Visit, becomes, browse, says, until } from "./visit.js";

const METHOD = { basis: "bernstein" };
// It begins at the data.
const STOP = { method: { kind: "extended", start: "data" }, stop: { tolerance: 1e-9 } };
const side = Array.from({ length: 20 }, (_, i) => i);
const grown = Array.from({ length: 120 }, (_, i) => i);

/** Errors beyond 10⁵⁹ at the last iteration; 32 bits end at 10³⁸. */
const JOBS: Readonly<Record<string, object>> = {
  "a curve": { name: "curve", curve: { points: Array.from({ length: 40 }, (_, i) => [i, 3 * Math.sin(i / 2)]), ...METHOD }, ...STOP },
  "a surface": { name: "surface", surface: { points: side.map((i) => side.map((j) => [i, j, 2 * Math.sin(i) * Math.cos(j)])), ...METHOD }, ...STOP },
  "a curve that grows step by step": {
    name: "custom",
    curve: { points: grown.map((i) => [i, 3 * Math.sin(i / 2)]) },
    method: { kind: "custom", transform: grown.map((i) => grown.map((j) => (i === j ? 50 : 0))) },
    stop: { max_iterations: 40 },
  },
};

describe("errors beyond all bounds", () => {
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

  for (const [name, job] of Object.entries(JOBS)) {
    test(`of ${name} are shown to the last iteration`, PATIENT, async () => {
      const { id } = await server.job(job);
      const { iteration: last, error } = await server.get<{ iteration: number; error: { max: number } }>(`v1/jobs/${id}`);
      assert.ok(error.max > 1e59);
      const visit = await Visit.to(browser, `${server.url}#job=${id}&k=0&show=data`);
      await visit.standing(/^(stalled|not yet converged) in/);
      await visit.still();
      const first = await visit.drawn();
      // It runs to the end by itself, through all of them.
      await visit.page.locator("#play").click();
      await until(async () => (await visit.page.locator("#play").getAttribute("aria-label")) === "Play", "it has come to the end");
      assert.deepEqual(await visit.iteration(), [last, last]);
      const slider = visit.page.locator("#slider");
      assert.deepEqual([await slider.inputValue(), await slider.getAttribute("max")], [String(last), String(last)]);
      const power = [...String(Math.floor(Math.log10(error.max)))].map((digit) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(digit)]).join("");
      for (const place of [".label .state", "#facts dd"]) await says(visit.page.locator(place), new RegExp(`·10${power}`));
      const chart = visit.page.locator(".plot");
      await until(async () => new RegExp(`·10${power} at iteration ${last}`).test((await chart.getAttribute("aria-label")) ?? ""), "the chart has it");
      assert.ok(await drawn(visit), "the chart has a line to its right end");
      await says(visit.page.locator(".label"), /too far from the data/);
      assert.doesNotMatch((await visit.page.locator("body").innerText()) + (await visit.page.content()), /NaN|undefined|Infinity/);
      await visit.still();
      assert.ok((await visit.difference(first)) > 0.002, "the last one is another than the first");
      // And all of the first one is there again.
      await visit.page.keyboard.press("Home");
      await becomes(async () => (await visit.iteration())[0], 0);
      await visit.still();
      // Edges are softer or sharper with WebGL than without.
      await until(async () => (await visit.difference(first, 240)) < 0.002, "the first is as it was");
      await visit.end();
    });
  }
});

/** Returns true if there is a line in the last twentieth of the chart. */
function drawn(visit: Visit): Promise<boolean> {
  return visit.page.locator(".plot canvas").evaluate((canvas: HTMLCanvasElement) => {
    const { width, height } = canvas;
    const left = Math.floor(width * 0.9);
    const { data } = canvas.getContext("2d")!.getImageData(left, 0, width - left, height);
    const isBlue = (i: number) => data[i + 3]! > 128 && data[i + 2]! > data[i]! + 60;
    return data.some((_, i) => i % 4 === 0 && isBlue(i));
  });
}
