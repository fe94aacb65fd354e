/** A job on the screen: what is known of it. */

import type { Client, Job, api } from "piad";
import { ApiError, ConnectionLost, JobFailed } from "piad";

import type { Axes } from "./axes.js";
import { type Counts, countsOf } from "./controls.js";
import { type Data, MOST_POINTS, dataOf, unseen } from "./data.js";
import { GeometryCache } from "./geometry-cache.js";
import { type Outline, outlineOf } from "./outline.js";

/** What is known of an iteration without its geometry. */
export interface Level {
  readonly error: api.FitError;
  readonly moved: number;
  /** How many control points it has. */
  readonly controls: Counts;
}

// After a lost connection, in milliseconds.
const AGAIN = 3000;
// A job of which nothing has come for this long is slow, in milliseconds.
const SLOW = 3000;

/** A job that is followed from its first iteration to its end. */
export class Fit {
  readonly id: string;
  /** The job as the server knows it; null until it has answered. */
  job: Job | null = null;
  /** What stays from iteration to iteration. */
  head: api.JobEvent | null = null;
  /** How it ended. */
  end: api.EndEvent | null = null;
  /** Where a trimmed surface ends, which is known with its result. */
  outline: Outline | null = null;
  /** The iterations that have come, by their numbers. */
  readonly levels: Level[] = [];
  /** Why there is nothing more to see. */
  problem: unknown = null;
  /** Where its data are; null until they are here. */
  axes: Axes | null = null;
  readonly geometry = new GeometryCache(this);
  readonly #opened = performance.now();
  #heard = performance.now();
  readonly #client: Client;
  readonly #changed: () => void;
  readonly #axes: () => readonly Axes[];
  readonly #closing = new AbortController();
  readonly #begun: Promise<api.JobEvent>;
  #hasBegun: (head: api.JobEvent) => void = () => {};
  #hasFailed: (error: unknown) => void = () => {};
  #job: Promise<Job> | null = null;
  #input: Promise<api.JobRequest> | null = null;
  #data: Promise<Data> | null = null;
  readonly #excesses = new Map<number, Promise<readonly number[]>>();
  #shape: { readonly key: string; readonly shape: Promise<api.Shape> } | null = null;

  /** `axes` are those of the jobs on the screen. */
  constructor(client: Client, job: Job | string, changed: () => void, axes: () => readonly Axes[]) {
    this.#client = client;
    this.id = typeof job === "string" ? job : job.id;
    if (typeof job !== "string") this.#job = Promise.resolve(job);
    this.#changed = changed;
    this.#axes = axes;
    this.#begun = new Promise((resolve, reject) => {
      this.#hasBegun = resolve;
      this.#hasFailed = reject;
    });
    this.#begun.catch(() => {});
    void this.#follow();
  }

  /** The number of the newest iteration; -1 before the first. */
  get latest(): number {
    return this.levels.length - 1;
  }

  /** How many seconds a job that runs has been looked at, if nothing has come of it for a while; else null. */
  get slow(): number | null {
    const now = performance.now();
    if (this.end !== null || this.problem !== null || now - this.#heard < SLOW) return null;
    const started = Date.parse(this.job?.status.started_at ?? "");
    return Math.max(now - this.#opened, Date.now() - started || 0) / 1000;
  }

  get signal(): AbortSignal {
    return this.#closing.signal;
  }

  get title(): string {
    const about = this.head ?? this.job?.status;
    const named = about?.name ?? this.job?.status.name;
    return named ?? (about === undefined ? "…" : `${about.kind === "curve" ? "Curve" : "Surface"} of ${about.points} points`);
  }

  /** The job as it was asked for, asked once. */
  input(): Promise<api.JobRequest> {
    if (this.#input === null) {
      const asked = this.known().then((job) => job.input({ signal: this.signal }));
      this.#input = asked;
      asked.catch(() => (this.#input = null));
    }
    return this.#input;
  }

  /** The data points, read once. */
  data(): Promise<Data> {
    this.#data ??= this.#read().then((data) => {
      this.axes = data.axes;
      return data;
    });
    this.#data.catch(() => {});
    return this.#data;
  }

  /**
   * By how much an iteration leaves its data in each gap between neighbours, or cell of a grid: asked once, if it is
   * wanted, and of the last one of a fit that has ended for it; else there are none.
   */
  excesses(k: number, isWanted: boolean): Promise<readonly number[]> {
    if (!isWanted && (this.end?.reason !== "between" || k !== this.latest)) return Promise.resolve([]);
    const kept = this.#excesses.get(k);
    if (kept !== undefined) return kept;
    const asked = this.known()
      .then((job) => job.deviation({ iteration: k, list: true, signal: this.signal }))
      .then(({ between = [] }) => (between as (number | readonly number[])[]).flat())
      // Some have no nearest points.
      .catch(() => []);
    this.#excesses.clear();
    this.#excesses.set(k, asked);
    return asked;
  }

  /** The curvature of an iteration at samples, asked once while it is looked at. */
  shape(k: number, samples: api.Samples): Promise<api.Shape> {
    const key = `${k} ${samples}`;
    if (this.#shape?.key === key) return this.#shape.shape;
    const shape = this.known().then((job) => job.curvature({ iteration: k as never, samples, signal: this.signal }));
    shape.catch(() => {});
    this.#shape = { key, shape };
    return shape;
  }

  /** Forgets the job; the server goes on. */
  close(): void {
    this.#closing.abort();
  }

  /** The job, asked once. */
  known(): Promise<Job> {
    if (this.#job === null) {
      const asked = this.#client.job(this.id, { signal: this.signal });
      this.#job = asked;
      asked.catch(() => (this.#job = null));
    }
    return this.#job;
  }

  /** Waits as long as the job has not begun or the server is away. */
  async #read(): Promise<Data> {
    const early = this.known()
      .then((job) => (job.status.points <= MOST_POINTS ? this.input() : null))
      .catch(() => null);
    const head = await this.#begun;
    if (head.points <= MOST_POINTS) return dataOf((await early) ?? (await this.input()), head, this.#axes());
    const job = await this.known();
    const samples = head.kind === "surface" ? "60x60" : 2000;
    const level = await job.iteration(0, { view: "samples", samples, encoding: "base64", signal: this.signal });
    return unseen(level.samples.data, head, this.#axes());
  }

  /** Follows the job to its end, over lost connections. */
  async #follow(): Promise<void> {
    for (;;) {
      try {
        await this.#run();
        return;
      } catch (error) {
        if (this.signal.aborted) return this.#hasFailed(error);
        this.problem = error;
        this.#changed();
        if (!(error instanceof ConnectionLost)) return this.#hasFailed(error);
      }
      await new Promise((resolve) => {
        setTimeout(resolve, AGAIN);
        addEventListener("online", resolve, { once: true });
      });
    }
  }

  async #run(): Promise<void> {
    const { signal } = this;
    const job = (this.job = await this.known());
    // Iterations are read by it; asked for now, it is here when they are.
    job.shape({ signal }).catch(() => {});
    const stream = job.iterations({ view: "errors", every: 1, milestones: [], pace: "all", changed: false, encoding: "json", digits: "full", after: this.latest < 0 ? undefined : this.latest, signal });
    let controls: Counts = this.levels.at(-1)?.controls ?? 0;
    for await (const { event, data } of stream.events()) {
      this.problem = null;
      this.#heard = performance.now();
      if (event === "job") {
        this.head = data;
        controls = this.levels.at(-1)?.controls ?? data.control_points;
        this.#hasBegun(data);
      }
      if (event === "iteration") {
        controls = countsOf(data.knots, this.head?.degree ?? 0) ?? controls;
        this.levels[data.iteration] = { error: data.error, moved: data.moved, controls };
      }
      if (event === "end") this.end = data;
      this.#changed();
    }
    await job.refresh({ signal });
    this.#changed();
    this.outline = await this.#trimmed(job);
    if (this.outline !== null) this.#changed();
  }

  /** The outline of a surface that is to be trimmed, from its result; of more points than are drawn results are too long. */
  async #trimmed(job: Job): Promise<Outline | null> {
    if (job.status.kind !== "surface" || job.status.points > MOST_POINTS) return null;
    if (!(await this.input()).surface?.trim) return null;
    try {
      const { trim } = await job.result({ signal: this.signal });
      return trim === null ? null : outlineOf(trim);
    } catch (error) {
      if (error instanceof JobFailed) return null;
      throw error;
    }
  }
}

/** Whether the server does not know the job. */
export function isGone(error: unknown): boolean {
  return error instanceof ApiError && error.status === 404;
}
