/** Errors, which are all derived from {@link PiadError}. */

import type * as api from "./api.js";

/** A problem object (RFC 9457). Its type is "about:blank" if another server responded. */
export type Problem = Omit<api.Problem, "type"> & { type: api.Problem["type"] | "about:blank" };

/** The base of all errors of this package. */
export class PiadError extends Error {
  override readonly name: string = "PiadError";
}

/** The server rejected a request. */
export class ApiError extends PiadError {
  override readonly name = "ApiError";
  /** The problem object of the response. */
  readonly problem: Problem;
  /** The delay in seconds requested by the server (`Retry-After`). */
  readonly retryAfter: number | null;

  constructor(problem: Problem, retryAfter: number | null = null) {
    super(`${problem.status} ${problem.title}: ${problem.detail}`);
    this.problem = problem;
    this.retryAfter = retryAfter;
  }

  /** The problem type, such as "/problems/invalid-fit", which is also the path of its description. */
  get type(): Problem["type"] {
    return this.problem.type;
  }

  /** The title of the problem type. */
  get title(): string {
    return this.problem.title;
  }

  /** The HTTP status. */
  get status(): number {
    return this.problem.status;
  }

  /** The description of this error. */
  get detail(): string {
    return this.problem.detail;
  }

  /** All errors, with their locations. */
  get errors(): readonly api.FieldError[] {
    return this.problem.errors ?? [];
  }

  /** JSON pointers (RFC 6901) to the invalid values of the body. */
  get pointers(): readonly string[] {
    return this.errors.flatMap(({ pointer }) => pointer ?? []);
  }
}

/** The server was unreachable or the connection broke on each attempt. */
export class ConnectionLost extends PiadError {
  override readonly name = "ConnectionLost";
}

/** The response does not conform to this API. */
export class ProtocolError extends PiadError {
  override readonly name = "ProtocolError";
}

/** A job ended without a result. */
export class JobFailed extends PiadError {
  override readonly name = "JobFailed";
  /** The ended job. */
  readonly status: api.Job;

  constructor(status: api.Job) {
    const why = status.problem === undefined ? "" : `: ${status.problem.detail}`;
    super(`the job ${status.id} is ${status.state}${why}`);
    this.status = status;
  }

  /** Why it failed; null if it was cancelled before there was an iteration. */
  get problem(): api.Problem | null {
    return this.status.problem ?? null;
  }
}
