/** Values that tell when they change. */

/** A value that is replaced, never changed in place. */
export class Store<T extends object> {
  #value: T;
  readonly #listeners = new Set<(value: T, before: T) => void>();

  constructor(value: T) {
    this.#value = value;
  }

  get value(): T {
    return this.#value;
  }

  /** Sets some of the fields. Nobody is told of what stays. */
  set(part: Partial<T>): void {
    const before = this.#value;
    const names = Object.keys(part) as (keyof T)[];
    if (names.every((name) => Object.is(part[name], before[name]))) return;
    this.#value = { ...before, ...part };
    for (const listener of [...this.#listeners]) listener(this.#value, before);
  }

  /** Calls with each new value until the returned function is called. */
  subscribe(listener: (value: T, before: T) => void): () => void {
    this.#listeners.add(listener);
    return () => this.#listeners.delete(listener);
  }
}
