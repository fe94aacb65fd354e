/** How long it takes until a fit is seen. `make paint` prints it: the page in Chromium, with a server of its own. */

import type { Browser, CDPSession, Page } from "playwright-core";

import { Server } from "./server.js";
import { browse } from "./visit.js";

const LOADS = Number(process.argv[2] ?? 15);
const STEPS = ["html", "script", "styles", "context", "job", "samples", "drawn", "seen", "webgl", "webgl seen"] as const;

type Step = (typeof STEPS)[number];
type Times = Record<Step, number>;

interface Event {
  readonly name: string;
  readonly ph: string;
  readonly ts: number;
  readonly pid: number;
  readonly dur?: number;
  readonly args?: { chrome_graphics_pipeline?: { step?: string } };
}

/** When the canvas was there; asked by the page's own marks nowhere. */
function watch(): void {
  const real = HTMLCanvasElement.prototype.getContext;
  HTMLCanvasElement.prototype.getContext = function (this: HTMLCanvasElement, ...given: Parameters<typeof real>) {
    const context = real.apply(this, given);
    if (/webgl/.test(given[0])) performance.mark("context");
    return context;
  } as typeof real;
}

/** Waits for the first picture, and says what had come when, in milliseconds from the navigation on. */
async function marks(page: Page): Promise<Omit<Times, "seen" | "webgl seen">> {
  await page.waitForFunction(() => performance.getEntriesByName("first picture of WebGL").length > 0, undefined, { polling: 100 });
  return page.evaluate(() => {
    const parts = performance.getEntriesByType("resource") as PerformanceResourceTiming[];
    const end = (pattern: RegExp) => Math.min(...parts.filter(({ name }) => pattern.test(name)).map(({ responseEnd }) => responseEnd));
    const mark = (name: string) => performance.getEntriesByName(name)[0]?.startTime ?? NaN;
    const [navigation] = performance.getEntriesByType("navigation") as PerformanceNavigationTiming[];
    return {
      html: navigation!.responseEnd,
      script: end(/app\.js$/),
      styles: end(/app\.css$/),
      context: mark("context"),
      job: end(/\/v1\/jobs$/),
      samples: end(/view=samples/),
      drawn: mark("first picture"),
      webgl: mark("first picture of WebGL"),
    };
  });
}

/** The events of the trace, which ends. */
async function traced(session: CDPSession): Promise<Event[]> {
  const events: Event[] = [];
  session.on("Tracing.dataCollected", ({ value }) => events.push(...(value as unknown as Event[])));
  const complete = new Promise((resolve) => session.once("Tracing.tracingComplete", resolve));
  await session.send("Tracing.end");
  await complete;
  return events;
}

/**
 * How long after a mark the next frame of the page was on the screen, in milliseconds: from the frame that the page
 * hands in to the end of the drawing that shows it.
 */
function seenAfter(events: readonly Event[], mark: string): number {
  const drawn = events.find(({ name }) => name === mark);
  if (drawn === undefined) throw new Error(`the trace has no "${mark}"`);
  const next = (after: number, is: (event: Event) => boolean) => events.filter((event) => event.ts >= after && is(event)).sort((a, b) => a.ts - b.ts)[0];
  const step = (event: Event) => event.args?.chrome_graphics_pipeline?.step;
  const handed = next(drawn.ts, (event) => event.pid === drawn.pid && step(event) === "STEP_SUBMIT_COMPOSITOR_FRAME");
  const shown = next(handed?.ts ?? Infinity, ({ name, ph }) => name === "Display::DrawAndSwap" && ph === "X");
  return ((shown?.ts ?? NaN) + (shown?.dur ?? 0) - drawn.ts) / 1000;
}

async function load(page: Page, session: CDPSession, url: string): Promise<Times> {
  await session.send("Tracing.start", { traceConfig: { includedCategories: ["blink.user_timing", "viz"], recordMode: "recordAsMuchAsPossible" } });
  await page.goto(url);
  const times = await marks(page);
  await page.waitForTimeout(500);
  const events = await traced(session);
  const seen = times.drawn + seenAfter(events, "first picture");
  return { ...times, seen, "webgl seen": times.webgl + seenAfter(events, "first picture of WebGL") };
}

async function loads(browser: Browser, url: string, isWarm: boolean): Promise<Times[]> {
  const all: Times[] = [];
  const fresh = async () => {
    const context = await browser.newContext({ viewport: { width: 1280, height: 720 } });
    await context.addInitScript(watch);
    return context;
  };
  let context = await fresh();
  for (let i = isWarm ? -1 : 0; i < LOADS; i++) {
    const page = await context.newPage();
    const session = await browser.newBrowserCDPSession();
    const times = await load(page, session, url);
    await session.detach();
    if (i >= 0) all.push(times);
    await page.close();
    if (isWarm) continue;
    await context.close();
    context = await fresh();
  }
  await context.close();
  return all;
}

function quantile(list: readonly number[], share: number): string {
  const sorted = [...list].sort((a, b) => a - b);
  return String(Math.round(sorted[Math.round((sorted.length - 1) * share)] ?? NaN));
}

const server = await new Server().start();
const browser = await browse();
try {
  for (const isWarm of [false, true]) {
    const all = await loads(browser, server.url, isWarm);
    console.log(`\n${isWarm ? "again, from the cache" : "for the first time"}: ${LOADS} loads, milliseconds from the navigation on`);
    console.log(["", "median", "least", "90 %"].map((head) => head.padStart(12)).join(""));
    for (const step of STEPS) {
      const list = all.map((times) => times[step]);
      console.log([step, quantile(list, 0.5), quantile(list, 0), quantile(list, 0.9)].map((cell) => cell.padStart(12)).join(""));
    }
  }
} finally {
  await browser.close();
  await server.stop();
}
