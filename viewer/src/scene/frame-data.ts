/** What has to be known of an iteration to draw it. */

import { curvature, round125 } from "../fit/comb.js";
import { type Curvatures, curvatureOf } from "../fit/curvature.js";
import { type Data, chosen } from "../fit/data.js";
import type { Fit } from "../fit/fit.js";
import { type Points, type Samples, sampling } from "../fit/geometry.js";
import { type Distances, distances, excessAt, heatAlong, heatAt, heatOf } from "../fit/distances.js";
import type { Layers } from "../state.js";
import type { Frame } from "./figure.js";

/** How an iteration is looked at. */
export interface Look {
  readonly layers: Layers;
  readonly zoom: number;
  readonly cells: number;
  /** True if all fits have as many samples, so that they can be compared. */
  readonly isCommon: boolean;
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
  /** As the server has computed it; null where it was not asked for. */
  readonly curvature: Curvatures | null;
  /** What the colours mean; null without colours. */
  readonly legend: Legend | null;
}

/** The scale of the colours. */
export interface Legend {
  readonly title: string;
  /** At the left, in the middle and at the right. */
  readonly values: readonly [number, number, number];
}

// How long the longest error vectors may be, in radii of the data: at most a tenth of the view.
const SPIKE = 0.16;
// How long the teeth of a comb may be, in radii of the data.
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
    fit.excesses(k, layers.between && !look.isPlaying),
  ]);
  // While iterations follow each other differences are enough.
  const bends = layers.comb && !look.isPlaying ? await curvatureOf(fit, data, k, samples) : null;
  return frameDataOf(fit, data, k, samples, control, layers, look.largest, excesses, bends);
}

/** What is drawn of samples that are here. */
export function frameDataOf(fit: Fit, data: Data, k: number, samples: Samples, control: Points | null, layers: Layers, largest = 0, excesses: readonly number[] = [], bends: Curvatures | null = null): FrameData {
  const level = fit.levels[k];
  const hasGaps = data.isSurface && !data.isScattered && data.exact.some(Number.isNaN);
  const needed = (layers.spikes || layers.heat || hasGaps) && data.exact.length > 0;
  const far = needed && level !== undefined ? distances(data, samples, level.error.max ?? Infinity) : null;
  const [near, most] = range(fit);
  const spikes = layers.spikes && far !== null ? spikesOf(data, far, Math.max(largest, level?.error.max ?? 1)) : null;
  const comb = layers.comb && !data.isSurface ? combOf(data, samples, bends) : null;
  const between = excesses.length > 0 && data.exact.length > 0 ? excessAt(data, excesses, samples) : null;
  const colours = coloursOf(data, samples, layers, far, between, bends, near, most);
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
    heat: colours?.heat ?? null,
    legend: colours?.legend ?? null,
    curvature: bends,
    gaps: hasGaps && far !== null ? gapsOf(data, far) : null,
  };
}

/** The colours of the samples: distances, what is between the data, or the curvature of a surface. */
function coloursOf(data: Data, samples: Samples, layers: Layers, far: Distances | null, between: Float64Array | null, bends: Curvatures | null, near: number, most: number): { heat: Float32Array; legend: Legend } | null {
  const legend = (title: string) => ({ title, values: [near, Math.sqrt(near * most), most] as const });
  if (layers.heat && far !== null) {
    const heat = (data.isSurface ? heatAt : heatAlong)(data, far.lengths, between, samples, near, most);
    return { heat, legend: legend("Distance from the data") };
  }
  if (!data.isSurface) return null;
  if (layers.between && between !== null) return { heat: Float32Array.from(between, (excess) => heatOf(excess, near, most)), legend: legend("Deviation between the data") };
  if (!layers.comb || bends === null) return null;
  const values = Float64Array.from(bends.first, (k1, i) => Math.max(Math.abs(k1), Math.abs(bends.second?.[i] ?? 0)));
  const sorted = values.filter(Number.isFinite).sort();
  // A few sharp bends would leave one colour for all else.
  const top = sorted[Math.floor((sorted.length - 1) * 0.98)] || 1;
  return { heat: Float32Array.from(values, (value) => Math.min(1, value / top) || 0), legend: { title: "Largest principal curvature", values: [0, top / 2, top] } };
}

/** Where the fit is at the points that a grid has not. */
function gapsOf(data: Data, { at }: Distances): Float32Array {
  const { dimension, rows, columns } = data;
  const all = data.axes.positions(at, { rows, columns, dimension }, data.parameters as never);
  const missing = Array.from({ length: rows * columns }, (_, i) => i).filter((i) => Number.isNaN(data.exact[i * dimension]));
  return Float32Array.from(missing.flatMap((i) => Array.from(all.subarray(i * 3, i * 3 + 3))));
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
export function mayApproximate({ heat, spikes, comb, between }: Layers): boolean {
  return !heat && !spikes && !comb && !between;
}

/** How finely an iteration is sampled. */
export function samplesOf(data: Data, { zoom, cells, isCommon }: Pick<Look, "zoom" | "cells"> & Partial<Look>): string | number {
  if (isCommon === true) return data.isSurface ? "96x96" : 2000;
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

function spikesOf(data: Data, { at, lengths }: Distances, largest: number): { segments: Float32Array; scale: number } {
  const { axes, dimension, rows, columns } = data;
  const scale = Math.max(1, round125((SPIKE * axes.radius) / largest));
  const grid = { rows, columns, dimension };
  const from = axes.positions(at, grid, data.parameters as never);
  const shown = chosen(data, MOST_SPIKES);
  const segments = new Float32Array(shown.length * 6);
  for (let to = 0; to < shown.length; to++) {
    const i = shown[to]!;
    const span = Math.hypot(...Array.from({ length: dimension }, (_, axis) => data.exact[i * dimension + axis]! - at[i * dimension + axis]!));
    // Between samples there is more than an error of 10⁻⁹ that the cubic gets wrong: no vector is longer than the largest error.
    const shorter = span > lengths[i]! ? lengths[i]! / span : 1;
    for (let axis = 0; axis < 3; axis++) {
      const foot = from[i * 3 + axis]!;
      // 32 bits do not tell near points apart: the difference is that of the exact numbers.
      const value = dimension === 1 ? (axis === (data.isSurface ? 2 : 1) ? 0 : -1) : axis < dimension ? axis : -1;
      const way = value < 0 ? 0 : (data.exact[i * dimension + value]! - at[i * dimension + value]!) * shorter;
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

function combOf(data: Data, samples: Samples, bends: Curvatures | null): { teeth: Float32Array; edge: Float32Array; scale: number } {
  const { positions, exact, dimension } = samples;
  const { vectors, most } = curvature(dimension === 1 ? positions : threeOf(exact, dimension));
  if (bends !== null) stretch(vectors, bends.first);
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

/** Gives vectors the lengths that the server has computed. */
function stretch(vectors: Float32Array, lengths: Float64Array): void {
  for (let i = 0; i < lengths.length; i++) {
    const now = Math.hypot(vectors[i * 3]!, vectors[i * 3 + 1]!, vectors[i * 3 + 2]!);
    const factor = Math.abs(lengths[i]!) / now;
    if (Number.isFinite(factor)) for (let axis = 0; axis < 3; axis++) vectors[i * 3 + axis]! *= factor;
  }
}

function threeOf(exact: Float64Array | Float32Array, dimension: number): Float64Array {
  const count = exact.length / dimension;
  const three = new Float64Array(count * 3);
  for (let i = 0; i < count; i++) for (let axis = 0; axis < dimension; axis++) three[i * 3 + axis] = exact[i * dimension + axis]!;
  return three;
}
