/** Iterations one after the other, by the differences between them. */

import type { FittedIteration, Job, SampledIteration, api } from "piad";
import { ApiError } from "piad";

// Further ahead than this an iteration comes sooner by itself.
const NEAR = 8;
// A connection over which nothing more is wanted is closed after this time, in milliseconds.
const IDLE = 5000;

export type Level = FittedIteration | SampledIteration;

/** Which iterations come: those after a number, at these samples or with their control points. */
export interface Request {
  readonly job: Promise<Job>;
  readonly samples?: api.Samples;
  readonly after: number;
  readonly signal: AbortSignal;
  /** Called with each iteration, and once more with the last one of the job, which is exact. */
  readonly keep: (level: Level, isExact: boolean) => void;
}

/**
 * A stream that is read as far as iterations are wanted; the server waits meanwhile. Each iteration is within a
 * hundredth of its error; the last one of the job is exact.
 */
export class DeltaStream {
  /** True if the server does not stream this job like that. */
  isRefused = false;
  readonly #request: Request;
  readonly #closing = new AbortController();
  /** The number of the iteration that came last. */
  #at: number;
  #wanted: number;
  #waiting: { readonly k: number; readonly done: () => void }[] = [];
  #proceed: () => void = () => {};

  constructor(request: Request) {
    this.#request = request;
    this.#at = this.#wanted = request.after;
    request.signal.addEventListener("abort", () => this.close(), { once: true, signal: this.#closing.signal });
    void this.#read();
  }

  get isClosed(): boolean {
    return this.#closing.signal.aborted;
  }

  /** True if an iteration is among the next that come. */
  isNear(k: number): boolean {
    return !this.isClosed && k > this.#at && k <= this.#at + NEAR;
  }

  /** Goes on if all but an iteration that is wanted has been read. */
  want(k: number): void {
    if (k < this.#at || k > this.#at + NEAR) return;
    this.#wanted = Math.max(this.#wanted, k);
    this.#proceed();
  }

  /** Returns when an iteration that is near has come, or does not come any more. */
  reach(k: number): Promise<void> {
    if (this.isClosed) return Promise.resolve();
    this.want(k);
    return new Promise((done) => this.#waiting.push({ k, done }));
  }

  close(): void {
    this.#closing.abort();
    this.#proceed();
    this.#release(Infinity);
  }

  async #read(): Promise<void> {
    const { job, samples, after, keep } = this.#request;
    try {
      const stream = (await job).iterations({
        view: samples === undefined ? "control_points" : "samples",
        samples,
        encoding: "delta",
        every: 1,
        milestones: [],
        pace: "all",
        changed: false,
        digits: "full",
        describe: "none",
        after: after < 0 ? undefined : after,
        signal: this.#closing.signal,
      });
      let last: Level | null = null;
      for await (const level of stream) {
        last = level;
        keep(level, false);
        this.#at = level.number;
        this.#release(level.number);
        // One more is read than is wanted: after the last one it is the end.
        if (level.number > this.#wanted && !(await this.#isWanted())) break;
      }
      const isWhole = stream.end !== null && stream.end.state !== "cancelled" && stream.end.state !== "failed";
      if (last !== null && isWhole) keep(last, true);
    } catch (error) {
      // What is missing is asked for by itself, which says what is wrong.
      this.isRefused = error instanceof ApiError;
    }
    this.close();
  }

  /** Waits until more is wanted; false if nothing is for a while. */
  async #isWanted(): Promise<boolean> {
    const timer = setTimeout(() => this.#proceed(), IDLE);
    await new Promise<void>((resolve) => (this.#proceed = resolve));
    clearTimeout(timer);
    this.#proceed = () => {};
    return !this.isClosed && this.#wanted >= this.#at;
  }

  #release(k: number): void {
    const ready = this.#waiting.filter((one) => one.k <= k);
    this.#waiting = this.#waiting.filter((one) => one.k > k);
    for (const { done } of ready) done();
  }
}
