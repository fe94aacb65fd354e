/** How many control points an iteration has: those of fits that choose their knots change with them. */

import type { Shape, api } from "piad";

/** A count of a curve, or those of u and of v. */
export type Counts = api.JobEvent["control_points"];

/** The count that belongs to the knots of an event; null if it has none. */
export function countsOf(knots: api.IterationEvent["knots"], degree: api.JobEvent["degree"]): Counts | null {
  if (knots === null || knots === undefined || typeof knots === "string") return null;
  const one = (knots: api.KnotArray, degree: number) => (Array.isArray(knots) ? knots.length - degree - 1 : null);
  if (Array.isArray(knots)) return one(knots, typeof degree === "number" ? degree : degree.u);
  const [u, v] = [one(knots.u, typeof degree === "number" ? degree : degree.u), one(knots.v, typeof degree === "number" ? degree : degree.v)];
  return u === null || v === null ? null : { u, v };
}

/** The count that belongs to a shape; null if its knots are not known. */
export function countsOfShape({ bases }: Shape): Counts | null {
  const [u, v] = bases.map(({ knots, degree }) => (knots === null ? null : knots.length - degree - 1));
  if (u === null || u === undefined || v === null) return null;
  return v === undefined ? u : { u, v };
}
