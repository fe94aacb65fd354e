/** Surfaces that are trimmed to their data. */

import { strict as assert } from "node:assert";
import { after, before, describe, test } from "node:test";

import type { Browser, Page } from "playwright-core";

import { Server } from "./server.js";
import { PATIENT, Visit, becomes, browse, says, until } from "./visit.js";

/** A scan of a round bowl with a hole in its middle, in no order: each point is a golden angle further. */
const SCAN = Array.from({ length: 1200 }, (_, i) => {
  const [r, angle] = [Math.sqrt((i + 0.5) / 1200), i * 2.399963];
  const [x, y] = [r * Math.cos(angle), r * Math.sin(angle)];
  return [x, y, 0.3 * (x * x + y * y)].map((value) => Number(value.toFixed(4)));
}).filter(([x = 0, y = 0]) => Math.hypot(x, y) > 0.4);

/** A wave over a square in which one quarter has no points. */
const GRID = Array.from({ length: 16 }, (_, i) => Array.from({ length: 16 }, (_, j) => (i > 8 && j > 8 ? null : [i, j, Math.sin(i / 3) + Math.cos(j / 4)])));

const BOWL = { name: "bowl", surface: { scattered: SCAN, trim: true }, stop: { tolerance: 0.01 } };
const WHOLE = { ...BOWL, name: "whole", surface: { scattered: SCAN } };

describe("a trimmed surface", () => {
  const server = new Server();
  let browser: Browser;
  let bowl = "";
  let whole = "";

  before(async () => {
    await server.start();
    browser = await browse();
    bowl = (await server.job(BOWL)).id;
    whole = (await server.job(WHOLE)).id;
  });
  after(async () => {
    await browser?.close();
    await server.stop();
  });

  const open = async (hash: string): Promise<Visit> => {
    const visit = await Visit.to(browser, `${server.url}#${hash}`);
    await visit.standing(/^converged/);
    if (!hash.includes(whole)) await visit.page.locator(".trimmed").waitFor();
    await visit.still();
    return visit;
  };

  test("is drawn inside its outline alone, at each iteration", PATIENT, async () => {
    const shares: number[] = [];
    for (const hash of [`job=${whole}&show=`, `job=${bowl}&show=`, `job=${bowl}&k=0&show=`]) {
      const visit = await open(hash);
      shares.push((await visit.drawn()).share);
      await visit.end();
    }
    const [all, last, first] = shares as [number, number, number];
    // A ring has two thirds of the area of the square around it; what is written is the rest.
    assert.ok(last < 0.85 * all && first < 0.85 * all, `it has ${last} and ${first} of the picture, all of it ${all}`);
    assert.ok(last > 0.4 * all, `it has ${last} of the picture, all of it ${all}`);
  });

  test("is found by the pointer where it is, and not in its holes", PATIENT, async () => {
    for (const [id, middle] of [[bowl, false], [whole, true]] as const) {
      const visit = await open(`job=${id}&show=`);
      const { x, y, width, height } = (await visit.page.locator("#viewport").boundingBox())!;
      const tip = visit.page.locator("#tip");
      const seen: boolean[] = [];
      for (let step = 0; step <= 40; step++) {
        await visit.page.mouse.move(x + width * (0.2 + 0.015 * step), y + height / 2 + 22);
        await visit.page.waitForTimeout(30);
        seen.push(await tip.isVisible());
      }
      await becomes(async () => seen[20], middle);
      assert.ok(seen.slice(0, 20).includes(true) && seen.slice(21).includes(true), "it is found on both sides");
      await visit.end();
    }
  });

  for (const layer of ["heat", "zebra", "polygon"]) {
    test(`has ${layer}`, PATIENT, async () => {
      const visit = await open(`job=${bowl}&show=`);
      const before = await visit.drawn();
      await visit.page.locator(`[data-layer=${layer}]`).click();
      await until(async () => (await visit.difference(before)) > 0.003, `${layer} is seen`);
      await visit.end();
    });
  }

  test("says its pieces, its holes and its area", PATIENT, async () => {
    const visit = await open(`job=${bowl}`);
    const trimmed = visit.page.locator(".trimmed");
    await says(trimmed, /^trimmed to the data: 1 piece, 1 hole, area 3\.\d+$/);
    const { trim } = await server.get<{ trim: { area: number } }>(`v1/jobs/${bowl}/result`);
    assert.ok(Math.abs(Number(/area (.*)/.exec((await trimmed.textContent())!)![1]) - trim.area) < 0.001 * trim.area);
    // The area is that of the last iteration.
    await visit.page.keyboard.press("Home");
    await says(trimmed, /1 hole$/);
    assert.deepEqual(await visit.axe(), []);
    await visit.end();
  });

  test("is drawn without WebGL, too", PATIENT, async () => {
    const plain = await browse(["--disable-3d-apis", "--disable-webgl"]);
    try {
      const shares: number[] = [];
      for (const id of [whole, bowl]) {
        const visit = await Visit.to(plain, `${server.url}#job=${id}&show=`);
        await visit.page.locator(".plainly").waitFor();
        if (id === bowl) await visit.page.locator(".trimmed").waitFor();
        await visit.page.waitForTimeout(1000);
        shares.push((await visit.drawn()).share);
      }
      assert.ok(shares[1]! < 0.85 * shares[0]!, `it has ${shares[1]} of the picture, all of it ${shares[0]}`);
    } finally {
      await plain.close();
    }
  });

  test("is asked for by a switch: a scan is read as a surface", PATIENT, async () => {
    const visit = await open(`job=${whole}`);
    const { page } = visit;
    await visit.advanced();
    const text = SCAN.map((point) => point.join(" ")).join("\n");
    await page.locator("#file").setInputFiles({ name: "scan.xyz", mimeType: "text/plain", buffer: Buffer.from(text) });
    await says(page.locator(".data"), new RegExp(`^Surface, ${SCAN.length} scattered points in space`));
    await says(page.locator(".data"), /no order along a curve/);
    // The server refuses them as a curve at first.
    visit.complaints.splice(0).forEach((line) => assert.match(line, /422/));
    await page.getByLabel("Trim to the data").check();
    await page.getByLabel("Unit of the tolerance").selectOption("data units");
    await page.locator("[data-field='/stop/tolerance'] input").fill("0.01");
    const distance = page.getByLabel("Distance");
    await distance.fill("1e-7");
    await page.getByRole("button", { name: "Fit", exact: true }).click();
    await says(page.locator("[data-field='/surface/trim/distance'] .said"), /at least/);
    await becomes(() => distance.getAttribute("aria-invalid"), "true");
    visit.complaints.splice(0).forEach((line) => assert.match(line, /422/));
    assert.deepEqual(await visit.axe(), []);
    await distance.fill("");
    await page.getByText("The request, as JSON and for curl").click();
    await until(async () => /"trim": true/.test(await page.locator("#request-json").inputValue()), "the request has it");
    await becomes(() => page.locator("[data-field='/surface/trim/distance'] .said").isVisible(), false);
    await page.getByRole("button", { name: "Fit", exact: true }).click();
    await says(page.locator(".label h2"), /^scan$/);
    await says(page.locator(".trimmed"), /1 piece, 1 hole/);
    const sent = visit.sent.filter(({ method, path }) => method === "POST" && path === "/v1/jobs").at(-1);
    assert.equal(JSON.parse(sent!.body!).surface.trim, true);
    await visit.end();
  });

  test("may be one through a grid with gaps, and not through a whole one", PATIENT, async () => {
    const visit = await open(`job=${whole}`);
    const { page } = visit;
    await visit.advanced();
    const control = page.getByLabel("Trim to the data");
    await paste(page, JSON.stringify({ surface: { points: GRID }, method: { kind: "least_squares", control_points: 8, fairness: 1e-9 } }));
    await control.check();
    await page.getByRole("button", { name: "Fit", exact: true }).click();
    await says(page.locator(".trimmed"), /1 piece/);
    await paste(page, JSON.stringify({ surface: { points: GRID.slice(0, 8) } }));
    await becomes(() => control.count(), 0);
    await paste(page, "[[0, 0], [1, 2], [3, 3], [5, 2]]");
    await becomes(() => control.count(), 0);
    await visit.end();
  });
});

/** Pastes a text anywhere on the page. */
async function paste(page: Page, text: string): Promise<void> {
  await page.evaluate((text) => {
    const clipboardData = new DataTransfer();
    clipboardData.setData("text/plain", text);
    document.body.dispatchEvent(new ClipboardEvent("paste", { clipboardData, bubbles: true, cancelable: true }));
  }, text);
}
