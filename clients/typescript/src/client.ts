/** The client. */

import type * as api from "./api.js";
import type { Fetch } from "./attempt.js";
import { Batch, type Batching, type Items } from "./batch.js";
import { type Call, Connection, serverUrl } from "./connection.js";
import { type IterationIn, type Result, resultOf } from "./iteration.js";
import { Job, create, createStream } from "./job.js";
import type { Cancellable, Creation, Making, Repeatable } from "./options.js";
import type { Stream } from "./stream.js";

// The server is asked to wait up to this many seconds for the end of a job before it responds.
const WAIT = 10;

/** Connection settings. */
export interface ClientOptions {
  /**
   * The maximum number of times a request is sent, or a stream is opened without receiving an iteration; 8 by default.
   * A server that has never responded is tried three times.
   */
  readonly attempts?: number | undefined;
  /** The longest silence of the server in seconds; 60 by default, which is the minimum for streams. */
  readonly timeout?: number | undefined;
  /** A token of `piad token create`, for a server that requires one. */
  readonly token?: string | undefined;
  /** Headers of each request. */
  readonly headers?: RequestInit["headers"] | undefined;
  /** Replaces the global `fetch`, for proxies, certificates and tests. */
  readonly fetch?: Fetch | undefined;
}

/** A server. */
export class Client {
  readonly #connection: Connection;

  /** `url` is the address of the server; in a page it may be relative. */
  constructor(url: string | URL = "http://127.0.0.1:8080", options: ClientOptions = {}) {
    const { attempts = 8, timeout = 60, token, fetch = (url, init) => globalThis.fetch(url, init) } = options;
    if (!(attempts >= 1)) throw new RangeError("there is one attempt at least");
    const headers = new Headers(options.headers);
    if (token !== undefined) headers.set("Authorization", `Bearer ${token}`);
    const settings = { baseUrl: serverUrl(url), attempts, timeout, headers, fetch };
    this.#connection = new Connection(settings);
  }

  /** Creates a job. */
  create(request: api.JobRequest, options: Creation = {}): Promise<Job> {
    return create(this.#connection, "/v1/jobs", request, options);
  }

  /** Creates a job and streams its iterations in the response. */
  createStream<const View extends api.View = api.View>(
    request: api.JobRequest,
    options: Making<View> = {},
  ): Stream<IterationIn<View>> {
    return createStream(this.#connection, "/v1/jobs/stream", request, options, request.stream);
  }

  /**
   * Creates a job and waits for its result. A fit that has not reached its tolerance also has a result, whose `state`
   * is not `converged`.
   */
  async fit(request: api.JobRequest, options: Repeatable = {}): Promise<Result> {
    const job = await this.create(request, { ...options, wait: WAIT });
    return job.result({ signal: options.signal });
  }

  /**
   * Fits without creating a job; nothing is stored. Throws `ApiError` with status 422 if the tolerance is not reached.
   * Use it for short fits: proxies may time out.
   */
  async fitOnce(
    request: api.JobRequest,
    options: Cancellable & { readonly encoding?: api.NumberEncoding | undefined } = {},
  ): Promise<Result> {
    const { encoding = "base64", signal } = options;
    const call: Call = { method: "POST", path: "/v1/fit", query: { encoding }, body: request, signal };
    return resultOf(await this.#connection.json<api.FitResult>(call));
  }

  /**
   * Fits many items, which is much faster than one request each. Returns an async iterator over the results, in order.
   * Items may come from a generator; they are read and sent in groups, and not stored. A failed item has a `problem`
   * and does not end the batch.
   */
  batch(items: Items, options: Batching = {}): Batch {
    return new Batch(this.#connection, items, options);
  }

  /** The job with this id. */
  async job(id: string, { signal }: Cancellable = {}): Promise<Job> {
    const path = `/v1/jobs/${encodeURIComponent(id)}`;
    return new Job(this.#connection, await this.#connection.json<api.Job>({ path, signal }));
  }

  /** All jobs, newest first, fetched as they are used, `page` (1 to 1000) at a time. */
  async *jobs(
    options: Cancellable & { readonly state?: api.JobState | undefined; readonly page?: number | undefined } = {},
  ): AsyncGenerator<Job, void, undefined> {
    const { state, page: limit = 100, signal } = options;
    let page = await this.#connection.json<api.JobPage>({ path: "/v1/jobs", query: { state, limit }, signal });
    for (;;) {
      for (const job of page.jobs) yield new Job(this.#connection, job);
      if (page.next === null) return;
      // The server may put its base path before the link, which the URL already has.
      const more = page.next.slice(page.next.indexOf("?"));
      page = await this.#connection.json<api.JobPage>({ path: `/v1/jobs${more}`, signal });
    }
  }

  /**
   * Reads the points of a file (CSV, tables, airfoils, point clouds) as the curve or surface of a job:
   * `client.create({ curve: (await client.readPoints(file)).curve })`. `size`, such as `40x60`, makes them rows and
   * columns of a surface. Errors in a file name their lines (`ApiError`).
   */
  readPoints(
    content: string | Blob,
    { size, signal }: Cancellable & { readonly size?: string | undefined } = {},
  ): Promise<api.FilePoints> {
    const text = { type: "text/csv", content };
    return this.#connection.json({ method: "POST", path: "/v1/points", query: { "surface.size": size }, text, signal });
  }

  /** The features and limits of the server. */
  capabilities(options: Cancellable = {}): Promise<api.Capabilities> {
    return this.#get("/v1/capabilities", options);
  }

  /** The convergence rates of classical PIA with each basis at the same parameters. */
  rates({ signal, ...query }: Cancellable & api.Query<"compareBases"> = {}): Promise<api.Rates> {
    return this.#connection.json({ path: "/v1/rates", query, signal });
  }

  /** The problem types, with remedies. */
  problems(options: Cancellable = {}): Promise<api.ProblemTypes> {
    return this.#get("/problems", options);
  }

  /** A problem type, by its name or the last part of it. */
  problem(type: string, options: Cancellable = {}): Promise<api.ProblemType> {
    return this.#get(`/problems/${encodeURIComponent(type.replace("/problems/", ""))}`, options);
  }

  /** The name and version of the server, with links. */
  service(options: Cancellable = {}): Promise<api.Service> {
    return this.#get("/", options);
  }

  /** The OpenAPI document. */
  description(options: Cancellable = {}): Promise<Record<string, unknown>> {
    return this.#get("/openapi.json", options);
  }

  /** True if the server is running. */
  live(options: Cancellable = {}): Promise<api.Health> {
    return this.#get("/livez", options);
  }

  /** True if the server accepts jobs; waits for one that is starting. */
  ready(options: Cancellable = {}): Promise<api.Health> {
    return this.#get("/readyz", options);
  }

  /** Counters, gauges and histograms in the OpenMetrics text format. */
  metrics({ signal }: Cancellable = {}): Promise<string> {
    const call = { path: "/metrics", headers: { Accept: "*/*" }, signal };
    return this.#connection.request(call, async ({ response, attempt }) => (await attempt.body(response)).text());
  }

  #get<T>(path: string, { signal }: Cancellable): Promise<T> {
    return this.#connection.json({ path, signal });
  }
}
