/** A fit on the stage: asks for what is to be seen, and shows it when it is there. */

import { ConnectionLost } from "piad";

import type { Data } from "../fit/data.js";
import type { Fit, Level } from "../fit/fit.js";
import type { Layers, View } from "../state.js";
import { Figure } from "./figure.js";
import { type Judged, type Look, judged, pictureOf, precise, samplesOf } from "./picture.js";
import type { Samples } from "../fit/geometry.js";

// How many iterations are asked for before they are shown, while they are played.
const AHEAD = 4;

/** What an exhibit tells. */
export interface Listener {
  /** Something is to be drawn anew. */
  drawn(exhibit: Exhibit): void;
  /** The data are here. */
  loaded(exhibit: Exhibit): void;
  failed(exhibit: Exhibit, error: unknown): void;
}

/** An iteration of an edit that is shown and not kept. */
export type Held = Pick<Level, "error" | "controls"> & { readonly number: number };

export class Exhibit {
  readonly fit: Fit;
  readonly figure = new Figure();
  data: Data | null = null;
  shown: Judged | null = null;
  /** While a point is dragged the samples are those of an edit: its last iteration. */
  held: Held | null = null;
  readonly #listener: Listener;
  #wanted = "";
  #isBusy = false;
  #look: Look | null = null;
  #k = -1;
  #failed = -1;
  #pace = 0;

  constructor(fit: Fit, listener: Listener) {
    this.fit = fit;
    this.#listener = listener;
    fit.data().then(
      (data) => {
        if (fit.signal.aborted) return;
        this.data = data;
        this.figure.setData(data);
        listener.loaded(this);
      },
      (error) => fit.signal.aborted || listener.failed(this, error),
    );
  }

  /** The number of the iteration that a view means for this fit; -1 as long as there is none. */
  wantedOf({ iteration }: View): number {
    return iteration === "latest" ? this.fit.latest : Math.min(iteration, this.fit.latest);
  }

  /** The number of the iteration that is on the screen; until there is a picture, that of the view. */
  shownOf(view: View): number {
    return this.shown?.k ?? this.wantedOf(view);
  }

  /** Returns true if the iteration that a view means is on the screen, or cannot be. */
  isSettled(view: View): boolean {
    const k = this.wantedOf(view);
    return this.shown?.k === k || this.#failed === k;
  }

  /** Shows an iteration; `pace` is how many milliseconds it may take to get there. */
  show(k: number, look: Look, pace: number): void {
    [this.#k, this.#look, this.#pace] = [k, look, pace];
    if (!this.#isBusy) void this.#work();
  }

  /** Asks for iterations that will be shown next. */
  prepare(k: number): void {
    const [data, look] = [this.data, this.#look];
    if (data === null || look === null) return;
    for (let next = k + 1; next <= Math.min(k + AHEAD, this.fit.latest); next++) {
      this.fit.gallery.samples(next, samplesOf(data, look), precise(data, look.layers), data.axes).catch(() => {});
    }
  }

  /** Shows samples that belong to no iteration of the job, of a point that is dragged. */
  hold(samples: Samples, held: Held, layers: Layers): void {
    const { data } = this;
    if (data === null) return;
    this.held = held;
    const bare = { ...layers, spikes: false, heat: false };
    this.#set(judged(this.fit, data, this.#k, samples, null, bare), layers, 0);
  }

  /** Back to the iterations of the job. */
  release(): void {
    this.held = null;
    this.#wanted = "";
    if (!this.#isBusy) void this.#work();
  }

  close(): void {
    this.figure.dispose();
  }

  async #work(): Promise<void> {
    this.#isBusy = true;
    try {
      for (;;) {
        const [data, look, k] = [this.data, this.#look, this.#k];
        if (data === null || look === null || k < 0 || this.held !== null) return;
        const { layers } = look;
        const key = JSON.stringify([k, samplesOf(data, look), layers, look.largest, layers.heat ? this.fit.latest : 0, this.fit.end?.reason, this.fit.outline !== null]);
        if (key === this.#wanted) return;
        const picture = await pictureOf(this.fit, data, k, look).catch((error: unknown) => this.#missing(error, k, key));
        if (picture === null) continue;
        if (this.held !== null || this.fit.signal.aborted) return;
        this.#wanted = key;
        this.#set(picture, layers, this.#pace);
      }
    } catch (error) {
      if (!this.fit.signal.aborted) this.#listener.failed(this, error);
    } finally {
      this.#isBusy = false;
    }
  }

  /** What the server refuses is not asked for again; a connection that is lost may come back. */
  #missing(error: unknown, k: number, key: string): null {
    if (this.fit.signal.aborted || error instanceof ConnectionLost) throw error;
    this.#failed = k;
    this.#wanted = key;
    this.#listener.failed(this, error);
    return null;
  }

  #set(picture: Judged, layers: Layers, pace: number): void {
    this.shown = picture;
    this.figure.setPicture(picture, pace, performance.now());
    this.figure.setLayers(layers);
    this.#listener.drawn(this);
  }
}
