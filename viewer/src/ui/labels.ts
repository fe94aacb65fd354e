/** What stands beside each figure: its name, how it is fitted, how it stands, and the scales of what is drawn. */

import type { api } from "piad";

import type { App } from "../app.js";
import type { Counts } from "../fit/controls.js";
import { type Fit, isGone } from "../fit/fit.js";
import type { Outline } from "../fit/outline.js";
import { el } from "../html.js";
import type { FitView } from "../scene/fit-view.js";
import type { Preview, SceneController } from "../scene/scene-controller.js";
import { fromOne } from "../text/errors.js";
import { icon } from "./icons.js";
import { count, short } from "../text/numbers.js";

/** How jobs stand, in words. */
export const STATES: Readonly<Record<api.JobState, string>> = {
  queued: "waits",
  running: "running",
  converged: "converged",
  exhausted: "not yet converged",
  stalled: "stalled",
  failed: "failed",
  cancelled: "cancelled",
};

// In a figure that is not so wide the error is that of the iteration that is shown alone; in pixels.
const NARROW = 300;

export function labels(app: App, scene: SceneController, root: HTMLElement): void {
  const layer = el("div", { class: "labels" });
  root.append(layer);
  let timer = 0;
  const update = () => {
    // What takes long is counted.
    clearTimeout(timer);
    if (app.fits.shown.some(({ end, problem }) => end === null && problem === null)) timer = window.setTimeout(update, 1000);
    const cells = scene.viewport.cells();
    const many = scene.fitViews.length > 1;
    layer.classList.toggle("stacked", scene.viewport.isOverlaid);
    layer.replaceChildren(
      ...scene.fitViews.map((fitView, i) => {
        const cell = cells[i];
        const label = el("section", { class: "label", "data-series": many ? i + 1 : null, "aria-label": fitView.fit.title }, ...about(app, fitView, many, (cell?.width ?? 0) < NARROW, scene.difference));
        if (cell !== undefined) {
          label.style.left = `${cell.x}px`;
          label.style.top = `${cell.y}px`;
          label.style.width = `${cell.width}px`;
          label.style.height = `${cell.height}px`;
        }
        return label;
      }),
      ...(scene.fitViews.length > 0 ? [] : scene.points !== null ? [unfitted(scene.points)] : [nothing()]),
    );
    const seen = scene.fitViews.map((fitView) => `${fitView.fit.title} at iteration ${fitView.shownOf(app.view.value)}`);
    const alone = scene.points === null ? "Nothing yet" : `Points of ${scene.points.title}, not fitted yet`;
    scene.viewport.canvas.setAttribute("aria-label", seen.join(", ") || alone);
    document.title = `${app.fits.shown[0]?.title ?? "Fits"} – piad`;
  };
  let frame = 0;
  const later = () => {
    frame ||= requestAnimationFrame(() => {
      frame = 0;
      update();
    });
  };
  app.fits.subscribe(later);
  app.view.subscribe(later);
  scene.onFrame = later;
  new ResizeObserver(later).observe(root);
  later();
}

/** The heading of points that are not fitted yet. */
function unfitted({ title, count: points }: Preview): HTMLElement {
  return el("section", { class: "label whole" }, el("div", { class: "head" }, el("h2", {}, title)), el("p", { class: "state" }, `${count(points)} points, not fitted yet`));
}

/** What there is to do where there is nothing; it is seen after a moment. */
function nothing(): HTMLElement {
  return el("section", { class: "label whole empty" }, el("div", { class: "head" }, el("h2", {}, "Nothing here yet")), el("p", {}, "Drop a file of points anywhere on the page, choose one under Data, or open an example."));
}

function about(app: App, fitView: FitView, many: boolean, isNarrow: boolean, difference: number | null): Node[] {
  const { fit } = fitView;
  const close = el("button", { type: "button", class: "icon", "aria-label": `Take ${fit.title} off the screen`, onclick: () => app.close(fit.id) }, icon("close"));
  const isFront = app.view.value.front === fit.id;
  const forward = el("button", { type: "button", class: "forward", title: "Draw it before the others", "aria-pressed": String(isFront), onclick: () => app.view.set({ front: isFront ? null : fit.id }) }, fit.title);
  const head = el("div", { class: "head" }, el("h2", {}, many && app.view.value.overlaid ? forward : fit.title), many && close);
  const k = fitView.shownOf(app.view.value);
  const level = fitView.held ?? fit.levels[k];
  const error = short(level?.error.max);
  const state = el("p", { class: "state", "data-state": fit.latest < 0 && fit.problem !== null ? "failed" : stateOf(fitView) }, isNarrow ? standing(fitView) : described(fitView, k, error));
  const advice = fit.latest < 0 && isGone(fit.problem) && el("p", {}, "It may have been deleted. Open an example, another job, or points of your own.");
  const warnings = many ? [] : (fit.job?.status.warnings ?? []).map(({ detail }) => el("p", { class: "warning" }, fromOne(detail)));
  return [head, ...(many ? [] : [el("p", { class: "how" }, how(fit, level?.controls ?? fit.head?.control_points ?? 0))]), state, ...(advice ? [advice] : []), ...warnings, ...(isNarrow && fit.latest >= 0 ? [el("p", {}, `error ${error}`)] : []), ...scales(app, fitView, difference)];
}

/** "B-spline surface of degree 3 × 3, 24 × 18 control points, global"; the count is that of an iteration. */
function how({ head }: Fit, controls: Counts): string {
  if (head === null) return "";
  const names: Readonly<Record<api.BasisKind, string>> = { bspline: "B-spline", bernstein: "Bézier", said_ball: "Said–Ball", wang_ball: "Wang–Ball" };
  const of = <T,>(value: T | { u: T; v: T }): T => (typeof value === "object" && value !== null && "u" in value ? value.u : value);
  const degree = typeof head.degree === "number" ? String(head.degree) : `${head.degree.u} × ${head.degree.v}`;
  const control = typeof controls === "number" ? count(controls) : `${count(controls.u)} × ${count(controls.v)}`;
  const method = head.method.kind.replace("_", " ");
  return `${names[of(head.basis)]} ${head.kind} of degree ${degree}, ${control} control points, ${method}`;
}

function stateOf({ held, fit: { end, job } }: FitView): api.JobState {
  return held === null ? (end?.state ?? job?.status.state ?? "queued") : "running";
}

/** How the job stands, or that it is not the job that is seen. */
function standing({ held, fit }: FitView): string {
  const { end, latest, problem } = fit;
  if (held !== null) return "preview of the edit";
  const { slow } = fit;
  if (slow !== null) return `running for ${count(Math.round(slow))} s, ${latest < 0 ? "no iteration yet" : `iteration ${count(latest + 1)} takes long`}`;
  if (latest < 0) return problem === null ? "…" : isGone(problem) ? "not there" : "not reached";
  if (end === null) return `running, iteration ${count(latest)}`;
  return `${STATES[end.state]} in ${count(end.iterations)} ${end.iterations === 1 ? "iteration" : "iterations"}`;
}

/** How the job stands, with the error of what is seen, and which iteration that is if it is not the last. */
function described(fitView: FitView, k: number, error: string): string {
  const { held, fit } = fitView;
  if (held !== null) return `${standing(fitView)}, iteration ${count(held.number)}, error ${error}`;
  if (fit.latest < 0) return standing(fitView);
  if (k >= fit.latest) return `${standing(fitView)}, error ${error}${reason(fit)}`;
  return `${standing(fitView)}${reason(fit)}; shown: iteration ${count(k)}, error ${error}`;
}

/** Why a job has ended that has not converged. */
function reason({ end }: Fit): string {
  const why = end?.state === "stalled" || end?.state === "failed" ? (end.problem?.detail ?? end.detail) : null;
  return why ? `: ${why}` : "";
}

/** How much things are enlarged, and what colours mean. */
function scales(app: App, { fit, shown, data }: FitView, difference: number | null): Node[] {
  const { layers } = app.view.value;
  const notes: Node[] = [];
  if (fit.outline !== null) notes.push(el("p", { class: "trimmed" }, trimmed(fit.outline, shown?.k === fit.latest)));
  if (shown?.isAway) notes.push(el("p", {}, `It is too far from the data to be ${data?.isSurface ? "drawn" : "seen as a whole"}.`));
  if (layers.spikes && shown !== null && shown.spikeScale > 0) notes.push(el("p", { class: "scale" }, `error vectors × ${big(shown.spikeScale)}`));
  if (layers.comb && shown !== null && shown.combScale > 0) notes.push(el("p", { class: "scale" }, `curvature${between(shown.curvature?.range)}: 1 is drawn ${short(shown.combScale)} long`));
  const outliers = data?.outliers.length ?? 0;
  if (outliers > 0) notes.push(el("p", {}, `${count(outliers)} ${outliers === 1 ? "outlier is" : "outliers are"} left out`));
  const isFirst = app.fits.shown[0] === fit;
  const legend = difference === null ? shown?.legend : { title: `Distance from ${app.fits.shown[0]?.title}`, values: [difference / 1000, difference / Math.sqrt(1000), difference] };
  if (legend != null && isFirst) {
    const [low, , high] = legend.values;
    const ticks = legend.values.map((value) => el("span", {}, short(value, 2)));
    const name = `${legend.title}, from ${short(low)} to ${short(high)}`;
    notes.push(el("div", { class: "legend", role: "img", "aria-label": name }, el("div", { class: "title", "aria-hidden": "true" }, legend.title), el("div", { class: "ramp" }), el("div", { class: "ticks" }, ...ticks)));
  }
  return notes;
}

/** What is left of a trimmed surface; the area is that of the last iteration. */
function trimmed({ loops, pieces, holes, area }: Outline, isLast: boolean): string {
  const counted = (number: number, one: string) => `${count(number)} ${one}${number === 1 ? "" : "s"}`;
  const left = loops.length === 0 ? "nothing is cut off" : [counted(pieces, "piece"), ...(holes > 0 ? [counted(holes, "hole")] : [])].join(", ");
  return `trimmed to the data: ${left}${isLast && area !== null ? `, area ${short(area, 4)}` : ""}`;
}

/** " from −2 to 3.1"; nothing where the server has not said it. */
function between(range: readonly [number | null, number | null] | undefined): string {
  return range === undefined || range[0] === null ? "" : ` from ${short(range[0])} to ${short(range[1])}`;
}

function big(value: number): string {
  return value >= 1 && value < 1e6 ? count(value) : short(value);
}
