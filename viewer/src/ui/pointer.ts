/** Numbers under the pointer. */

import type { App } from "../app.js";
import { type Data, among, placeOf } from "../fit/data.js";
import type { Samples } from "../fit/geometry.js";
import { el } from "../html.js";
import type { Cell } from "../scene/cell.js";
import type { FitView } from "../scene/fit-view.js";
import type { SceneController } from "../scene/scene-controller.js";
import type { Place } from "../state.js";
import { axisName, placeName, short } from "../text/numbers.js";

// How near the pointer has to come, in pixels.
export const NEAR = 13;
// The pointer goes less far in a click than this, in pixels.
const STILL = 4;
// Where the pointer rests this long the curvature is asked for, in milliseconds.
const REST = 250;

/** What is under the pointer. */
export interface Found {
  readonly fitView: FitView;
  readonly what: "data" | "sample";
  /** The number of the point. */
  readonly index: number;
  /** In scene coordinates of the figure. */
  readonly position: readonly [number, number, number];
}

/** The data point or the point of the fit that is seen nearest to a place on the canvas. */
export function find(scene: SceneController, x: number, y: number, only?: "data", reach = NEAR): Found | null {
  const cells = scene.viewport.cells();
  const found = scene.fitViews.flatMap((fitView, i) => {
    const cell = cells[i];
    const isIn = cell !== undefined && x >= cell.x && x < cell.x + cell.width && y >= cell.y && y < cell.y + cell.height;
    return isIn ? (findOf(scene, fitView, cell, x, y, only, reach) ?? []) : [];
  });
  return found.reduce<(Found & Near) | null>((best, one) => (best === null || one.depth < best.depth ? one : best), null);
}

function findOf(scene: SceneController, fitView: FitView, cell: Cell, x: number, y: number, only: "data" | undefined, reach: number): (Found & Near) | null {
  const { figure, data, shown } = fitView;
  if (data === null || shown === null) return null;
  const look = (positions: Float32Array, pull: number, inside: Uint8Array | null) => nearest(scene, figure.group.matrixWorld.elements, positions, inside, x - cell.x, y - cell.y, cell, reach, pull);
  const point = look(data.positions, 0.02, null);
  const sample = only === "data" ? null : look(shown.samples.positions, 0, figure.cut?.inside ?? null);
  // A data point that lies on the fit or before it is meant rather than the fit.
  if (point !== null && (sample === null || point.depth <= sample.depth + 0.03)) return { fitView, what: "data", ...point };
  return sample === null ? null : { fitView, what: "sample", ...sample };
}

interface Near {
  readonly index: number;
  readonly position: readonly [number, number, number];
  readonly depth: number;
}

/** Of the points within reach those in front count most. Points that are not inside are not seen. */
function nearest(scene: SceneController, world: ArrayLike<number>, positions: Float32Array, inside: Uint8Array | null, x: number, y: number, cell: { width: number; height: number }, reach: number, pull: number): Near | null {
  const { perspective: camera } = scene.viewport.camera;
  camera.updateMatrixWorld();
  const m = camera.projectionMatrix.clone().multiply(camera.matrixWorldInverse).elements;
  const s = world[0]!;
  const [tx, ty, tz] = [world[12]!, world[13]!, world[14]!];
  let best = -1;
  let score = Infinity;
  let depth = 0;
  for (let i = 0; i < positions.length; i += 3) {
    if (inside !== null && inside[i / 3] === 0) continue;
    const px = positions[i]! * s + tx;
    const py = positions[i + 1]! * s + ty;
    const pz = positions[i + 2]! * s + tz;
    const w = m[3]! * px + m[7]! * py + m[11]! * pz + m[15]!;
    if (!(w > 0)) continue;
    const dx = (((m[0]! * px + m[4]! * py + m[8]! * pz + m[12]!) / w) * 0.5 + 0.5) * cell.width - x;
    const dy = (0.5 - ((m[1]! * px + m[5]! * py + m[9]! * pz + m[13]!) / w) * 0.5) * cell.height - y;
    const away = Math.hypot(dx, dy);
    if (away > reach) continue;
    const now = (away / reach) * 0.08 + w - pull;
    if (now >= score) continue;
    [best, score, depth] = [i, now, w];
  }
  if (best < 0) return null;
  return { index: best / 3, position: [positions[best]!, positions[best + 1]!, positions[best + 2]!], depth };
}

/** Shows the numbers of what the pointer is over. */
export function pointer(app: App, scene: SceneController, root: HTMLElement, isBusy: () => boolean): void {
  const tip = el("div", { class: "tip", id: "tip", hidden: true });
  root.append(tip);
  const { canvas } = scene.viewport;
  let last: PointerEvent | null = null;
  let frame = 0;
  let marked: FitView | null = null;
  let resting = 0;
  const clear = () => {
    last = null;
    clearTimeout(resting);
    tip.hidden = true;
    if (isBusy()) return;
    marked?.figure.mark(null);
    if (marked !== null) scene.viewport.invalidate();
    marked = null;
    canvas.classList.remove("grabs");
  };
  const show = () => {
    frame = 0;
    if (last === null || isBusy()) return;
    const { offsetX: x, offsetY: y } = last;
    const found = last.buttons === 0 ? find(scene, x, y) : null;
    canvas.classList.toggle("grabs", found?.what === "data" && (app.view.value.editing || last.altKey));
    if (marked !== null || found !== null) scene.viewport.invalidate();
    if (marked !== found?.fitView) marked?.figure.mark(null);
    marked = found?.fitView ?? null;
    found?.fitView.figure.mark(found.position);
    tip.hidden = found === null;
    if (found === null) return;
    clearTimeout(resting);
    resting = window.setTimeout(() => found.fitView.curvature(true, () => frame ||= requestAnimationFrame(show)), REST);
    tip.replaceChildren(...facts(found, scene.fitViews.length > 1).map(([name, value]) => el("div", {}, el("span", {}, name), el("b", {}, value))));
    const right = x > root.clientWidth - tip.offsetWidth - 30;
    tip.style.left = `${right ? x - tip.offsetWidth - 14 : x + 18}px`;
    tip.style.top = `${Math.max(4, Math.min(y + 14, root.clientHeight - tip.offsetHeight - 8))}px`;
  };
  canvas.addEventListener("pointermove", (event) => {
    last = event;
    frame ||= requestAnimationFrame(show);
  });
  let pressed: readonly [number, number] | null = null;
  canvas.addEventListener("pointerdown", ({ offsetX, offsetY }) => (pressed = [offsetX, offsetY]));
  canvas.addEventListener("pointerup", ({ offsetX, offsetY, pointerType }) => {
    const { overlaid, measuring, editing } = app.view.value;
    if (!overlaid || measuring || editing || pressed === null || Math.hypot(offsetX - pressed[0], offsetY - pressed[1]) > STILL) return;
    const found = find(scene, offsetX, offsetY, undefined, pointerType === "touch" ? 24 : undefined);
    if (found !== null && scene.fitViews.length > 1) app.view.set({ front: found.fitView.fit.id });
  });
  app.view.subscribe((now, before) => now.jobs !== before.jobs && clear());
  canvas.addEventListener("pointerleave", clear);
  canvas.addEventListener("pointerdown", clear);
}

function facts({ fitView, what, index }: Found, isNamed: boolean): [string, string][] {
  const { data, shown, fit } = fitView;
  if (data === null || shown === null) return [];
  const { samples } = shown;
  const lengths = fitView.distances()?.lengths;
  const curvature = fitView.curvature(false, () => {});
  const bends = (sample: number): [string, string][] => {
    if (curvature === null || sample < 0) return [];
    const [first, second] = [short(curvature.first[sample]), short(curvature.second?.[sample])];
    return curvature.second === null ? [["curvature", first]] : [["curvatures", `${first}, ${second}`]];
  };
  const name: [string, string][] = isNamed ? [["of", fit.title]] : [];
  const coordinates = (list: ArrayLike<number>, at: number, dimension: number) =>
    Array.from({ length: dimension }, (_, axis) => [axisName(axis, dimension), short(list[at * dimension + axis], 5)] as [string, string]);
  if (what === "data") {
    const place = placeOf(data, index);
    const weight = data.weights?.[index];
    const worst = samePlace(fit.levels[shown.k]?.error.at as Place | undefined, place);
    const far = worst ? fit.levels[shown.k]?.error.max : lengths?.[index];
    return [
      ...name,
      ["point", placeName(place)],
      ...coordinates(data.exact, index, data.dimension),
      ...(weight === undefined ? [] : [["weight", short(weight)] as [string, string]]),
      ...(far === undefined ? [] : [["error", worst ? `${short(far)}, the largest` : short(far)] as [string, string]]),
      ...(data.outliers.includes(index) ? [["", "an outlier, left out"] as [string, string]] : []),
      ...bends(sampleAt(data, samples, index)),
    ];
  }
  const [u, v] = samples.parameters;
  const parameters: [string, string][] = v === undefined
    ? [["t", short(u[index], 5)]]
    : [["u", short(u[Math.floor(index / samples.columns)], 5)], ["v", short(v[index % samples.columns], 5)]];
  const far = lengths?.[pointAt(data, samples, index)];
  return [...name, ...parameters, ...coordinates(samples.exact, index, samples.dimension), ...(far === undefined ? [] : [["error near it", short(far)] as [string, string]]), ...bends(index)];
}

/** The sample at the parameters of a data point; -1 where these are not known. */
function sampleAt(data: Data, samples: Samples, index: number): number {
  const [us, vs] = samples.parameters;
  const nearest = (list: Float64Array, t: number | undefined) => Math.round((((t ?? NaN) - list[0]!) / (list.at(-1)! - list[0]!)) * (list.length - 1));
  const [u, v] = data.isScattered || !data.isSurface ? [index, index] : [Math.floor(index / data.columns), index % data.columns];
  const column = nearest(vs ?? us, data.parameters[vs === undefined ? 0 : 1]?.[v]);
  const at = vs === undefined ? column : nearest(us, data.parameters[0]?.[u]) * samples.columns + column;
  return Number.isFinite(at) ? at : -1;
}

/** The data point nearest to a sample by their parameters; -1 of scattered points. */
function pointAt(data: Data, samples: Samples, index: number): number {
  const [us, vs] = samples.parameters;
  if (data.isScattered || data.parameters[0]?.length === 0) return -1;
  const nearest = (axis: 0 | 1, list: Float64Array, at: number, count: number) => Math.round(among(data.parameters[axis]!, list[at]!, list.at(-1)!)) % count;
  if (vs === undefined) return nearest(0, us, index, data.columns);
  return nearest(0, us, Math.floor(index / samples.columns), data.rows) * data.columns + nearest(1, vs, index % samples.columns, data.columns);
}

function samePlace(a: Place | readonly number[] | null | undefined, b: Place): boolean {
  return a !== null && a !== undefined && String(a) === String(b);
}
