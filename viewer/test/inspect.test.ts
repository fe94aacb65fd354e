/** What can be looked at of a fit: errors, curvature, what is between the data, distances, other fits. */

import { strict as assert } from "node:assert";
import { after, before, describe, test } from "node:test";

import type { Browser, BrowserContextOptions } from "playwright-core";

import { Server } from "./server.js";
import { PATIENT, Visit, becomes, browse, says, until } from "./visit.js";

const numbers = (count: number) => Array.from({ length: count }, (_, i) => i);
const CURVE = { name: "arch", curve: { points: [[0, 0], [1, 2], [3, 3], [5, 2], [6, 0]] } };
const side = numbers(9).map((i) => (i - 4) / 4);
const SADDLE = { name: "saddle", surface: { points: side.map((x) => side.map((y) => [x, y, x * x - y * y])) } };
const GAPS = { name: "gaps", surface: { points: side.map((x, i) => side.map((y, j) => (i > 2 && i < 6 && j > 2 && j < 6 ? null : [x, y, x * y]))) }, stop: { tolerance: 0.01 } };
const WRONG = { name: "wrong", curve: { points: numbers(80).map((i) => [i / 8, Math.sin(i / 8) + (i === 40 ? 6 : 0)]) }, method: { kind: "least_squares", control_points: 12, robust: true } };
const PHONE: BrowserContextOptions = { viewport: { width: 390, height: 844 }, hasTouch: true };

describe("a fit", () => {
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

  const open = async (jobs: readonly object[], options: BrowserContextOptions = {}, more = ""): Promise<Visit> => {
    const ids = [];
    for (const job of jobs) ids.push((await server.job(job)).id);
    const visit = await Visit.to(browser, `${server.url}#job=${ids.join()}${more}`, options);
    await visit.standing(/^(converged|stalled|not yet)/);
    await visit.still();
    return visit;
  };
  const layer = (visit: Visit, name: string) => visit.page.locator(`[data-layer=${name}]`);

  for (const [name, options] of [["with the mouse", {}], ["with a finger", PHONE]] as const) {
    test(`has colours of error, curvature and what is between, ${name}`, PATIENT, async () => {
      const visit = await open([SADDLE], options);
      const before = await visit.drawn();
      const isTouch = options === PHONE;
      await visit.press(layer(visit, "heat"), isTouch);
      await says(visit.page.locator(".legend"), /Distance from the data/);
      await visit.press(layer(visit, "comb"), isTouch);
      await says(visit.page.locator(".legend"), /Largest principal curvature/);
      assert.equal(await layer(visit, "heat").getAttribute("aria-pressed"), "false");
      assert.ok(visit.sent.some(({ path }) => /\/shape\?/.test(path)), "the server computes it");
      await until(async () => (await visit.difference(before)) > 0.02, "it is drawn");
      await visit.press(layer(visit, "between"), isTouch);
      await until(async () => visit.sent.some(({ path }) => /\/deviation\?.*list=true/.test(path)), "the server is asked what is between");
      assert.deepEqual(await visit.axe(), []);
      await visit.end();
    });
  }

  test("of a curve has colours of its error, and a comb with the curvature of the server", PATIENT, async () => {
    const visit = await open([CURVE], {}, "&k=0");
    const before = await visit.drawn();
    await visit.page.keyboard.press("r");
    await says(visit.page.locator(".legend"), /Distance from the data/);
    await until(async () => (await visit.difference(before)) > 0.002, "it is coloured");
    await visit.page.keyboard.press("c");
    await says(visit.page.locator(".label .scale"), /^curvature from −?[\d.]+.* to .*: 1 is drawn/);
    await visit.end();
  });

  test("has coordinates, error and curvature under the pointer, and points from 1", PATIENT, async () => {
    const visit = await open([CURVE], {}, "&k=1");
    const [x, y] = await visit.leftmost();
    const tip = visit.page.locator("#tip");
    await visit.page.mouse.move(x + 2, y);
    await visit.page.mouse.move(x, y);
    await says(tip, /^point1x0y0error.*curvature−?[\d.]/);
    await visit.end();
  });

  test("is measured between two points", PATIENT, async () => {
    const visit = await open([CURVE]);
    const [x, y] = await visit.leftmost();
    const { x: left, width } = (await visit.page.locator("#viewport").boundingBox())!;
    await visit.press(visit.page.getByRole("button", { name: "Measure" }));
    await visit.pressAt(x, y);
    await says(visit.page.locator(".measured"), /^From x 0, y 0/);
    // The curve is symmetric, and so is the scene.
    await visit.pressAt(2 * left + width - x, y);
    await says(visit.page.locator(".measured"), /^Distance 6 \(Δx 6, Δy 0\)/);
    assert.equal(await visit.page.locator(".overlay .distance").count(), 1);
    assert.equal(await visit.page.locator(".card:visible").count(), 0);
    await visit.page.keyboard.press("Escape");
    await becomes(() => visit.page.locator(".measured").isVisible(), false);
    await visit.end();
  });

  test("shows outliers and gaps as such", PATIENT, async () => {
    const wrong = await open([WRONG]);
    await says(wrong.page.locator(".label"), /1 outlier is left out/);
    await wrong.end();
    const gaps = await open([GAPS]);
    const before = await gaps.drawn();
    await layer(gaps, "data").click();
    await until(async () => (await gaps.difference(before)) > 0.0005, "points and gaps are drawn");
    await gaps.end();
  });

  test("has error vectors of at most a tenth of the view, with their scale", PATIENT, async () => {
    const visit = await open([CURVE], {}, "&k=0&show=data,spikes");
    await says(visit.page.locator(".label .scale"), /^error vectors × \d/);
    await visit.end();
  });

  test("has error vectors within the view, where the errors are less than samples tell", PATIENT, async () => {
    const points = numbers(15).map((i) => numbers(15).map((j) => [i / 7, j / 7, Math.cos(2 * Math.hypot(i / 7 - 1, j / 7 - 1))]));
    const visit = await open([{ name: "near", surface: { points }, stop: { relative_tolerance: 1e-10 } }]);
    const before = (await visit.drawn()).share;
    await visit.press(layer(visit, "spikes"));
    await says(visit.page.locator(".label .scale"), /^error vectors × \d/);
    const { share } = await visit.still();
    assert.ok(share < before + 0.12, `${share} of the view after ${before}`);
    await visit.end();
  });

  test("is brought before the others of its scene by a click", PATIENT, async () => {
    const again = { ...CURVE, name: "again", method: { kind: "chebyshev" } };
    const visit = await open([CURVE, again]);
    await visit.press(visit.page.getByRole("button", { name: "Overlay" }));
    const name = (title: string) => visit.page.getByRole("button", { name: title, exact: true });
    await name("arch").waitFor();
    const before = await visit.still();
    await visit.press(name("arch"));
    await becomes(() => name("arch").getAttribute("aria-pressed"), "true");
    await until(async () => (await visit.difference(before, 60)) > 0.001, "it is drawn last");
    await visit.press(name("arch"));
    await becomes(() => name("arch").getAttribute("aria-pressed"), "false");
    const [x, y] = await visit.leftmost();
    await visit.pressAt(x, y);
    await becomes(() => visit.page.locator(".forward[aria-pressed=true]").count(), 1);
    assert.deepEqual(await visit.axe(), []);
    await visit.end();
  });

  test("is compared in one scene, with the difference as colours", PATIENT, async () => {
    const other = { ...SADDLE, name: "other", method: { kind: "least_squares", control_points: 5 } };
    const visit = await open([SADDLE, other]);
    await becomes(() => visit.page.locator(".label").count(), 2);
    const before = await visit.drawn();
    await visit.press(visit.page.getByRole("button", { name: "Overlay" }));
    await until(async () => (await visit.difference(before)) > 0.02, "they are in one scene");
    assert.match(visit.page.url(), /overlaid/);
    await visit.press(layer(visit, "heat"));
    await says(visit.page.locator(".legend"), /Distance from saddle/);
    assert.deepEqual(await visit.axe(), []);
    await visit.end();
  });

  test("has axes and a scale bar, which follow the camera", PATIENT, async () => {
    const visit = await open([SADDLE]);
    const texts = () => visit.page.locator(".overlay text").allTextContents();
    assert.deepEqual((await texts()).slice(0, 3), ["x", "y", "z"]);
    const [, , , length] = await texts();
    for (let i = 0; i < 6; i++) await visit.page.keyboard.press("+");
    await until(async () => (await texts())[3] !== length, "the bar has another length");
    await visit.end();
  });
});
