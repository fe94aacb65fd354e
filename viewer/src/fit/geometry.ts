/** Points as they are drawn. */

import type { SampledIteration, Tensor } from "piad";

import type { Axes } from "./axes.js";

/** Points with three coordinates each, in rows if they are of a surface. */
export interface Points {
  /** For the screen, as seen from the centre of the axes where 32 bits would not be enough for them. */
  readonly positions: Float32Array;
  /** As the server wrote them, `dimension` numbers each. */
  readonly exact: Float64Array | Float32Array;
  readonly dimension: number;
  /** 1 of curves. */
  readonly rows: number;
  readonly columns: number;
}

/** A curve or a surface at equal steps of its parameters. */
export interface Samples extends Points {
  /** The parameters of the columns of a curve; those of the rows and of the columns of a surface. */
  readonly parameters: SampledIteration["parameters"];
}

/** Points of a tensor: `[count, dimension]` or `[rows, columns, dimension]`. */
export function pointsOf({ data, shape }: Tensor, axes: Axes, parameters?: SampledIteration["parameters"]): Points {
  const dimension = shape.at(-1) ?? 0;
  const columns = shape.at(-2) ?? 0;
  const rows = shape.length > 2 ? (shape[0] ?? 0) : 1;
  const grid = { rows, columns, dimension };
  return { ...grid, exact: data, positions: axes.positions(data, grid, parameters) };
}

/** Every so many rows and columns of a grid, and the last ones, so that no more than about `most` points are left. Lines stay whole. */
export function thinned(points: Points, most: number): Points {
  const { rows, columns, dimension, positions, exact } = points;
  const step = Math.ceil(Math.sqrt((rows * columns) / most));
  if (rows < 2 || step < 2) return points;
  const some = (count: number) => [...Array(Math.ceil((count - 1) / step)).keys()].map((i) => i * step).concat(count - 1);
  const [down, across] = [some(rows), some(columns)];
  const left = { positions: new Float32Array(down.length * across.length * 3), exact: new Float64Array(down.length * across.length * dimension) };
  let to = 0;
  for (const i of down) {
    for (const j of across) {
      const from = i * columns + j;
      left.positions.set(positions.subarray(from * 3, from * 3 + 3), to * 3);
      left.exact.set(exact.subarray(from * dimension, (from + 1) * dimension), to * dimension);
      to++;
    }
  }
  return { ...left, dimension, rows: down.length, columns: across.length };
}

/** What sampling costs is bounded: as many as are seen, at this zoom (1 is the whole). */
export function sampling(points: readonly [number] | readonly [number, number], zoom: number, cells: number): string | number {
  const finer = Math.min(4, Math.max(1, 2 ** Math.floor(Math.log2(Math.max(1, zoom)))));
  if (points.length === 1) return clamp(points[0] * 10 * finer, 600, 6000);
  const [most, least] = cells > 1 ? [72, 40] : [112, 56];
  const along = (count: number) => clamp(count * 4, least, most) * finer;
  return `${along(points[0])}x${along(points[1])}`;
}

/** How finely a fit is sampled that is seen for a moment: within 50 kB. */
export function glancing(isSurface: boolean): string | number {
  return isSurface ? "38x38" : 1000;
}

function clamp(value: number, least: number, most: number): number {
  return Math.round(Math.min(most, Math.max(least, value)));
}
