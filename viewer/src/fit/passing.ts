/** When iterations are read from a stream. */

import type { Reel } from "./reel.js";

// Iterations that are looked at one after the other are no further apart.
const STRIDE = 4;

/** Iterations that are seen in passing: those that follow each other come from one stream. */
export class Passing {
  #reel: Reel | null = null;
  /** What the stream has of each iteration. */
  #what: unknown = null;
  /** The iteration that was seen last. */
  #last = -1;

  /** Returns when an iteration has come from a stream, or is none of the next ones there. `open` begins one after a number. */
  async reach(k: number, what: unknown, isKept: boolean, open: (after: number) => Reel): Promise<void> {
    const follows = k > this.#last && k <= this.#last + STRIDE;
    this.#last = k;
    const reel = this.#what === what ? this.#reel : null;
    reel?.want(k);
    if (isKept) return;
    if (reel?.isNear(k) === true) return reel.reach(k);
    if (!follows || this.#reel?.isRefused === true) return;
    this.#reel?.close();
    this.#what = what;
    this.#reel = open(k - 1);
    return this.#reel.reach(k);
  }
}
