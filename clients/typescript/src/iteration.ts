/** Iterations and results, from the JSON of the server. */

import type * as api from "./api.js";
import { type Tensor, copy, line, moved, tensor } from "./arrays.js";
import { ProtocolError } from "./errors.js";
import { type Shape, shapeOf, withKnots } from "./shape.js";

/** The parts of an iteration in each view. */
interface Level {
  /** Counted from 0. */
  readonly number: number;
  /** The distances from the data points, in data units. */
  readonly error: api.FitError;
  /** The number of control points moved by the step to this iteration. */
  readonly moved: number;
  /** The factor by which the step has reduced the largest distance. */
  readonly rate: number | null;
  /** The total number of iterations, as predicted at this iteration. */
  readonly predicted: number | null;
  /** The smallest milestone first reached by this iteration. */
  readonly milestone: number | null;
  readonly badWeight: api.BadWeight | null;
  /** With the knots of this iteration, if the fit chooses them. */
  readonly shape: Shape;
}

/** An iteration with its control points. */
export interface FittedIteration extends Level {
  readonly view: "control_points";
  /** Complete, including repeated control points, even if the server sends only changes. */
  readonly controlPoints: Tensor;
  /** Weights of homogeneous fits, which change. */
  readonly weights: Tensor | null;
}

/** An iteration as points at equal steps of the parameters. */
export interface SampledIteration extends Level {
  readonly view: "samples";
  readonly samples: Tensor;
  /** The parameters of a curve, or of u and v. */
  readonly parameters: Lines;
}

/** The numbers of samples of a curve, or of u and v. */
export type Lines = readonly [Float64Array] | readonly [Float64Array, Float64Array];

/** An iteration without geometry. */
export interface ErrorIteration extends Level {
  readonly view: "errors";
}

/** An iteration; its `view` determines which fields it has. */
export type Iteration = FittedIteration | SampledIteration | ErrorIteration;

/** The iterations of a view. */
export type IterationIn<View extends api.View> = Extract<Iteration, { view: View }>;

/** The last iteration of a fit that has ended. */
export interface Result {
  /** The id of the job. */
  readonly id: string;
  readonly name: string | null;
  readonly state: api.JobState;
  /** The number of the last iteration. */
  readonly iteration: number;
  readonly error: api.FitError;
  readonly badWeight: api.BadWeight | null;
  readonly shape: Shape;
  /** The parameters of the data points: of a curve, or of u and v. */
  readonly parameters: Lines;
  /** Including repeated control points. */
  readonly controlPoints: Tensor;
  /** Weights of homogeneous fits; fixed ones are in `shape`. */
  readonly weights: Tensor | null;
  /** The trimmed region of a surface. */
  readonly trim: api.Trimmed | null;
}

/**
 * Parses an iteration. `shape` is that of the previous iteration, whose knots this one may change; one that contains
 * only changes is applied to the iteration `before`.
 */
export function iterationOf(event: api.IterationEvent, shape: Shape, before: Iteration | null): Iteration {
  const level = {
    number: event.iteration,
    error: event.error,
    moved: event.moved,
    rate: event.rate ?? null,
    predicted: event.predicted ?? null,
    milestone: event.milestone ?? null,
    badWeight: event.bad_weight ?? null,
    shape: event.knots == null ? shape : withKnots(shape, event.knots),
  };
  if (event.encoding === "delta") return { ...level, ...movedFrom(before, event) };
  if (event.samples !== undefined) {
    return { ...level, view: "samples", samples: points(event, event.samples), parameters: parameters(event) };
  }
  if (event.control_points !== undefined) {
    const weights = event.weights === undefined ? null : weightsOf(event, event.weights);
    return { ...level, view: "control_points", controlPoints: points(event, event.control_points), weights };
  }
  if (event.changed === undefined) return { ...level, view: "errors" };
  return { ...level, view: "control_points", ...applied(event.changed, before) };
}

/** Reads a result. */
export function resultOf(value: api.FitResult): Result {
  const { weights } = value;
  const homogeneous = value.rational === "homogeneous" && weights !== undefined;
  return {
    id: value.id,
    name: value.name,
    state: value.state,
    iteration: value.iteration,
    error: value.error,
    badWeight: value.bad_weight ?? null,
    shape: shapeOf(value),
    // They are 64-bit numbers in each encoding.
    parameters: lines(value.parameters, value.encoding && "base64"),
    controlPoints: points(value, value.control_points),
    weights: homogeneous ? weightsOf(value, weights as api.WeightArray) : null,
    trim: value.trim ?? null,
  };
}

type Written = Pick<api.IterationEvent, "shape" | "encoding">;

function points({ shape, encoding }: Written, value: api.PointArray): Tensor {
  return tensor(value, shape ?? [], encoding);
}

function weightsOf({ shape, encoding }: Written, value: api.WeightArray): Tensor {
  return tensor(value, (shape ?? []).slice(0, -1), encoding);
}

function parameters({ parameters, encoding }: api.IterationEvent): Lines {
  if (parameters === undefined) throw new ProtocolError("the server sent samples without parameters");
  return lines(parameters, encoding);
}

function lines(value: api.FitResult["parameters"], encoding: Written["encoding"]): Lines {
  if (typeof value === "string" || Array.isArray(value)) return [line(value, encoding)];
  return [line(value.u, encoding), line(value.v, encoding)];
}

type Geometry = Pick<FittedIteration, "view" | "controlPoints" | "weights"> | Pick<SampledIteration, "view" | "samples" | "parameters">;

/** Adds differences to the previous numbers. */
function movedFrom(before: Iteration | null, event: api.IterationEvent): Geometry {
  const dimension = event.shape?.at(-1) ?? 1;
  const next = (array: Tensor, step: number | undefined, text: unknown, dimension: number) => {
    if (typeof text !== "string" || step === undefined) throw new ProtocolError("the server sent a change without its steps");
    return moved(array, step, text, dimension);
  };
  if (before?.view === "samples") {
    const { view, parameters } = before;
    return { view, parameters, samples: next(before.samples, event.step, event.samples, dimension) };
  }
  if (before?.view !== "control_points") throw new ProtocolError("the server sent changes before what has changed");
  const { view, weights } = before;
  return {
    view,
    controlPoints: next(before.controlPoints, event.step, event.control_points, dimension),
    weights: weights === null ? null : next(weights, event.weight_step, event.weights, 1),
  };
}

/** The previous control points, with those that have moved. */
function applied(changes: api.Changes, before: Iteration | null): Pick<FittedIteration, "controlPoints" | "weights"> {
  if (before?.view !== "control_points") {
    throw new ProtocolError("the server sent changes before what has changed; those of an ephemeral edit need `from`, the iteration with control points that it starts from");
  }
  const controlPoints = copy(before.controlPoints);
  const weights = before.weights === null ? null : copy(before.weights);
  const { shape } = controlPoints;
  const [dimension, columns] = [shape.at(-1) ?? 0, shape.at(-2) ?? 0];
  for (const [place, point, weight] of changes) {
    const [row, column] = typeof place === "number" ? [0, place] : [place[0] ?? 0, place[1] ?? 0];
    const index = row * columns + column;
    controlPoints.data.set(point.map((number) => number ?? NaN), index * dimension);
    if (weights !== null && weight !== undefined) weights.data[index] = weight;
  }
  return { controlPoints, weights };
}
