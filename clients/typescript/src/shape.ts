/** The parts that are constant over iterations, and the knots, which may change. */

import type * as api from "./api.js";
import { type Tensor, line } from "./arrays.js";

/** The basis of a curve, or of a direction of a surface. */
export interface Basis {
  readonly kind: api.BasisKind;
  readonly degree: number;
  /** Null for Ball bases, which have no knots, and in streams with `describe: "none"`. */
  readonly knots: Float64Array | null;
  readonly closed: boolean;
}

/** The bases of a curve or surface, and fixed weights. */
export interface Shape {
  readonly kind: api.GeometryKind;
  /** One for a curve, two for u and v of a surface. */
  readonly bases: readonly [Basis] | readonly [Basis, Basis];
  /** Fixed weights of all control points, including repeated ones. */
  readonly fixedWeights: Tensor | null;
}

/** JSON with a shape: the `job` event of a stream, and results. */
type Shaped = Pick<api.JobEvent, "kind" | "basis" | "degree" | "closed" | "knots" | "rational" | "encoding"> & {
  readonly weights?: api.JobEvent["weights"] | api.ResultWeights;
};

/** Reads the shape in the data of a `job` event or of a result. */
export function shapeOf(value: Shaped): Shape {
  const bases = value.kind === "curve" ? ([basis(value)] as const) : ([basis(value, "u"), basis(value, "v")] as const);
  return { kind: value.kind, bases, fixedWeights: fixedWeights(value, bases) };
}

/** The same with the knots of an iteration, if the fit chooses them. */
export function withKnots(shape: Shape, knots: NonNullable<api.IterationEvent["knots"]>): Shape {
  const [u, v] = shape.bases;
  if (v === undefined) return { ...shape, bases: [{ ...u, knots: lineOf(of(knots)) }] };
  const bases = [
    { ...u, knots: lineOf(of(knots, "u")) },
    { ...v, knots: lineOf(of(knots, "v")) },
  ] as const;
  return { ...shape, bases };
}

type Way = "u" | "v";

/** The value for one direction: objects have one for each. */
function of<T>(value: T | { readonly u: T; readonly v: T }, way?: Way): T {
  const both = typeof value === "object" && value !== null && "u" in value;
  return (both ? value[way ?? "u"] : value) as T;
}

function basis(value: Shaped, way?: Way): Basis {
  return {
    kind: of<api.BasisKind>(value.basis, way),
    degree: of<number>(value.degree, way),
    knots: lineOf(of<api.KnotArray>(value.knots ?? null, way)),
    closed: of<boolean>(value.closed, way),
  };
}

/** Knots are 64-bit numbers in each encoding. */
function lineOf(knots: api.KnotArray): Float64Array | null {
  return knots === null ? null : line(knots);
}

/** Weights of surfaces are products of those of rows and columns. */
function fixedWeights(value: Shaped, bases: Shape["bases"]): Tensor | null {
  if (value.rational !== "fixed" || value.weights === undefined || value.weights === null) return null;
  const [u, v] = bases.map((basis, i) => {
    const weights = of(value.weights as api.NumberArray | api.NumberArrayPair, i === 0 ? "u" : "v");
    return weights.length === 0 ? new Float64Array(count(basis)).fill(1) : line(weights, value.encoding);
  }) as [Float64Array, Float64Array?];
  if (v === undefined) return { data: u, shape: [u.length] };
  const data = Float64Array.from({ length: u.length * v.length }, (_, i) => at(u, Math.floor(i / v.length)) * at(v, i % v.length));
  return { data, shape: [u.length, v.length] };
}

function count({ knots, degree }: Basis): number {
  return knots === null ? degree + 1 : knots.length - degree - 1;
}

function at(numbers: Float64Array, index: number): number {
  return numbers[index] ?? NaN;
}
