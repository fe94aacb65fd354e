/**
 * How fluently large fits turn. `make turn` prints it: the page in Chromium, with a server of its own and with
 * WebGL drawn by the processor. Frames are those that the browser has put on the screen, by its own trace.
 */

import type { Browser } from "playwright-core";

import { Server } from "./server.js";
import { Visit, browse, until } from "./visit.js";

const SECONDS = 4;
const VIEWPORT = { width: 1280, height: 720 };

const numbers = (count: number) => Array.from({ length: count }, (_, i) => i);
const round = (value: number) => Number(value.toFixed(5));

/** Hills, a million points. */
function surface(side: number): unknown {
  const points = numbers(side).map((i) => numbers(side).map((j) => [i / 250, j / 250, 0.35 * Math.sin(i / 70) * Math.cos(j / 90) + 0.02 * Math.sin(i / 9)].map(round)));
  return { name: `${side} × ${side}`, surface: { points }, stop: { tolerance: 1e-5, max_iterations: 12 } };
}

/** A knot that is wound around a ring, in space. */
function curve(count: number): unknown {
  const points = numbers(count).map((i) => {
    const t = (i / count) * 2 * Math.PI;
    const r = 2 + 0.6 * Math.cos(41 * t);
    return [r * Math.cos(2 * t), r * Math.sin(2 * t), 0.6 * Math.sin(41 * t)].map(round);
  });
  return { name: `${count} points`, curve: { points }, stop: { tolerance: 1e-5, max_iterations: 12 } };
}

interface Event {
  readonly name: string;
  readonly ph: string;
  readonly ts: number;
  readonly dur?: number;
}

/** Turns the camera with each frame that the page gets, and gives the milliseconds between those that were shown. */
async function frames(browser: Browser, visit: Visit): Promise<number[]> {
  const session = await browser.newBrowserCDPSession();
  const events: Event[] = [];
  session.on("Tracing.dataCollected", ({ value }) => events.push(...(value as unknown as Event[])));
  const turn = (seconds: number) =>
    visit.page.evaluate(async (seconds) => {
      const end = performance.now() + seconds * 1000;
      while (performance.now() < end) {
        await new Promise(requestAnimationFrame);
        dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowRight", shiftKey: true }));
      }
    }, seconds);
  await turn(1);
  await session.send("Tracing.start", { traceConfig: { includedCategories: ["viz"], recordMode: "recordAsMuchAsPossible" } });
  await turn(SECONDS);
  const complete = new Promise((resolve) => session.once("Tracing.tracingComplete", resolve));
  await session.send("Tracing.end");
  await complete;
  await session.detach();
  const shown = events.filter(({ name, ph }) => name === "Display::DrawAndSwap" && ph === "X").map(({ ts, dur = 0 }) => (ts + dur) / 1000);
  shown.sort((a, b) => a - b);
  return shown.slice(1).map((end, i) => end - shown[i]!);
}

function told(what: string, list: readonly number[]): void {
  const sorted = [...list].sort((a, b) => a - b);
  const at = (share: number) => (sorted[Math.round((sorted.length - 1) * share)] ?? NaN).toFixed(1).padStart(8);
  console.log(`${what.padEnd(34)}${String(list.length).padStart(6)}${at(0.5)}${at(0.9)}${at(1)}`);
}

const server = await new Server().start();
const browser = await browse();
try {
  console.log(`${"milliseconds from frame to frame".padEnd(34)}frames  median    90 %    most`);
  for (const request of [surface(1000), curve(1_000_000)]) {
    const { id } = await server.job(request);
    const visit = await Visit.to(browser, "about:blank", { viewport: VIEWPORT });
    for (const layers of ["data", "", "data,heat"]) {
      await visit.page.goto(`${server.url}?${layers}#job=${id}&show=${layers}`);
      const state = visit.page.locator(".label .state");
      await until(async () => /in \d+ iteration/.test((await state.textContent()) ?? ""), "it is fitted", 300);
      await until(async () => (await visit.drawn()).share > 0.02, "it is drawn", 120);
      await visit.whole();
      const title = (await visit.page.locator(".label h2").textContent()) ?? "";
      told(`${title}, ${layers || "bare"}`, await frames(browser, visit));
      for (let i = 0; i < 8; i++) await visit.page.keyboard.press("+");
      await visit.page.waitForTimeout(3000);
      told(`${title}, ${layers || "bare"}, from near`, await frames(browser, visit));
    }
    await visit.page.context().close();
  }
} finally {
  await browser.close();
  await server.stop();
}
