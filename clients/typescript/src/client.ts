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

/** How a server is reached. */
export interface ClientOptions {
  /** How often a request is sent, or a stream opened again without an iteration in between, while connections break or the server has no room; 8 is the default. A server that has never answered is tried three times. */
  readonly attempts?: number | undefined;
  /** How many seconds the server may be silent; 60 is the default, and the least for streams. */
  readonly timeout?: number | undefined;
  /** Of a server that asks for one: a token of `piad token create`. */
  readonly token?: string | undefined;
  /** What goes with every request. */
  readonly headers?: RequestInit["headers"] | undefined;
  /** Used instead of the global one, for proxies, certificates and tests. */
  readonly fetch?: Fetch | undefined;
}

/** A server. */
export class Client {
  readonly #connection: Connection;

  /** `url` is where the server is; in a page it may be relative to that. */
  constructor(url: string | URL = "http://127.0.0.1:8080", options: ClientOptions = {}) {
    const { attempts = 8, timeout = 60, token, fetch = (url, init) => globalThis.fetch(url, init) } = options;
    if (!(attempts >= 1)) throw new RangeError("there is one attempt at least");
    const headers = new Headers(options.headers);
    if (token !== undefined) headers.set("Authorization", `Bearer ${token}`);
    const settings = { baseUrl: serverUrl(url), attempts, timeout, headers, fetch };
    this.#connection = new Connection(settings);
  }

  /** A new job. */
  create(request: api.JobRequest, options: Creation = {}): Promise<Job> {
    return create(this.#connection, "/v1/jobs", request, options);
  }

  /** The iterations of a new job, in the answer to the request for it. */
  createStream<const View extends api.View = api.View>(
    request: api.JobRequest,
    options: Making<View> = {},
  ): Stream<IterationIn<View>> {
    return createStream(this.#connection, "/v1/jobs/stream", request, options, request.stream);
  }

  /**
   * The result of a new job, when it has ended. A fit that has not reached its tolerance is a result, too: its
   * `state` is not `converged`.
   */
  async fit(request: api.JobRequest, options: Repeatable = {}): Promise<Result> {
    const job = await this.create(request, { ...options, wait: WAIT });
    return job.result({ signal: options.signal });
  }

  /**
   * The result of a fit that is no job and is kept nowhere. A fit that does not come within its tolerance is an
   * `ApiError` with status 422. It takes one request, which proxies may not let wait for long.
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
   * Many fits, which are much quicker together than one by one: what comes of each, in order, as an async iterator.
   * Items may come from a generator; they are taken and sent some at a time, and nothing of them is kept. An item that
   * fails ends nothing: it has a `problem`.
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
   * The points of a file (CSV, tables with blanks, airfoils, clouds of points) as the curve or surface of a job:
   * `client.create({ curve: (await client.readPoints(file)).curve })`. `size`, such as `40x60`, makes them rows and
   * columns of a surface. An `ApiError` tells what is wrong at which line.
   */
  readPoints(
    content: string | Blob,
    { size, signal }: Cancellable & { readonly size?: string | undefined } = {},
  ): Promise<api.FilePoints> {
    const text = { type: "text/csv", content };
    return this.#connection.json({ method: "POST", path: "/v1/points", query: { "surface.size": size }, text, signal });
  }

  /** What the server can do and its limits. */
  capabilities(options: Cancellable = {}): Promise<api.Capabilities> {
    return this.#get("/v1/capabilities", options);
  }

  /** How fast classical PIA converges with each basis at the same parameters. */
  rates({ signal, ...query }: Cancellable & api.Query<"compareBases"> = {}): Promise<api.Rates> {
    return this.#connection.json({ path: "/v1/rates", query, signal });
  }

  /** The kinds of problems, and what to do about them. */
  problems(options: Cancellable = {}): Promise<api.ProblemTypes> {
    return this.#get("/problems", options);
  }

  /** One kind of problem, by its type or the last part of it. */
  problem(type: string, options: Cancellable = {}): Promise<api.ProblemType> {
    return this.#get(`/problems/${encodeURIComponent(type.replace("/problems/", ""))}`, options);
  }

  /** What the server is, and where its parts are. */
  service(options: Cancellable = {}): Promise<api.Service> {
    return this.#get("/", options);
  }

  /** The description of the API, in OpenAPI. */
  description(options: Cancellable = {}): Promise<Record<string, unknown>> {
    return this.#get("/openapi.json", options);
  }

  /** Whether the server runs. */
  live(options: Cancellable = {}): Promise<api.Health> {
    return this.#get("/livez", options);
  }

  /** Whether the server takes jobs; one that is starting is waited for. */
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
