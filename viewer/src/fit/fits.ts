/** The jobs on the screen, which are those of the view. */

import type { Client, Job } from "piad";

import type { View } from "../state.js";
import type { Store } from "../store.js";
import { Fit } from "./fit.js";

/** The jobs on the screen. */
export interface Fits {
  readonly shown: readonly Fit[];
  of(id: string): Fit | undefined;
  /** Calls when jobs come, go on or go, at most once a frame. */
  subscribe(listener: () => void): () => void;
}

export class OpenFits implements Fits {
  shown: readonly Fit[] = [];
  readonly #client: Client;
  readonly #listeners = new Set<() => void>();
  readonly #known = new Map<string, Job>();
  #frame = 0;

  constructor(client: Client, view: Store<View>) {
    this.#client = client;
    view.subscribe(({ jobs }) => this.#show(jobs));
    this.#show(view.value.jobs);
  }

  of(id: string): Fit | undefined {
    return this.shown.find((fit) => fit.id === id);
  }

  /** Calls at each change, and in the next frame for what has changed before: scripts that come late miss nothing. */
  subscribe(listener: () => void): () => void {
    this.#listeners.add(listener);
    this.#changed();
    return () => this.#listeners.delete(listener);
  }

  /** What the server has just said of a job need not be asked again. */
  know(job: Job): void {
    this.#known.set(job.id, job);
  }

  #show(jobs: readonly string[]): void {
    if (jobs.join() === this.shown.map(({ id }) => id).join()) return;
    const before = this.shown;
    const axes = () => [...this.shown, ...before].flatMap((fit) => fit.axes ?? []);
    this.shown = jobs.map((id) => this.of(id) ?? new Fit(this.#client, this.#known.get(id) ?? id, this.#changed, axes));
    this.#known.clear();
    for (const fit of before) if (!jobs.includes(fit.id)) fit.close();
    this.#changed();
  }

  readonly #changed = (): void => {
    this.#frame ||= requestAnimationFrame(() => {
      this.#frame = 0;
      for (const listener of [...this.#listeners]) listener();
    });
  };
}
