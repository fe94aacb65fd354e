/** Jobs: fits on the server. */

import type * as api from "./api.js";
import type { Answer, Call, Connection } from "./connection.js";
import { JobFailed } from "./errors.js";
import { type Iteration, type IterationIn, type Result, iterationOf, resultOf } from "./iteration.js";
import { type Cancellable, type Creation, type Editing, type Looking, type Measuring, type Watching, creating, shown } from "./options.js";
import { type Shape, shapeOf } from "./shape.js";
import { Stream } from "./stream.js";

// Settings of a stream that has only the first and last iteration, which override those of the job.
// No job has this many iterations.
const ENDS_ONLY = {
  view: "errors",
  every: 1_000_000_000,
  milestones: "",
  pace: "all",
  changed: false,
  describe: "full",
  encoding: "json",
  digits: "full",
} as const;

/** A job and its operations. */
export class Job {
  /** The last state received from the server; `refresh` updates it. */
  status: api.Job;
  readonly #connection: Connection;
  #shape: Shape | null = null;

  /** Use the methods of `Client`. */
  constructor(connection: Connection, status: api.Job) {
    this.#connection = connection;
    this.status = status;
  }

  get id(): string {
    return this.status.id;
  }

  /** True if the job had ended in the last state received. */
  get ended(): boolean {
    return this.status.state !== "queued" && this.status.state !== "running";
  }

  /** Fetches the current state of the job. */
  async refresh(options: Cancellable = {}): Promise<api.Job> {
    return (this.status = await this.#get<api.Job>("", {}, options));
  }

  /**
   * The iterations of the job, as they are computed, until it ends. Each one from 0 (or after `after`) arrives, unless
   * `every`, `milestones` or `pace: "latest"` skip some.
   */
  iterations<const View extends api.View = api.View>(options: Watching<View> = {}): Stream<IterationIn<View>> {
    const call = watching(this.id, shown(options, this.status.stream), options.signal);
    return new Stream(this.#connection, { first: call, next: () => call, after: options.after });
  }

  /** One iteration, by default the last; waits for one that is not computed yet. */
  async iteration<const View extends api.View = "control_points">(
    number: api.ParameterK = "last",
    options: Looking<View> = {},
  ): Promise<IterationIn<View>> {
    const shape = await this.shape(options);
    const query = shown({ ...options, view: options.view ?? "control_points" }, null);
    const level = await this.#get<api.IterationEvent>(`/iterations/${number}`, query, options);
    return iterationOf(level, shape, null) as Iteration as IterationIn<View>;
  }

  /** The bases of the fit; if it chooses its knots, those of iteration 0. Waits until the job has started. */
  async shape(options: Cancellable = {}): Promise<Shape> {
    if (this.#shape !== null) return this.#shape;
    for await (const { event, data } of this.#ends(options).events()) {
      if (event === "job") return (this.#shape = shapeOf(data));
    }
    throw new JobFailed(await this.refresh(options));
  }

  /** Waits until the job has ended. */
  async wait(options: Cancellable = {}): Promise<api.Job> {
    for await (const _ of this.#ends(options).events());
    return this.refresh(options);
  }

  /**
   * Waits for the last iteration. A cancelled job has a result if it computed an iteration; otherwise throws
   * `JobFailed`.
   */
  async result(options: Cancellable & { readonly encoding?: api.NumberEncoding | undefined } = {}): Promise<Result> {
    const status = this.ended ? this.status : await this.wait(options);
    if (status.state === "failed" || status.iteration === null) throw new JobFailed(status);
    return resultOf(await this.#get<api.FitResult>("/result", { encoding: options.encoding ?? "base64" }, options));
  }

  /**
   * Exports the result, or an iteration, as a file such as STEP for CAD systems; docs/reference/files.md lists the formats.
   * `samples` is for gltf, stl, ply, dxf, svg, geojson, gpx and csv, `dots` for svg, `units` for step and iges.
   */
  async file(
    format: api.ParameterFormat,
    options: Pick<Looking, "samples" | "signal"> & { readonly iteration?: api.ParameterK | undefined; readonly dots?: api.ParameterDots | undefined; readonly units?: api.ParameterUnits | undefined } = {},
  ): Promise<File> {
    const { iteration, samples, dots, units, signal } = options;
    const part = iteration === undefined ? "result" : `iterations/${iteration}`;
    const headers = { Accept: "*/*" };
    const call = { path: `${this.#path}/${part}/${format}`, query: { samples, dots, units }, headers, signal };
    return this.#connection.request(call, (answer) => fileOf(answer, `${this.id}.${format}`));
  }

  /** The request that created the job. */
  input(options: Cancellable = {}): Promise<api.JobRequest> {
    return this.#get("/input", {}, options);
  }

  /**
   * The distances of the data from the nearest points of an iteration, by default the last; with `list` also of each
   * point.
   */
  deviation(options: Cancellable & { readonly iteration?: api.ParameterK | undefined; readonly list?: boolean | undefined } = {}): Promise<api.Deviation> {
    const { iteration, list } = options;
    return this.#get("/deviation", { iteration, list }, options);
  }

  /**
   * Curvature of a curve or principal curvatures of a surface at samples, their extremes, length or area, and
   * continuity at knots, of an iteration, by default the last.
   */
  curvature(options: Measuring = {}): Promise<api.Shape> {
    const { iteration, samples, spacing, by } = options;
    return this.#get("/shape", { iteration, samples, spacing, by }, options);
  }

  /** The limits of the points that a local fit does not adjust. */
  limit(options: Cancellable = {}): Promise<api.Limit> {
    return this.#get("/limit", {}, options);
  }

  /**
   * Returns a ticket that opens the stream of the job for one minute without a token, as for `EventSource`: the query
   * parameter `ticket` of `/v1/jobs/{id}/events`. Throws `ApiError` with status 409 if the server requires no tokens.
   */
  ticket({ signal }: Cancellable = {}): Promise<api.Ticket> {
    return this.#connection.json({ method: "POST", path: `${this.#path}/tickets`, signal });
  }

  /** Cancels the job. Throws `ApiError` with status 409 if it has already ended. */
  async cancel({ signal }: Cancellable = {}): Promise<api.Job> {
    return (this.status = await this.#connection.json({ method: "POST", path: `${this.#path}/cancel`, signal }));
  }

  /**
   * Deletes the job. A missing job is no error: the response to an earlier attempt may have been lost, and browsers
   * retry silently.
   */
  async delete({ signal }: Cancellable = {}): Promise<void> {
    const call: Call = { method: "DELETE", path: this.#path, signal, accepted: 404 };
    await this.#connection.request(call, ({ response, attempt }) => attempt.body(response));
  }

  /** Creates a job that starts from the control points of this one; other settings are kept. */
  async edit(request: api.EditRequest, options: Creation = {}): Promise<Job> {
    return create(this.#connection, `${this.#path}/edits`, request, options);
  }

  /**
   * Creates a job that starts from the control points of this one and streams its iterations. An ephemeral edit
   * (`ephemeral: true`) is no job: nothing is stored when the loop ends.
   */
  editStream<const View extends api.View = api.View>(
    request: api.EditRequest,
    options: Editing<View> = {},
  ): Stream<IterationIn<View>> {
    const defaults = request.stream ?? this.status.stream;
    return createStream(this.#connection, `${this.#path}/edits/stream`, request, options, defaults);
  }

  get #path(): string {
    return `/v1/jobs/${this.id}`;
  }

  #get<T>(part: string, query: Call["query"], { signal }: Cancellable): Promise<T> {
    return this.#connection.json({ path: `${this.#path}${part}`, query, signal });
  }

  #ends({ signal }: Cancellable): Stream {
    const call = watching(this.id, ENDS_ONLY, signal);
    return new Stream(this.#connection, { first: call, next: () => call });
  }
}

/** Creates a job. Its key makes retries create a single job. */
export async function create(connection: Connection, path: string, body: unknown, options: Creation): Promise<Job> {
  const headers = creating(options, connection.longestWait);
  const { signal } = options;
  return new Job(connection, await connection.json<api.Job>({ method: "POST", path, body, headers, signal }));
}

/** The stream of a new job, which is resumed like that of any job when its connection breaks. */
export function createStream<View extends api.View>(
  connection: Connection,
  path: string,
  body: api.JobRequest | api.EditRequest,
  options: Editing<View>,
  defaults: api.StreamDefaults | null | undefined,
): Stream<IterationIn<View>> {
  const query = shown(options, defaults);
  const { signal, from } = options;
  const { on_disconnect: _, ...reading } = query;
  if ("ephemeral" in body && body.ephemeral === true) {
    // Nothing is stored, so there is nothing to find by a key or to resume.
    return new Stream(connection, { first: { method: "POST", path, query, body, signal }, next: null, from });
  }
  const headers = creating({ idempotencyKey: options.idempotencyKey }, 0);
  const first: Call = { method: "POST", path, query, body, headers, signal };
  return new Stream(connection, { first, next: (id) => watching(id, reading, signal), from });
}

function watching(id: string, query: Call["query"], signal: AbortSignal | undefined): Call {
  return { path: `/v1/jobs/${id}/events`, query, signal };
}

async function fileOf({ response, attempt }: Answer, otherwise: string): Promise<File> {
  const body = await attempt.body(response);
  const name = /filename="([^"]*)"/.exec(response.headers.get("Content-Disposition") ?? "")?.[1];
  return new File([body], name ?? otherwise, { type: body.type });
}
