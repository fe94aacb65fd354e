/** What has to be known of an iteration to draw it. */

import { curvature, round125 } from "../fit/comb.js";
import { type Data, chosen } from "../fit/data.js";
import type { Fit } from "../fit/fit.js";
import { type Points, type Samples, sampling } from "../fit/geometry.js";
import { type Distances, distances, excessAt, heatAt } from "../fit/distances.js";
import type { Layers } from "../state.js";
import type { Frame } from "./figure.js";

/** How an iteration is looked at. */
export interface Look {
  readonly layers: Layers;
  readonly zoom: number;
  readonly cells: number;
  /** The largest distance of all fits that are drawn; 0 with one of them, and where there are no spikes. */
  readonly largest: number;
  /** True while iterations follow each other, and each is seen for a moment. */
  readonly isPlaying: boolean;
}

/** A picture, and the numbers behind it. */
export interface FrameData extends Frame {
  readonly k: number;
  readonly distances: Distances | null;
  /** How much longer spikes are than the distances; 0 without. */
  readonly spikeScale: number;
  /** How long the tooth of a curvature of one is, in units of the data; 0 without. */
  readonly combScale: number;
}

// How long the longest spikes and teeth may be, in radii of the data.
const SPIKE = 0.22;
const TOOTH = 0.26;
// An error of so many radii of the data leaves the view: each triangle of such a surface would cover all of it.
const AWAY = 30;
// Errors so many times larger than the first one have the colour of the largest.
const OVERSHOOT = 100;
// More spikes are a fur.
const MOST_SPIKES = 20_000;
// A longer edge would be more than anybody sees.
const TEETH = 1500;

/** Asks for what is drawn of an iteration. */
export async function loadFrame(fit: Fit, data: Data, k: number, look: Look): Promise<FrameData> {
  const { layers } = look;
  const [samples, control, excesses] = await Promise.all([
    samplesFor(fit, data, k, look),
    layers.polygon && data.dimension > 1 ? controlFor(fit, data, k, look) : null,
    fit.excesses(k),
  ]);
  return frameDataOf(fit, data, k, samples, control, layers, look.largest, excesses);
}

/** What is drawn of samples that are here. */
export function frameDataOf(fit: Fit, data: Data, k: number, samples: Samples, control: Points | null, layers: Layers, largest = 0, excesses: readonly number[] = []): FrameData {
  const level = fit.levels[k];
  const needed = (layers.spikes || layers.heat) && data.exact.length > 0;
  const far = needed && level !== undefined ? distances(data, samples, level.error.max ?? Infinity) : null;
  const [near, most] = range(fit);
  const spikes = layers.spikes && far !== null ? spikesOf(data, far, Math.max(largest, level?.error.max ?? 1)) : null;
  const comb = layers.comb && !data.isSurface ? combOf(data, samples) : null;
  const between = excesses.length > 0 && data.exact.length > 0 ? excessAt(data, excesses, samples) : null;
  const heat = layers.heat && far !== null && data.isSurface ? heatAt(data, far.lengths, between, samples, near, most) : null;
  return {
    k,
    samples,
    // The server finds the outline before the fit, and trims the files of all iterations by it. So all are drawn trimmed as
    // soon as the result has come, which says it; until then they are drawn whole.
    outline: fit.outline,
    isAway: !((level?.error.max ?? Infinity) < AWAY * data.axes.radius),
    control,
    distances: far,
    spikes: spikes?.segments ?? null,
    spikeScale: spikes?.scale ?? 0,
    astray: between !== null && !data.isSurface ? astrayOf(between, samples, near) : null,
    comb,
    combScale: comb?.scale ?? 0,
    heat,
  };
}

/** The samples of an iteration, as exact as it has to be seen. */
export function samplesFor(fit: Fit, data: Data, k: number, look: Look): Promise<Samples> {
  const samples = samplesOf(data, look);
  const { layers } = look;
  return look.isPlaying && mayApproximate(layers)
    ? fit.geometry.approximate(k, samples, data.axes)
    : fit.geometry.samples(k, samples, precise(data, layers), data.axes);
}

/** The control points of an iteration. Of several fits no streams of them are open: browsers have six connections to a server. */
function controlFor(fit: Fit, data: Data, k: number, { isPlaying, cells }: Look): Promise<Points> {
  return isPlaying && cells === 1 ? fit.geometry.approximateControl(k, data.axes) : fit.geometry.control(k, data.axes);
}

/** True if nothing is drawn that tells a hundredth of the error. */
export function mayApproximate({ heat, spikes, comb }: Layers): boolean {
  return !heat && !spikes && !comb;
}

/** How finely an iteration is sampled. */
export function samplesOf(data: Data, { zoom, cells }: Pick<Look, "zoom" | "cells">): string | number {
  const [rows, columns] = data.controls;
  return sampling(data.isSurface ? [rows, columns] : [columns], zoom, cells);
}

/** Whether 64 bits are needed; a curve always has them, since its curvature is read from it. */
export function precise(data: Data, layers: Layers): boolean {
  return !data.isSurface || layers.heat || layers.spikes;
}

/** The distances at the two ends of the scale of colours. */
export function range({ levels, head }: Fit): [number, number] {
  const largest = levels.reduce((most, level) => Math.max(most, level?.error.max ?? 0), 0) || 1;
  // Of fits that diverge on their way the scale would be of nothing else.
  const most = Math.min(largest, OVERSHOOT * (levels[0]?.error.max ?? largest)) || largest;
  const least = levels.at(-1)?.error.max ?? most;
  const tolerance = head?.stop.tolerance ?? 0;
  return [Math.min(Math.max(tolerance, most * 1e-12), most / 10) || least, most];
}

function spikesOf(data: Data, { at }: Distances, largest: number): { segments: Float32Array; scale: number } {
  const { axes, dimension, rows, columns } = data;
  const scale = Math.max(1, round125((SPIKE * axes.radius) / largest));
  const grid = { rows, columns, dimension };
  const from = axes.positions(at, grid, data.parameters as never);
  const shown = chosen(data, MOST_SPIKES);
  const segments = new Float32Array(shown.length * 6);
  for (let to = 0; to < shown.length; to++) {
    const i = shown[to]!;
    for (let axis = 0; axis < 3; axis++) {
      const foot = from[i * 3 + axis]!;
      // 32 bits do not tell near points apart: the difference is that of the exact numbers.
      const value = dimension === 1 ? (axis === (data.isSurface ? 2 : 1) ? 0 : -1) : axis < dimension ? axis : -1;
      const way = value < 0 ? 0 : data.exact[i * dimension + value]! - at[i * dimension + value]!;
      segments[to * 6 + axis] = foot;
      // From far away a sum would not arrive at the data point.
      segments[to * 6 + 3 + axis] = scale > 1 ? foot + way * scale : data.positions[i * 3 + axis]!;
    }
  }
  return { segments, scale };
}

/** The segments of a curve between samples where it leaves its data by more than is near. */
function astrayOf(excesses: Float64Array, { positions }: Samples, near: number): Float32Array {
  const from = Array.from(excesses.keys()).filter((i) => i + 1 < excesses.length && excesses[i]! > near);
  const segments = new Float32Array(from.length * 6);
  from.forEach((i, at) => segments.set(positions.subarray(i * 3, i * 3 + 6), at * 6));
  return segments;
}

function combOf(data: Data, samples: Samples): { teeth: Float32Array; edge: Float32Array; scale: number } {
  const { positions, exact, dimension } = samples;
  const { vectors, most } = curvature(dimension === 1 ? positions : threeOf(exact, dimension));
  const scale = most > 0 ? round125((TOOTH * data.axes.radius) / most) : 0;
  const edge = positions.slice();
  // Where most of the curve is far away and all but straight, a few teeth would leave the scene.
  const longest = 10 * TOOTH * data.axes.radius;
  for (let i = 0; i < edge.length; i++) edge[i] = edge[i]! - (Math.max(-longest, Math.min(longest, vectors[i]! * scale)) || 0);
  const count = positions.length / 3;
  const every = Math.max(1, Math.floor(count / Math.min(TEETH, 240)));
  const teeth = new Float32Array(Math.ceil(count / every) * 6);
  for (let i = 0, to = 0; i < count; i += every, to += 6) {
    teeth.set(positions.subarray(i * 3, i * 3 + 3), to);
    teeth.set(edge.subarray(i * 3, i * 3 + 3), to + 3);
  }
  return { teeth, edge, scale };
}

function threeOf(exact: Float64Array | Float32Array, dimension: number): Float64Array {
  const count = exact.length / dimension;
  const three = new Float64Array(count * 3);
  for (let i = 0; i < count; i++) for (let axis = 0; axis < dimension; axis++) three[i * 3 + axis] = exact[i * dimension + axis]!;
  return three;
}
