/** The curvature of an iteration at its samples, which the server computes. */

import type { api } from "piad";

import type { Data } from "./data.js";
import type { Fit } from "./fit.js";
import { type Samples, sampling } from "./geometry.js";

/** Values at the samples of an iteration; NaN where there is no curvature. */
export interface Curvatures {
  /** Of a curve its curvature, of a surface the larger principal one. */
  readonly first: Float64Array;
  /** The smaller principal curvature of a surface; null of a curve. */
  readonly second: Float64Array | null;
  /** The least and the largest value of all; null where there is none. */
  readonly range: readonly [number | null, number | null];
}

type Values = readonly (number | null)[] | readonly (readonly (number | null)[])[];

/** Asks for the curvature of an iteration; null where it has none, such as values without a place. */
export async function curvatureOf(fit: Fit, data: Data, k: number, samples: Samples): Promise<Curvatures | null> {
  if (data.dimension < 2) return null;
  const [rows, columns] = data.controls;
  const shape = await fit.shape(k, sampling(data.isSurface ? [rows, columns] : [columns], 1, 1)).catch(() => null);
  if (shape === null) return null;
  const at = (values: Values) => spread(values, samples);
  if (shape.kind === "curve") {
    const { curvature, samples: { curvature: values } } = shape as api.CurveShape;
    return { first: at(values as Values), second: null, range: [curvature.smallest?.value ?? null, curvature.largest?.value ?? null] };
  }
  const { curvature, samples: { k1, k2 } } = shape as api.SurfaceShape;
  return { first: at(k1 as Values), second: at(k2 as Values), range: [curvature.k2.smallest?.value ?? null, curvature.k1.largest?.value ?? null] };
}

/** Values of a grid at another one over the same range. */
function spread(values: Values, { rows, columns }: Samples): Float64Array {
  const grid = (Array.isArray(values[0]) ? values : [values]) as readonly (readonly (number | null)[])[];
  const across = grid[0]?.length ?? 0;
  const place = (i: number, count: number, of: number): [number, number] => {
    const at = count < 2 ? 0 : (i / (count - 1)) * (of - 1);
    const low = Math.max(0, Math.min(of - 2, Math.floor(at)));
    return [low, at - low];
  };
  const found = new Float64Array(rows * columns);
  for (let i = 0, to = 0; i < rows; i++) {
    const [a, s] = place(i, rows, grid.length);
    for (let j = 0; j < columns; j++, to++) {
      const [b, t] = place(j, columns, across);
      const value = (row: number, column: number) => grid[Math.min(row, grid.length - 1)]?.[Math.min(column, across - 1)] ?? NaN;
      const along = (row: number) => (t === 0 ? value(row, b) : (1 - t) * value(row, b) + t * value(row, b + 1));
      found[to] = s === 0 ? along(a) : (1 - s) * along(a) + s * along(a + 1);
    }
  }
  return found;
}
