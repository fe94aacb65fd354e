/**
 * Measures drags in Chromium, with a server of its own: `npm run drags` prints a line for each fit. Times of
 * requests are those that the browser keeps (from the start of the request to the end of the answer), times of
 * frames those between the frames in its own trace.
 */

import type { Browser } from "playwright-core";

import { Server } from "./server.js";
import { Visit, browse, until } from "./visit.js";

const MOVES = 200;
// Data points of surfaces are grey.
const PALE = 80;

interface Frame {
  readonly name: string;
  readonly ts: number;
  readonly pid: number;
}

interface Request {
  readonly milliseconds: number;
  readonly bytes: number;
}

/** A rippled line, which begins at the left. */
function curve(count: number): object {
  const point = (i: number) => [(10 * i) / count, Math.sin((12 * i) / count) + 0.1 * Math.sin((70 * i) / count)];
  return { curve: { points: Array.from({ length: count }, (_, i) => point(i)) } };
}

function surface(side: number): object {
  const at = (i: number) => (6 * i) / (side - 1) - 3;
  const point = (i: number, j: number) => [at(i), at(j), Math.sin(at(i)) * Math.cos(at(j))];
  return { surface: { points: Array.from({ length: side }, (_, i) => Array.from({ length: side }, (_, j) => point(i, j))) } };
}

function quantile(values: readonly number[], share: number): number {
  return [...values].sort((a, b) => a - b)[Math.min(values.length - 1, Math.floor(values.length * share))] ?? NaN;
}

/** Drags the leftmost data point in circles. */
async function circle(visit: Visit): Promise<void> {
  const [x, y] = await visit.leftmost(PALE);
  const { mouse } = visit.page;
  await mouse.move(x, y);
  await mouse.down();
  for (let i = 1; i <= MOVES; i++) await mouse.move(x + 20 + 20 * Math.cos(i / 9), y + 20 * Math.sin(i / 9));
  await mouse.up();
}

async function measure(browser: Browser, server: Server, name: string, request: object): Promise<void> {
  const { id } = await server.job(request);
  const visit = await Visit.to(browser, `${server.url}#job=${id}`);
  await visit.standing(/^converged/);
  await until(async () => Number.isFinite((await visit.leftmost(PALE))[0]), "the data points are drawn");
  await visit.edit();
  await visit.page.evaluate(() => performance.setResourceTimingBufferSize(10_000));
  await browser.startTracing(visit.page, { categories: ["devtools.timeline", "disabled-by-default-devtools.timeline.frame", "devtools.timeline.frame"] });
  await circle(visit);
  const trace = JSON.parse((await browser.stopTracing()).toString()) as { traceEvents: Frame[] };
  const requests = await visit.page.evaluate(() =>
    (performance.getEntriesByType("resource") as PerformanceResourceTiming[])
      .filter((entry) => entry.name.includes("/edits/stream") && entry.responseEnd > 0 && entry.transferSize > 0)
      .map((entry): Request => ({ milliseconds: entry.responseEnd - entry.startTime, bytes: entry.transferSize })),
  );
  await visit.page.context().close();
  const drawn = trace.traceEvents.filter((event) => event.name === "DrawFrame").map((event) => event.ts / 1000).sort((a, b) => a - b);
  const between = drawn.slice(1).map((at, i) => at - drawn[i]!);
  const times = requests.map(({ milliseconds }) => milliseconds);
  const one = (value: number) => value.toFixed(1);
  console.log(
    `${name}: ${requests.length} drags, median ${one(quantile(times, 0.5))} ms, 90 % within ${one(quantile(times, 0.9))} ms, ` +
      `${one(quantile(requests.map(({ bytes }) => bytes), 0.5) / 1000)} kB; ` +
      `${between.length} frames, median ${one(quantile(between, 0.5))} ms, 90 % within ${one(quantile(between, 0.9))} ms`,
  );
}

const server = await new Server().start();
const browser = await browse();
try {
  await measure(browser, server, "curve of 200 points", curve(200));
  await measure(browser, server, "surface of 30 × 30 points", surface(30));
  await measure(browser, server, "curve of 100,000 points", curve(100_000));
} finally {
  await browser.close();
  await server.stop();
}
