/** A client of piad, which fits curves and surfaces to data points and streams each iteration. */

export type * as api from "./api.js";
export type { Tensor } from "./arrays.js";
export type { Fetch } from "./attempt.js";
export { Batch, type BatchItem, type BatchTotals, type Batching, type Items } from "./batch.js";
export { Client, type ClientOptions } from "./client.js";
export { ApiError, ConnectionLost, JobFailed, PiadError, type Problem, ProtocolError } from "./errors.js";
export type {
  ErrorIteration,
  FittedIteration,
  Iteration,
  IterationIn,
  Result,
  SampledIteration,
} from "./iteration.js";
export { Job } from "./job.js";
export type { Cancellable, Creation, Editing, Looking, Making, Measuring, Repeatable, Showing, Watching } from "./options.js";
export type { Basis, Shape } from "./shape.js";
export { Stream } from "./stream.js";
