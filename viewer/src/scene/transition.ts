/** From one shape to the next. */

// More points than this are not moved one by one.
const MOST = 60_000;

/** Numbers on their way to others, so that steps are seen as movements. */
export class Transition {
  /** What is shown now; the vertex buffer. */
  shown: Float32Array = new Float32Array(0);
  #from: Float32Array | null = null;
  #to: Float32Array | null = null;
  #begun = 0;
  #lasts = 0;

  /** Goes to other numbers within so many milliseconds. */
  go(to: Float32Array, lasts: number, now: number): void {
    if (to === this.#to) return;
    const still = lasts <= 0 || to.length !== this.shown.length || to.length > MOST * 3;
    this.#from = still ? null : this.shown.slice();
    this.#to = to;
    this.#begun = now;
    this.#lasts = lasts;
    if (still) this.shown = to;
    else this.shown = this.#from!.slice();
  }

  /** Whether there is still a way to go. */
  get moves(): boolean {
    return this.#from !== null;
  }

  /** Where the numbers are now. */
  step(now: number): void {
    const [from, to] = [this.#from, this.#to];
    if (from === null || to === null) return;
    const t = Math.min(1, Math.max(0, (now - this.#begun) / this.#lasts));
    const eased = t * t * (3 - 2 * t);
    const { shown } = this;
    if (t < 1) {
      for (let i = 0; i < shown.length; i++) shown[i] = from[i]! + (to[i]! - from[i]!) * eased;
      return;
    }
    // To the bit: what comes from far away would not arrive by sums.
    shown.set(to);
    this.#from = null;
  }
}
