/** The heading is about what is on the screen: this iteration of this fit. */

import { strict as assert } from "node:assert";
import { after, before, describe, test } from "node:test";

import type { Browser } from "playwright-core";

import { Server } from "./server.js";
import { PATIENT, Visit, browse, says, until } from "./visit.js";

const SINE = { name: "sine", curve: { points: Array.from({ length: 400 }, (_, i) => [i / 40, Math.sin(i / 40)]) }, method: { kind: "least_squares", control_points: "auto" }, stop: { tolerance: 0.001 } };
const CURVE = { name: "arch", curve: { points: [[0, 0], [1, 2], [3, 3], [5, 2], [6, 0]] } };

interface Level {
  readonly control_points: unknown[];
  readonly error: { readonly max: number };
}

describe("the heading", () => {
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

  /** Waits until it has the numbers of an iteration. */
  const has = async (visit: Visit, id: string, k: number, isLast: boolean): Promise<void> => {
    const level = await server.get<Level>(`v1/jobs/${id}/iterations/${k}`);
    await says(visit.page.locator(".label .how"), new RegExp(`, ${level.control_points.length} control points,`));
    const state = visit.page.locator(".label .state");
    await says(state, isLast ? /^converged in \d+ iterations, error / : new RegExp(`^converged in \\d+ iterations; shown: iteration ${k}, error `));
    const error = numberOf((await state.textContent())!.split("error ")[1]!);
    assert.ok(Math.abs(error - level.error.max) <= 0.01 * level.error.max, `${error} is ${level.error.max}`);
  };

  test("has the counts of each iteration of a fit that chooses its knots", PATIENT, async () => {
    const { id } = await server.job(SINE);
    const visit = await Visit.to(browser, `${server.url}#job=${id}&k=0`);
    await visit.standing(/^converged/);
    const [, last] = await visit.iteration();
    await has(visit, id, 0, false);
    for (const k of [4, 21]) {
      await visit.page.locator("#slider").fill(String(k));
      await has(visit, id, k, false);
    }
    await visit.page.keyboard.press("End");
    await has(visit, id, last, true);
    const { control_points: first } = await server.get<Level>(`v1/jobs/${id}/iterations/0`);
    const { control_points: best } = await server.get<Level>(`v1/jobs/${id}/result`);
    assert.ok(best.length > first.length, "the fit has more at the end");
    await visit.end();
  });

  test("says how long a job runs of which nothing comes", PATIENT, async () => {
    const { id } = await server.job(CURVE);
    const visit = await Visit.to(browser, server.url);
    let release = () => {};
    const held = new Promise<void>((resolve) => (release = resolve));
    await visit.page.route(/\/events/, async (route) => {
      await held;
      await route.continue();
    });
    await visit.page.evaluate((hash) => (location.hash = hash), `#job=${id}`);
    await visit.standing(/^running for [345] s, no iteration yet$/);
    await visit.standing(/^running for [67] s/);
    release();
    await visit.standing(/^converged/);
    await visit.end();
  });

  test("is that of the edit while a point is dragged, and of the old fit after it is undone", PATIENT, async () => {
    const { id } = await server.job(CURVE);
    const visit = await Visit.to(browser, `${server.url}#job=${id}`);
    const state = visit.page.locator(".label .state");
    await visit.standing(/^converged/);
    await visit.still();
    const before = await state.textContent();
    await visit.edit();
    const [x, y] = await visit.leftmost();
    await visit.page.mouse.move(x, y);
    await visit.page.mouse.down();
    await visit.page.mouse.move(x + 20, y - 60, { steps: 8 });
    await says(state, /^preview of the edit, iteration \d+, error /);
    await visit.page.mouse.up();
    await until(async () => !visit.page.url().includes(id), "the edit is shown");
    await says(state, /^converged/);
    await visit.page.locator("#undo").click();
    await until(async () => (await state.textContent()) === before, "it is as before");
    await visit.end();
  });
});

/** "1.31·10⁻⁵" as a number. */
function numberOf(text: string): number {
  const plain = text.replace("−", "-").replace("·10", "e").replace(/[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]/g, (sign) => "-0123456789"["⁻⁰¹²³⁴⁵⁶⁷⁸⁹".indexOf(sign)]!);
  return Number(/^-?[\d.]+(e-?\d+)?/.exec(plain)?.[0]);
}
