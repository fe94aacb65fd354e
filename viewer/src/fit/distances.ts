/** How far a fit is from its data, point by point, from samples. */

import { type Data, among } from "./data.js";
import type { Samples } from "./geometry.js";

/** Where the fit is at the parameters of each data point, and how far from it. */
export interface Distances {
  /** As `data.exact`. */
  readonly at: Float64Array;
  readonly lengths: Float64Array;
}

/**
 * Between samples the fit is taken as the cubic through four of them. The largest distance, which the server
 * has computed, bounds what that gets wrong.
 */
export function distances(data: Data, samples: Samples, largest: number): Distances {
  const { dimension, exact } = data;
  const count = exact.length / dimension;
  const at = new Float64Array(exact.length);
  const lengths = new Float64Array(count);
  const parameters = parametersOf(data);
  const ways = data.isSurface ? [samples.parameters[0], samples.parameters[1]!] : [null, samples.parameters[0]];
  for (let i = 0; i < count; i++) {
    const [u, v] = parameters(i);
    const rows = ways[0] === null ? ONE : stencil(ways[0]!, u);
    const columns = stencil(ways[1]!, v);
    let sum = 0;
    for (let axis = 0; axis < dimension; axis++) {
      let value = 0;
      for (let a = 0; a < rows.weights.length; a++) {
        const row = (rows.first + a) * samples.columns;
        let inner = 0;
        for (let b = 0; b < columns.weights.length; b++) {
          inner += columns.weights[b]! * samples.exact[(row + columns.first + b) * dimension + axis]!;
        }
        value += rows.weights[a]! * inner;
      }
      at[i * dimension + axis] = value;
      sum += (value - exact[i * dimension + axis]!) ** 2;
    }
    lengths[i] = Math.min(Math.sqrt(sum), largest);
  }
  return { at, lengths };
}

/** The parameters of each data point: of rows and columns, or its own. */
function parametersOf({ parameters, columns, isSurface, isScattered }: Data): (i: number) => readonly [number, number] {
  const [first, second] = parameters;
  if (!isSurface) return (i) => [0, first?.[i] ?? NaN];
  if (isScattered) return (i) => [first?.[i] ?? NaN, second?.[i] ?? NaN];
  return (i) => [first?.[Math.floor(i / columns)] ?? NaN, second?.[i % columns] ?? NaN];
}

interface Stencil {
  readonly first: number;
  readonly weights: readonly number[];
}

const ONE: Stencil = { first: 0, weights: [1] };

/** Lagrange's weights of the four samples around a parameter. */
function stencil(parameters: Float64Array, t: number): Stencil {
  const count = parameters.length;
  const [begin, end] = [parameters[0]!, parameters[count - 1]!];
  const x = ((t - begin) / (end - begin)) * (count - 1);
  const size = Math.min(4, count);
  const first = Math.max(0, Math.min(count - size, Math.floor(x) - 1));
  const weights = Array.from({ length: size }, (_, a) => {
    let weight = 1;
    for (let b = 0; b < size; b++) if (b !== a) weight *= (x - first - b) / (a - b);
    return weight;
  });
  return { first, weights };
}

/** A distance on a scale of powers of ten: 0 is near, 1 is far. */
export function heatOf(distance: number, near: number, far: number): number {
  if (!(distance > near)) return 0;
  return Math.min(1, Math.log(distance / near) / Math.log(far / near));
}

/** By how much the fit leaves its data at each sample: as in the gap, or cell of a grid, that it lies in. */
export function excessAt(data: Data, excesses: readonly number[], samples: Samples): Float64Array {
  const [first, second] = samples.parameters as [Float64Array, Float64Array | undefined];
  const gaps = (axis: 0 | 1, samples: Float64Array) => {
    const own = data.parameters[axis]!;
    const count = Math.max(1, own.length - (data.closed[axis] ? 0 : 1));
    return { count, of: Array.from(samples, (t) => Math.min(count - 1, Math.floor(among(own, t, samples.at(-1)!)))) };
  };
  const along = gaps(0, first);
  const across = second === undefined ? { count: 1, of: [0] } : gaps(1, second);
  return Float64Array.from({ length: along.of.length * across.of.length }, (_, i) => {
    const [row, column] = [along.of[Math.floor(i / across.of.length)]!, across.of[i % across.of.length]!];
    return excesses[row * across.count + column] ?? 0;
  });
}

/** The same along a curve. */
export function heatAlong(data: Data, lengths: Float64Array, excesses: Float64Array | null, samples: Samples, near: number, far: number): Float32Array {
  const [own, all] = [data.parameters[0]!, samples.parameters[0]];
  const log = Array.from(lengths, (length) => heatOf(length, near, far));
  return Float32Array.from(all, (t, i) => {
    const [a, s] = between(own, t, all.at(-1)!);
    const value = (1 - s) * (log[a % log.length] ?? 0) + s * (log[(a + 1) % log.length] ?? 0);
    return Math.max(value, heatOf(excesses?.[i] ?? 0, near, far));
  });
}

/** How far samples are from those of another fit with the same parameters, which have as many; null if they have not. */
export function apart(samples: Samples, others: Samples): Float64Array | null {
  const { rows, columns, dimension, exact } = samples;
  if (others.rows !== rows || others.columns !== columns || others.dimension !== dimension) return null;
  return Float64Array.from({ length: rows * columns }, (_, i) => {
    let sum = 0;
    for (let at = i * dimension; at < (i + 1) * dimension; at++) sum += (exact[at]! - others.exact[at]!) ** 2;
    return Math.sqrt(sum);
  });
}

/** The distances of the data, and by how much the surface leaves these at each sample, as colours of the samples. */
export function heatAt(data: Data, lengths: Float64Array, excesses: Float64Array | null, samples: Samples, near: number, far: number): Float32Array {
  const grid = { rows: data.rows, columns: data.columns, values: lengths, u: data.parameters[0]!, v: data.parameters[1]! };
  const field = data.isScattered ? binned(data, lengths) : grid;
  const heat = new Float32Array(samples.rows * samples.columns);
  const [us, vs = new Float64Array(0)] = samples.parameters;
  const values = field.values.some(Number.isNaN) ? filled(field.values, field.rows, field.columns) : field.values;
  const log = Array.from(values, (value) => heatOf(value, near, far));
  const columns = Array.from(vs, (v) => between(field.v, v, vs.at(-1)!));
  for (let i = 0, to = 0; i < samples.rows; i++) {
    const [a, s] = between(field.u, us[i]!, us.at(-1)!);
    for (let j = 0; j < samples.columns; j++, to++) {
      const [b, t] = columns[j]!;
      const value = (r: number, c: number) => log[(r % field.rows) * field.columns + (c % field.columns)] || 0;
      const at = (1 - s) * ((1 - t) * value(a, b) + t * value(a, b + 1)) + s * ((1 - t) * value(a + 1, b) + t * value(a + 1, b + 1));
      heat[to] = Math.max(at, heatOf(excesses?.[to] ?? 0, near, far));
    }
  }
  return heat;
}

/** After which of the parameters another one comes, and how far it is to the next. */
function between(parameters: Float64Array, t: number, end: number): [number, number] {
  const at = among(parameters, t, end);
  return [Math.floor(at), at % 1];
}

/** Scattered points in cells, each with its largest distance; NaN without points. */
function binned(data: Data, lengths: Float64Array) {
  const [us, vs] = data.parameters as [Float64Array, Float64Array];
  const size = Math.max(4, Math.min(64, Math.round(Math.sqrt(lengths.length) / 1.5)));
  const range = (list: Float64Array) => list.reduce(([a, b], x) => [Math.min(a, x), Math.max(b, x)] as [number, number], [Infinity, -Infinity] as [number, number]);
  const [[u0, u1], [v0, v1]] = [range(us), range(vs)];
  const values = new Float64Array(size * size).fill(NaN);
  lengths.forEach((length, i) => {
    const row = Math.round(((us[i]! - u0) / (u1 - u0)) * (size - 1));
    const column = Math.round(((vs[i]! - v0) / (v1 - v0)) * (size - 1));
    const at = row * size + column;
    if (!(values[at]! >= length)) values[at] = length;
  });
  const steps = (a: number, b: number) => Float64Array.from({ length: size }, (_, i) => a + ((b - a) * i) / (size - 1));
  return { rows: size, columns: size, values, u: steps(u0, u1), v: steps(v0, v1) };
}

/** Where there is nothing it is as around it. */
function filled(given: Float64Array, rows: number, columns: number): Float64Array {
  let values = given;
  for (let pass = 0; pass < rows + columns && values.some(Number.isNaN); pass++) {
    values = values.map((value, at) => {
      if (!Number.isNaN(value)) return value;
      const [row, column] = [Math.floor(at / columns), at % columns];
      const near = [row > 0 && at - columns, row + 1 < rows && at + columns, column > 0 && at - 1, column + 1 < columns && at + 1];
      const known = near.flatMap((n) => (n === false ? [] : [values[n]!])).filter((x) => !Number.isNaN(x));
      return known.length === 0 ? NaN : known.reduce((a, b) => a + b) / known.length;
    });
  }
  return values;
}
