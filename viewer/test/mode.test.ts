/** Data points are moved in the Edit mode alone; without it drags turn the scene, and swipes scroll the page. */

import { strict as assert } from "node:assert";
import { after, before, describe, test } from "node:test";

import type { Browser, BrowserContextOptions } from "playwright-core";

import { Server } from "./server.js";
import { PATIENT, Visit, becomes, browse, until } from "./visit.js";

const CURVE = { name: "arch", curve: { points: [[0, 0], [1, 2], [3, 3], [5, 2], [6, 0]] } };
const side = Array.from({ length: 15 }, (_, i) => (i - 7) / 7);
const WAVE = { name: "wave", surface: { points: side.map((x) => side.map((y) => [2 * x, 2 * y, Math.cos(5 * Math.hypot(x, y)) / 2])) } };
const PHONE = { viewport: { width: 390, height: 844 }, hasTouch: true };

describe("without the Edit mode", () => {
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

  const open = async (job: unknown, options: BrowserContextOptions = {}): Promise<Visit> => {
    const { id } = await server.job(job);
    const visit = await Visit.to(browser, `${server.url}#job=${id}`, options);
    await visit.standing(/^converged/);
    await visit.still();
    return visit;
  };
  const edits = (visit: Visit) => visit.sent.filter(({ path }) => path.includes("/edits")).length;
  const drag = async ({ page }: Visit, x: number, y: number) => {
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + 40, y - 30, { steps: 6 });
    await page.mouse.up();
  };
  /** A swipe of a finger over the scene, upwards. It rests before it is lifted: the page does not glide on. */
  const swipe = async ({ page }: Visit, by = 220) => {
    const { x, y, width, height } = (await page.locator("#viewport").boundingBox())!;
    const session = await page.context().newCDPSession(page);
    const touch = (type: "touchStart" | "touchMove" | "touchEnd", up = 0) =>
      session.send("Input.dispatchTouchEvent", { type, touchPoints: type === "touchEnd" ? [] : [{ x: x + width / 2, y: y + height * 0.75 - up }] });
    await touch("touchStart");
    for (let up = 0; up <= by; up += 10) await touch("touchMove", up);
    await page.waitForTimeout(200);
    await touch("touchMove", by);
    await touch("touchEnd");
    await session.detach();
  };
  const scrolled = (visit: Visit) => visit.page.evaluate(() => scrollY);

  test("ten drags over a surface turn it, and edit nothing", PATIENT, async () => {
    const visit = await open(WAVE);
    const url = visit.page.url();
    const before = await visit.drawn();
    const { x, y, width, height } = (await visit.page.locator("#viewport").boundingBox())!;
    for (let i = 0; i < 10; i++) await drag(visit, x + width * (0.4 + 0.02 * i), y + height * 0.55);
    assert.ok((await visit.difference(before)) > 0.02, "it is turned");
    await visit.page.waitForTimeout(500);
    assert.equal(edits(visit), 0);
    assert.equal(visit.page.url(), url);
    await visit.end();
  });

  test("the button and the key E begin and end it, and Alt is for one drag", PATIENT, async () => {
    const visit = await open(CURVE);
    const button = visit.page.getByRole("button", { name: "Edit", exact: true });
    const isPressed = () => button.getAttribute("aria-pressed");
    assert.equal(await isPressed(), "false");
    await drag(visit, ...(await visit.leftmost()));
    assert.equal(edits(visit), 0);
    await visit.page.keyboard.press("0");
    await visit.still();
    await visit.page.keyboard.down("Alt");
    await drag(visit, ...(await visit.leftmost()));
    await visit.page.keyboard.up("Alt");
    await until(async () => edits(visit) > 0, "a drag with Alt edits");
    assert.equal(await isPressed(), "false");
    await becomes(() => visit.page.locator("#undo").isEnabled(), true);
    await visit.page.locator("#undo").click();
    await visit.still();
    await button.click();
    assert.equal(await isPressed(), "true");
    const before = edits(visit);
    await drag(visit, ...(await visit.leftmost()));
    await until(async () => edits(visit) > before, "a drag in the mode edits");
    assert.deepEqual(await visit.axe(), []);
    await visit.page.keyboard.press("e");
    await becomes(isPressed, "false");
    await visit.still();
    const after = edits(visit);
    await drag(visit, ...(await visit.leftmost()));
    await visit.page.waitForTimeout(300);
    assert.equal(edits(visit), after);
    await visit.end();
  });

  test("a swipe over the scene scrolls the page on a phone, and leaves the scene as it was", PATIENT, async () => {
    const visit = await open(WAVE, PHONE);
    const before = await visit.drawn();
    await swipe(visit);
    await until(async () => (await scrolled(visit)) > 150, "the page is scrolled");
    await visit.page.evaluate(() => scrollTo(0, 0));
    assert.equal(edits(visit), 0);
    await until(async () => (await visit.difference(before, 60)) < 0.002, "the scene is as it was");
    await visit.page.getByRole("button", { name: "Edit", exact: true }).tap();
    const place = await scrolled(visit);
    await swipe(visit);
    assert.equal(await scrolled(visit), place);
    await visit.end();
  });

  for (const [width, height] of [[1440, 900], [1024, 768], [390, 844]] as const) {
    test(`what was edited can be undone by a button that is seen, at ${width} × ${height}`, PATIENT, async () => {
      const visit = await open(CURVE, { viewport: { width, height } });
      const id = /#job=([\w-]+)/.exec(visit.page.url())![1]!;
      const undo = visit.page.locator("#undo");
      await becomes(() => undo.isDisabled(), true);
      await visit.page.keyboard.press("e");
      await drag(visit, ...(await visit.leftmost()));
      await becomes(() => undo.isEnabled(), true);
      const box = (await undo.boundingBox())!;
      assert.ok(box.x >= 0 && box.x + box.width <= width && box.y >= 0 && box.y + box.height <= height, `it is at ${box.x}, ${box.y}`);
      await undo.click();
      await until(async () => visit.page.url().includes(id), "it is undone");
      await visit.end();
    });
  }
});
