/** When iterations are read from a stream. */

import type { DeltaStream } from "./delta-stream.js";

// Iterations that are looked at one after the other are no further apart.
const STRIDE = 4;

/** Iterations during playback: those that follow each other come from one stream. */
export class Playback {
  #stream: DeltaStream | null = null;
  /** What the stream has of each iteration. */
  #what: unknown = null;
  /** The iteration that was seen last. */
  #last = -1;

  /** Returns when an iteration has come from a stream, or is none of the next ones there. `open` begins one after a number. */
  async reach(k: number, what: unknown, isKept: boolean, open: (after: number) => DeltaStream): Promise<void> {
    const follows = k > this.#last && k <= this.#last + STRIDE;
    this.#last = k;
    const stream = this.#what === what ? this.#stream : null;
    stream?.want(k);
    if (isKept) return;
    if (stream?.isNear(k) === true) return stream.reach(k);
    if (!follows || this.#stream?.isRefused === true) return;
    this.#stream?.close();
    this.#what = what;
    this.#stream = open(k - 1);
    return this.#stream.reach(k);
  }
}
