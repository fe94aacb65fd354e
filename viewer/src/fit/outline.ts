/** The outline of a trimmed surface, in its parameters. */

import type { api } from "piad";

/** A surface is inside its loops: counter-clockwise around pieces, clockwise around holes. */
export interface Outline {
  /** u and v of the corners of each loop, which is closed: the last one is not the first. */
  readonly loops: readonly Float64Array[];
  readonly pieces: number;
  readonly holes: number;
  /** Of the last iteration; null if there is none. */
  readonly area: number | null;
}

// How far corners may be from their curve, as a part of its extent: less than a pixel, also from nearby.
const NEAR = 4e-5;
// A span of a curve has at least this number of edges, so that bends to both sides are seen.
const PARTS = 4;
// How often an edge is halved.
const DEPTH = 6;

/** The loops of a result as polygons: the server writes them as curves. */
export function outlineOf({ area = NaN, faces, loops }: api.Trimmed): Outline {
  const holes = faces.reduce((sum, face) => sum + face.holes.length, 0);
  return { loops: loops.map(polygonOf), pieces: faces.length, holes, area: Number.isFinite(area) ? area : null };
}

type Point = readonly [number, number];

function polygonOf(loop: api.TrimLoop): Float64Array {
  const { degree, knots, control_points: points } = loop;
  const extent = [0, 1].map((axis) => Math.max(...points.map((point) => point[axis]!)) - Math.min(...points.map((point) => point[axis]!)));
  const tolerance = extent.map((length) => length * NEAR || 1) as unknown as Point;
  const corners: number[] = [];
  for (let span = degree; span < points.length; span++) {
    const [from, to] = [knots[span]!, knots[span + 1]!];
    if (!(to > from)) continue;
    const at = (share: number) => pointAt(loop, span, from + (to - from) * share);
    const parts = degree === 1 ? 1 : PARTS;
    for (let part = 0; part < parts; part++) {
      const ends = [part / parts, (part + 1) / parts] as const;
      corners.push(...at(ends[0]));
      if (degree > 1) halve(at, ends[0], at(ends[0]), ends[1], at(ends[1]), tolerance, DEPTH, corners);
    }
  }
  return Float64Array.from(corners);
}

/** Adds the corners between two points of a curve that it needs to be near to the curve. */
function halve(at: (share: number) => Point, a: number, from: Point, b: number, to: Point, tolerance: Point, depth: number, corners: number[]): void {
  const middle = (a + b) / 2;
  const point = at(middle);
  if (depth === 0 || [0, 1].every((axis) => Math.abs(point[axis]! - (from[axis]! + to[axis]!) / 2) <= tolerance[axis]!)) return;
  halve(at, a, from, middle, point, tolerance, depth - 1, corners);
  corners.push(...point);
  halve(at, middle, point, b, to, tolerance, depth - 1, corners);
}

/** The point of a curve at a parameter within a span of its knots, by the algorithm of de Boor. */
function pointAt({ degree, knots, control_points: points }: api.TrimLoop, span: number, t: number): Point {
  const last = Array.from({ length: degree + 1 }, (_, i) => [...points[span - degree + i]!] as [number, number]);
  for (let round = 1; round <= degree; round++) {
    for (let i = degree; i >= round; i--) {
      const low = knots[span - degree + i]!;
      const share = (t - low) / (knots[span + 1 + i - round]! - low);
      last[i] = [0, 1].map((axis) => last[i - 1]![axis]! * (1 - share) + last[i]![axis]! * share) as [number, number];
    }
  }
  return last[degree]!;
}
