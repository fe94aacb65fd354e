/** Data to be fitted. */

import type { api } from "piad";

const { cos, sin, PI } = Math;

function list<T>(length: number, make: (index: number) => T): T[] {
  return Array.from({ length }, (_, index) => make(index));
}

export const CURVE = list(8, (i) => [cos(0.7 * i) * (1 + 0.1 * i), sin(0.7 * i), 0.3 * i]);
const RING = list(9, (i) => [3 * cos(0.7 * i), 2 * sin(0.7 * i), 0.2 * sin(2.1 * i)]);
export const SURFACE = list(6, (i) => list(5, (j) => [i, j + 0.1 * i, sin(i) * cos(j)]));
const TUBE = list(7, (i) => list(5, (j) => [cos(0.9 * i), sin(0.9 * i), 0.5 * j]));
const WEIGHTS = [1, 1.2, 0.9, 1.1, 1.3, 1, 0.8, 1];
const GRID = list(6, (i) => list(5, (j) => 1 + 0.1 * ((i * j) % 3)));
const DIRECT = { kind: "direct" } as const;

/** Jobs of all shapes. */
export const FITS: Readonly<Record<string, api.JobRequest>> = {
  curve: { curve: { points: CURVE } },
  plane: { curve: { points: CURVE.map((point) => point.slice(0, 2)) } },
  closed: { curve: { points: RING, closed: true } },
  homogeneous: { curve: { points: CURVE, weights: WEIGHTS } },
  fixed: { curve: { points: CURVE, weights: WEIGHTS }, rational: "fixed" },
  saidBall: { curve: { points: CURVE, basis: { kind: "said_ball" } }, method: DIRECT },
  surface: { surface: { points: SURFACE } },
  mixedSurface: {
    surface: { points: SURFACE, basis: { u: { kind: "bspline", degree: 2 }, v: { kind: "said_ball" } } },
    method: DIRECT,
  },
  tube: { surface: { points: TUBE, closed: { u: true, v: false } } },
  homogeneousSurface: { surface: { points: SURFACE, weights: GRID } },
  fixedSurface: {
    surface: { points: SURFACE, weights: { u: [1, 1.2, 1, 1, 0.9, 1], v: [1, 1.1, 1, 1, 1] } },
    rational: "fixed",
  },
};

/** A fit that chooses its knots. */
export const AUTOMATIC: api.JobRequest = {
  curve: { points: list(500, (i) => (PI * i) / 499 - PI / 2).map((angle) => [cos(angle), sin(angle) * cos(angle)]) },
  method: { kind: "least_squares", control_points: "auto" },
  stop: { tolerance: 1e-4 },
};

/** The same for a surface. */
export const AUTOMATIC_SURFACE: api.JobRequest = {
  surface: { points: list(30, (i) => list(25, (j) => [i, j, 3 * sin(i / 4) * cos(j / 5)])) },
  method: { kind: "least_squares", control_points: "auto" },
  stop: { tolerance: 0.01 },
};

const MANY = list(200, (i) => [i, i % 7]);

/** A fit with this number of iterations. */
export function slow(iterations: number): api.JobRequest {
  const curve = { points: MANY, basis: { kind: "bernstein" } } as const;
  return { curve, stop: { relative_tolerance: 1e-15, max_iterations: iterations } };
}

/** A fit with this number of iterations of one megabyte each, made by small steps. */
export function large(iterations: number): api.JobRequest {
  const points = list(30_000, (i) => [i, 100 * sin(i), cos(i * i)]);
  const curve = { points, parameters: "uniform" } as const;
  return { curve, method: { kind: "weighted", omega: 0.01 }, stop: { max_iterations: iterations } };
}
