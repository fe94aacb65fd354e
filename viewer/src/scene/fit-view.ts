/** A fit on the viewport: asks for what is to be seen, and shows it when it is there. */

import { ConnectionLost } from "piad";

import { type Curvatures, curvatureOf } from "../fit/curvature.js";
import type { Data } from "../fit/data.js";
import { type Distances, distances } from "../fit/distances.js";
import type { Fit, Level } from "../fit/fit.js";
import type { Layers, View } from "../state.js";
import { Figure } from "./figure.js";
import { type FrameData, type Look, mayApproximate, frameDataOf, loadFrame, samplesFor, samplesOf } from "./frame-data.js";
import type { Samples } from "../fit/geometry.js";

// How many iterations are asked for before they are shown, while they are played.
const AHEAD = 4;
// How long an iteration is looked at until it is asked for exactly, in milliseconds.
const EXACT_DELAY_MS = 250;

/** What a fit tells. */
export interface Listener {
  /** Something is to be drawn anew. */
  drawn(fitView: FitView): void;
  /** The data are here. */
  loaded(fitView: FitView): void;
  failed(fitView: FitView, error: unknown): void;
}

/** An iteration of an edit that is shown and not kept. */
export type Held = Pick<Level, "error" | "controls"> & { readonly number: number };

export class FitView {
  readonly fit: Fit;
  readonly figure = new Figure();
  data: Data | null = null;
  shown: FrameData | null = null;
  /** While a point is dragged the samples are those of an edit: its last iteration. */
  held: Held | null = null;
  readonly #listener: Listener;
  #distances: { readonly of: FrameData; readonly distances: Distances } | null = null;
  #curvature: { readonly of: FrameData; readonly curvature: Curvatures | null } | null = null;
  #wanted = "";
  #isBusy = false;
  #look: Look | null = null;
  #k = -1;
  #failed = -1;
  #pace = 0;
  #wake: () => void = () => {};

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

  /** The number of the iteration that is on the screen; until there is a frame, that of the view. */
  shownOf(view: View): number {
    return this.shown?.k ?? this.wantedOf(view);
  }

  /** Returns true if the iteration that a view means is on the screen, or cannot be. */
  isSettled(view: View): boolean {
    const k = this.wantedOf(view);
    return this.shown?.k === k || this.#failed === k;
  }

  /** The distances of the data from what is on the screen; null without data. */
  distances(): Distances | null {
    const { data, shown, fit } = this;
    if (data === null || shown === null || data.exact.length === 0 || this.held !== null) return null;
    if (this.#distances?.of !== shown) this.#distances = { of: shown, distances: shown.distances ?? distances(data, shown.samples, fit.levels[shown.k]?.error.max ?? Infinity) };
    return this.#distances.distances;
  }

  /** The curvature of what is on the screen; null until it has been asked for, which `isWanted` does. */
  curvature(isWanted: boolean, whenKnown: () => void): Curvatures | null {
    const { data, shown } = this;
    if (shown === null || shown.curvature !== null) return shown?.curvature ?? null;
    if (this.#curvature?.of === shown) return this.#curvature.curvature;
    if (!isWanted || data === null || this.held !== null) return null;
    this.#curvature = { of: shown, curvature: null };
    void curvatureOf(this.fit, data, shown.k, shown.samples).then((curvature) => {
      if (this.#curvature?.of !== shown) return;
      this.#curvature = { of: shown, curvature };
      whenKnown();
    });
    return null;
  }

  /** Shows an iteration; `pace` is how many milliseconds it may take to get there. */
  show(k: number, look: Look, pace: number): void {
    [this.#k, this.#look, this.#pace] = [k, look, pace];
    this.#wake();
    if (!this.#isBusy) void this.#work();
  }

  /** Asks for iterations that will be shown next. */
  prepare(k: number): void {
    const [data, look] = [this.data, this.#look];
    if (data === null || look === null) return;
    for (let next = k + 1; next <= Math.min(k + AHEAD, this.fit.latest); next++) {
      samplesFor(this.fit, data, next, look).catch(() => {});
    }
  }

  /** Shows samples that belong to no iteration of the job, of a point that is dragged. */
  hold(samples: Samples, held: Held, layers: Layers): void {
    const { data } = this;
    if (data === null) return;
    this.held = held;
    const bare = { ...layers, spikes: false, heat: false, between: false };
    this.#set(frameDataOf(this.fit, data, this.#k, samples, null, bare), layers, 0);
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
        const key = this.#keyOf(data, k, look);
        if (key === this.#wanted) return;
        if (await this.#showKept(data, k, look, key)) continue;
        const frame = await loadFrame(this.fit, data, k, look).catch((error: unknown) => this.#missing(error, k, key));
        if (frame === null) continue;
        if (this.held !== null || this.fit.signal.aborted) return;
        this.#wanted = key;
        this.#set(frame, layers, this.#pace);
      }
    } catch (error) {
      if (!this.fit.signal.aborted) this.#listener.failed(this, error);
    } finally {
      this.#isBusy = false;
    }
  }

  #keyOf(data: Data, k: number, look: Look): string {
    const { layers, largest, isPlaying } = look;
    const { fit } = this;
    return JSON.stringify([k, samplesOf(data, look), layers, largest, isPlaying, layers.heat || layers.between ? fit.latest : 0, fit.end?.reason, fit.outline !== null]);
  }

  /**
   * Shows at once what is kept of an iteration. It is asked for exactly when it has been looked at for a
   * moment; returns true if something else is to be shown by then.
   */
  async #showKept(data: Data, k: number, look: Look, key: string): Promise<boolean> {
    const { layers, isPlaying } = look;
    const samples = isPlaying || layers.polygon || !mayApproximate(layers) ? undefined : this.fit.geometry.keptSamples(k, samplesOf(data, look));
    if (samples === undefined) return false;
    if (this.shown?.k !== k || this.shown.samples !== samples) this.#set(frameDataOf(this.fit, data, k, samples, null, layers), layers, this.#pace);
    const isOther = () => this.#look === null || this.#keyOf(data, this.#k, this.#look) !== key || this.held !== null;
    const end = performance.now() + EXACT_DELAY_MS;
    while (!isOther() && performance.now() < end) await this.#sleep(end - performance.now());
    return isOther();
  }

  /** Waits until something else may be shown. */
  async #sleep(milliseconds: number): Promise<void> {
    const timer = setTimeout(() => this.#wake(), milliseconds);
    await new Promise<void>((resolve) => (this.#wake = resolve));
    clearTimeout(timer);
  }

  /** What the server refuses is not asked for again; a connection that is lost may come back. */
  #missing(error: unknown, k: number, key: string): null {
    if (this.fit.signal.aborted || error instanceof ConnectionLost) throw error;
    this.#failed = k;
    this.#wanted = key;
    this.#listener.failed(this, error);
    return null;
  }

  #set(frame: FrameData, layers: Layers, pace: number): void {
    this.shown = frame;
    this.figure.setFrame(frame, pace, performance.now());
    this.figure.setLayers(layers);
    this.#listener.drawn(this);
  }
}
