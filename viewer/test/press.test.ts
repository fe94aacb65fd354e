/** Nothing moves under a pressed pointer: each click that takes a tenth of a second counts. */

import { strict as assert } from "node:assert";
import { after, before, describe, test } from "node:test";

import type { Browser, Locator, Page } from "playwright-core";

import { Server } from "./server.js";
import { PATIENT, Visit, browse, until } from "./visit.js";

const steps = Array.from({ length: 60 }, (_, i) => (i / 60) * 2 * Math.PI);
const petals = (t: number) => 1 + 0.42 * Math.cos(5 * t);
const ROSE = { name: "rose", curve: { points: steps.map((t) => [petals(t) * Math.cos(t), petals(t) * Math.sin(t)]), closed: true }, stop: { relative_tolerance: 1e-6 } };

/** What somebody does with a field before the press, by kinds of fields. */
const CHANGES: Readonly<Record<string, (page: Page) => Promise<unknown>>> = {
  "a text": (page) => field(page, "/name").fill("other"),
  "a number": (page) => field(page, "/curve/basis/degree").fill("5"),
  "a number with a unit": (page) => field(page, "/stop/tolerance").fill("1e-5"),
  "a number that is left as it is": (page) => field(page, "/stop/max_iterations").focus(),
  "a list": (page) => field(page, "/method/kind").selectOption("weighted"),
  "a setting of a method": (page) => field(page, "/method/omega").fill("1.1"),
  "a list that has no other fields": (page) => field(page, "/method/kind").selectOption("global"),
  "a box": (page) => field(page, "/curve/closed").setChecked(false),
  "a number that is cleared": (page) => field(page, "/stop/max_iterations").fill(""),
  "a folded section": (page) => unfold(page, "Corners, ends, parameters, weights"),
  "a list in a folded section": (page) => field(page, "/curve/parameters").selectOption({ index: 1 }),
  "the request as JSON": async (page) => {
    await unfold(page, "The request, as JSON and for curl");
    const area = page.locator("#request-json");
    await until(async () => (await area.inputValue()) !== "", "the request is there");
    await area.fill((await area.inputValue()).replace(/"name": "\w+"/, '"name": "written"'));
  },
};

describe("a press of a tenth of a second", () => {
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

  for (const [width, height] of [[1440, 900], [1024, 768], [390, 844]] as const) {
    const open = async (): Promise<[Visit, Locator]> => {
      const { id } = await server.job(ROSE);
      const visit = await Visit.to(browser, `${server.url}#job=${id}`, { viewport: { width, height }, hasTouch: width < 500 });
      await visit.standing(/^converged/);
      await until(async () => (await field(visit.page, "/name").inputValue()) === "rose", "the request is in the form");
      await visit.advanced();
      return [visit, visit.page.getByRole("button", { name: "Fit", exact: true })];
    };

    test(`fits after each kind of field, at ${width} × ${height}`, PATIENT, async () => {
      const [visit, fit] = await open();
      const lost: string[] = [];
      for (const [kind, change] of Object.entries(CHANGES)) {
        await change(visit.page);
        const told = await pressed(visit, fit, width < 500);
        if (told !== "") lost.push(`${kind}: ${told}`);
        await visit.standing(/^converged/);
      }
      assert.deepEqual(lost, []);
      await visit.end();
    });

    test(`fits after something that was wrong, at ${width} × ${height}`, PATIENT, async () => {
      const [visit, fit] = await open();
      const degree = field(visit.page, "/curve/basis/degree");
      const lost: string[] = [];
      for (const right of ["3", "4", "5"]) {
        await degree.fill("-1");
        const wrong = await pressed(visit, fit, width < 500);
        if (wrong !== "") lost.push(`-1: ${wrong}`);
        else await until(async () => (await degree.getAttribute("aria-invalid")) === "true", "it is refused");
        await degree.fill(right);
        const told = await pressed(visit, fit, width < 500);
        if (told !== "") lost.push(`${right}: ${told}`);
        await visit.standing(/^converged/);
      }
      assert.deepEqual(lost, []);
      visit.complaints.splice(0, Infinity, ...visit.complaints.filter((line) => !/422/.test(line)));
      await visit.end();
    });
  }
});

function field(page: Page, pointer: string): Locator {
  return page.locator(`[data-field='${pointer}'] :is(input, select)`).first();
}

function unfold(page: Page, title: string): Promise<void> {
  return page.locator("details", { hasText: title }).last().evaluate((details: HTMLDetailsElement) => void (details.open = true));
}

/** Presses a button for a tenth of a second; what went wrong, if nothing was sent or the button was elsewhere. */
async function pressed(visit: Visit, button: Locator, isTouch: boolean): Promise<string> {
  const { page } = visit;
  const count = () => visit.sent.filter(({ method, path }) => method === "POST" && path === "/v1/jobs").length;
  const sent = count();
  const was = (await button.boundingBox())!;
  const [x, y] = [was.x + was.width / 2, was.y + 4];
  if (isTouch) {
    const session = await page.context().newCDPSession(page);
    await session.send("Input.dispatchTouchEvent", { type: "touchStart", touchPoints: [{ x, y }] });
    await page.waitForTimeout(100);
    await session.send("Input.dispatchTouchEvent", { type: "touchEnd", touchPoints: [] });
    await session.detach();
  } else {
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.waitForTimeout(100);
    const now = (await button.boundingBox())!;
    await page.mouse.up();
    if (now.y !== was.y) return `the button moved by ${now.y - was.y} pixels`;
  }
  for (let i = 0; i < 40 && count() === sent; i++) await page.waitForTimeout(50);
  return count() === sent ? "nothing was sent" : "";
}
