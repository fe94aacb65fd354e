/** The error of every iteration, on a scale of powers of ten. */

import uPlot from "uplot";

import type { App } from "../app.js";
import type { Fit } from "../fit/fit.js";
import { byId, el } from "../html.js";
import { onPalette, palette, seriesColor } from "../scene/palette.js";
import { MOST_JOBS } from "../state.js";
import { count, short, superscript } from "../text/numbers.js";

// Iterations that are predicted but far away would make those that are there small.
const FURTHEST = 4;
// Nor is a tolerance seen that is smaller than this part of all errors.
const OUT_OF_REACH = 1e-13;

// A prediction that misses an error by more than this factor is not drawn.
const WITHIN = 3;

/** All powers of ten: without its increments uPlot leaves an axis out. */
const POWERS = Array.from({ length: 632 }, (_, i) => 10 ** (i - 323));

export function chart(app: App): void {
  const root = byId("chart");
  const { view, fits } = app;
  const label = el("h2", {}, "Largest error");
  const key = el("p", { class: "key" });
  const place = el("div", { class: "plot", role: "img" });
  root.append(el("div", { class: "caption" }, label, key), place);
  let colors = palette();

  const shownAt = () => {
    const { iteration } = view.value;
    const latest = Math.max(0, ...fits.shown.map((fit) => fit.latest));
    return iteration === "latest" ? latest : Math.min(iteration, latest);
  };
  const plot = new uPlot(options(() => colors, () => fits.shown, shownAt, (k) => view.set({ iteration: k, playing: false })), empty(), place);

  const update = () => {
    const shown = fits.shown;
    plot.setData(dataOf(shown), true);
    key.replaceChildren(...keyOf(shown));
    place.setAttribute("aria-label", describe(shown));
  };
  const resize = () => {
    const { clientWidth: width, clientHeight: height } = place;
    if (width > 0 && height > 0) plot.setSize({ width, height });
  };
  new ResizeObserver(resize).observe(place);
  fits.subscribe(update);
  view.subscribe((now, before) => {
    if (now.iteration !== before.iteration) plot.redraw(false, false);
  });
  onPalette(() => {
    colors = palette();
    plot.redraw(false, true);
  });
  update();
}

function empty(): uPlot.AlignedData {
  return [[0], ...Array.from({ length: MOST_JOBS * 2 }, () => [null])] as uPlot.AlignedData;
}

/** A series for each job, and one for what is predicted of it. */
function dataOf(fits: readonly Fit[]): uPlot.AlignedData {
  const latest = Math.max(1, ...fits.map((fit) => fit.latest));
  const expected = Math.max(0, ...fits.map((fit) => (fit.end === null || fits.length === 1 ? (fit.head?.predicted.iterations ?? 0) : 0)));
  const end = Math.max(latest, Math.min(expected, latest * FURTHEST + 20));
  const x = Array.from({ length: end + 1 }, (_, k) => k);
  const series = fits.flatMap((fit) => [
    x.map((k) => positive(fit.levels[k]?.error.max)),
    fits.length === 1 ? predicted(fit, x) : x.map(() => null),
  ]);
  while (series.length < MOST_JOBS * 2) series.push(x.map(() => null));
  return [x, ...series] as uPlot.AlignedData;
}

/** From the error of iteration 0 by the predicted rate, down to the tolerance; nothing where errors were others. */
function predicted(fit: Fit, x: readonly number[]): (number | null)[] {
  const { head, levels } = fit;
  const [first, rate] = [levels[0]?.error.max, head?.predicted.rate];
  if (!isPredicted(fit) || typeof first !== "number" || typeof rate !== "number") return x.map(() => null);
  const least = (head?.stop.tolerance ?? 0) / 3;
  return x.map((k) => {
    const error = first * rate ** k;
    return error >= least && error > 0 ? error : null;
  });
}

/** True if the prediction is within a factor of three of the errors that are known, down to the tolerance. */
function isPredicted({ head, levels }: Fit): boolean {
  const [first, rate] = [levels[0]?.error.max, head?.predicted.rate];
  if (typeof first !== "number" || typeof rate !== "number" || !(rate > 0) || rate >= 1) return false;
  return levels.every((level, k) => {
    const [error, guess] = [level?.error.max ?? 0, first * rate ** k];
    return guess < (head?.stop.tolerance ?? 0) || (error <= guess * WITHIN && error * WITHIN >= guess);
  });
}

function positive(value: number | null | undefined): number | null {
  return typeof value === "number" && value > 0 ? value : null;
}

type Colors = ReturnType<typeof palette>;

function options(colors: () => Colors, fits: () => readonly Fit[], shownAt: () => number, seek: (k: number) => void): uPlot.Options {
  const font = `11px ${getComputedStyle(document.body).fontFamily}`;
  const axis = { stroke: () => colors().css.soft, font, grid: { show: false }, ticks: { show: false } };
  const line = (i: number): uPlot.Series => ({
    stroke: () => seriesColor(colors().css, fits().length > 1 ? i : 0),
    width: 2,
    points: { show: false },
    spanGaps: false,
  });
  const guess = (i: number): uPlot.Series => ({
    stroke: () => seriesColor(colors().css, fits().length > 1 ? i : 0),
    alpha: 0.5,
    width: 1.25,
    dash: [3, 4],
    points: { show: false },
  });
  return {
    width: 300,
    height: 120,
    padding: [8, 14, 0, 0],
    legend: { show: false },
    cursor: { y: false, points: { show: false }, drag: { x: false, y: false, setScale: false }, bind: { click: (u) => () => (u.cursor.idx != null && seek(u.cursor.idx), null) } },
    scales: { x: { time: false, range: (_, min, max) => [min, Math.max(max, min + 1)] }, y: { distr: 3, range: (_, min, max) => heights(min, max, fits()) } },
    axes: [
      { ...axis, size: 24, gap: 4, incrs: [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000, 20_000, 50_000, 100_000, 200_000, 500_000, 1_000_000], space: 56, values: (_, ticks) => ticks.map(count) },
      { ...axis, incrs: POWERS, size: 46, gap: 8, space: 26, grid: { show: true, stroke: () => colors().css.line, width: 1 }, splits: (_, __, low, high) => powers(low, high), filter: (_, ticks) => ticks, values: (_, ticks) => ticks.map(power) },
    ],
    series: [{}, ...Array.from({ length: MOST_JOBS }, (_, i) => [line(i), guess(i)]).flat()],
    hooks: { draw: [(u) => marks(u, colors(), fits(), shownAt())] },
  };
}

/** The range of the errors, with the tolerance. */
function heights(min: number, max: number, fits: readonly Fit[]): [number, number] {
  // One that no fit ever gets to would make the errors a line along the upper edge.
  const nearest = Math.min(min > 0 ? min : Infinity, max || 1) * OUT_OF_REACH;
  const tolerances = fits.flatMap(({ head }) => (head !== null && head.stop.tolerance > nearest ? [head.stop.tolerance] : []));
  const least = Math.min(min > 0 ? min : Infinity, ...tolerances);
  const low = Number.isFinite(least) ? least : 1e-6;
  const high = Math.max(max || 1, Math.min(low * 10, Number.MAX_VALUE));
  return [10 ** Math.max(-307, Math.floor(Math.log10(low) - 0.15)), 10 ** Math.min(308, Math.ceil(Math.log10(high) + 0.02))];
}

/** Powers of ten, as many as can be told apart. */
function powers(low: number, high: number): number[] {
  const [first, last] = [Math.ceil(Math.log10(low) - 1e-9), Math.floor(Math.log10(high) + 1e-9)];
  const step = Math.max(1, Math.ceil((last - first) / 6));
  return Array.from({ length: Math.floor((last - first) / step) + 1 }, (_, i) => 10 ** (last - i * step)).reverse();
}

function power(value: number | null): string {
  if (value === null) return "";
  const exponent = Math.log10(value);
  if (Math.abs(exponent - Math.round(exponent)) > 1e-6) return "";
  return Math.round(exponent) === 0 ? "1" : `10${superscript(Math.round(exponent))}`;
}

/** The tolerance, and the iteration that is shown. */
function marks(u: uPlot, { css }: Colors, fits: readonly Fit[], k: number): void {
  const { ctx, bbox } = u;
  const ratio = uPlot.pxRatio;
  ctx.save();
  ctx.lineWidth = ratio;
  const tolerance = fits[0]?.head?.stop.tolerance ?? 0;
  if (tolerance >= (u.scales["y"]?.min ?? 0) && tolerance > 0) {
    const y = Math.round(u.valToPos(tolerance, "y", true)) + 0.5;
    ctx.strokeStyle = ctx.fillStyle = css.soft;
    ctx.setLineDash([6 * ratio, 4 * ratio]);
    stroke(ctx, bbox.left, y, bbox.left + bbox.width, y);
    ctx.font = `${11 * ratio}px ${getComputedStyle(document.body).fontFamily}`;
    ctx.textAlign = "left";
    ctx.fillText("tolerance", bbox.left + 6 * ratio, y - 5 * ratio);
  }
  if (fits.length > 0) {
    const x = Math.round(u.valToPos(k, "x", true)) + 0.5;
    ctx.setLineDash([]);
    ctx.strokeStyle = css.ink;
    ctx.globalAlpha = 0.35;
    stroke(ctx, x, bbox.top, x, bbox.top + bbox.height);
    ctx.globalAlpha = 1;
  }
  fits.forEach((fit, i) => {
    const at = Math.min(k, fit.latest);
    const error = positive(fit.levels[at]?.error.max);
    if (error === null) return;
    ctx.beginPath();
    ctx.arc(u.valToPos(at, "x", true), u.valToPos(error, "y", true), 4.5 * ratio, 0, 2 * Math.PI);
    ctx.fillStyle = seriesColor(css, fits.length > 1 ? i : 0);
    ctx.strokeStyle = css.paper;
    ctx.lineWidth = 2 * ratio;
    ctx.fill();
    ctx.stroke();
  });
  ctx.restore();
}

function stroke(ctx: CanvasRenderingContext2D, x0: number, y0: number, x1: number, y1: number): void {
  ctx.beginPath();
  ctx.moveTo(x0, y0);
  ctx.lineTo(x1, y1);
  ctx.stroke();
}

function keyOf(fits: readonly Fit[]): HTMLElement[] {
  if (fits.every(({ latest }) => latest < 0)) return [];
  if (fits.length > 1) return fits.map(({ title }, i) => el("span", { "data-series": i + 1 }, title));
  const lines = [el("span", {}, "computed")];
  if (fits[0] !== undefined && isPredicted(fits[0])) lines.push(el("span", { class: "predicted" }, "predicted"));
  return lines;
}

function describe(fits: readonly Fit[]): string {
  const of = fits.map(({ title, levels, head, latest }) => {
    const tolerance = head === null ? "" : `; the tolerance is ${short(head.stop.tolerance)}`;
    return `${title}: from ${short(levels[0]?.error.max)} at iteration 0 to ${short(levels[latest]?.error.max)} at iteration ${latest}${tolerance}`;
  });
  return `Largest error of each iteration. ${of.join(". ")}`;
}
