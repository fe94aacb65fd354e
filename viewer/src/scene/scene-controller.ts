/** The fits of the view on one viewport. */

import { ConnectionLost, type api } from "piad";

import type { App } from "../app.js";
import { type Axes, type Box, around } from "../fit/axes.js";
import { type Data, dataBefore, drawnOf, shareOf } from "../fit/data.js";
import { apart, heatOf } from "../fit/distances.js";
import type { Fit } from "../fit/fit.js";
import { Figure } from "./figure.js";
import { FitView, type Listener } from "./fit-view.js";
import { count } from "../text/numbers.js";
import { sentence } from "../text/errors.js";
import { onPalette, palette } from "./palette.js";
import { Viewport } from "./viewport.js";

// Milliseconds that the way from one iteration to the next takes, unless they follow each other faster.
const GLIDE = 160;
// Of more fits than these no streams of samples are open: browsers have six connections to a server.
const MOST_STREAMED_FITS = 2;
// After a lost connection, in milliseconds.
const AGAIN = 3000;

/** Points that are drawn before they are fitted. */
export interface Preview {
  readonly title: string;
  readonly count: number;
  readonly figure: Figure;
}

/** Keeps what is on the viewport as the view says. */
export class SceneController implements Listener {
  readonly viewport: Viewport;
  fitViews: readonly FitView[] = [];
  /** Points that are not fitted yet; null as soon as something else is drawn. */
  points: Preview | null = null;
  /** The largest distance between fits that are compared in one scene; null where they are not. */
  difference: number | null = null;
  /** The box that is drawn with a radius of one; null before there is data. */
  box: Box | null = null;
  /** How long each iteration is shown while they are played, in milliseconds. */
  pace = GLIDE;
  /** Called when the first picture has been drawn. */
  onFirst: () => void = () => {};
  /** Called when a picture has changed. */
  onFrame: () => void = () => {};
  readonly #app: App;
  readonly #still = matchMedia("(prefers-reduced-motion: reduce)");
  #framed: Axes | null = null;
  #frame = 0;
  #isSeen = false;
  #isTogether = false;
  #isLost = false;
  #hasFailed = false;
  #leaving: readonly FitView[] = [];

  constructor(app: App, viewport: Viewport) {
    this.#app = app;
    this.viewport = viewport;
    app.fits.subscribe(this.#update);
    app.view.subscribe(this.#update);
    let detail = 1;
    viewport.onDraw(() => {
      const now = this.#detail();
      if (now !== detail) this.#update();
      detail = now;
    });
    onPalette(() => {
      viewport.palette = palette();
      this.#update();
    });
    this.#update();
  }

  of(fit: Fit): FitView | undefined {
    return this.fitViews.find((fitView) => fitView.fit === fit);
  }

  /** Shows the points of a request alone, until another job is shown. */
  preview(title: string, request: api.JobRequest): void {
    const data = dataBefore(request);
    this.points?.figure.dispose();
    this.points = { title, count: data.positions.length / 3, figure: new Figure() };
    this.points.figure.setData(data);
    this.#framed = this.box = data.axes;
    this.viewport.camera.look([data], data.axes);
    this.#app.view.set({ jobs: [], selection: null });
    this.#hang();
    this.onFrame();
    this.#update();
  }

  loaded(fitView: FitView): void {
    const { data } = fitView;
    // The first of the jobs says where the camera is; edits of it leave the camera where it is.
    if (data !== null && data.exact.length === 0) {
      this.#app.say(`There are ${count(fitView.fit.head?.points ?? 0)} data points, which are not drawn.`);
    } else if (data !== null && shareOf(data) > 1) {
      this.#app.say(`${count(drawnOf(data).length / 3)} of ${count(data.positions.length / 3)} data points are drawn.`);
    }
    if (data !== null && fitView === this.fitViews[0]) {
      const isSame = data.axes === this.#framed || (this.points !== null && this.#framed?.isLike(data.axes));
      if (!isSame && !this.viewport.isOverlaid) this.viewport.camera.look([data], data.axes);
      this.#framed = data.axes;
    }
    this.#together();
    this.#update();
  }

  drawn(): void {
    if (this.#leaving.length > 0 || this.points !== null) this.#hang();
    this.viewport.invalidate();
    if (!this.#isSeen) {
      // After the viewport, in the same frame.
      requestAnimationFrame(() => {
        performance.mark("first picture");
        // What is made next would be in its way to the screen.
        setTimeout(this.onFirst, 50);
      });
    }
    this.#isSeen = true;
    if (this.#isLost) this.#app.say("The server is there again.");
    else if (this.#hasFailed) this.#app.forget();
    this.#isLost = this.#hasFailed = false;
    this.#compare();
    this.#glide();
    this.onFrame();
  }

  failed(fitView: FitView, error: unknown): void {
    if (error instanceof ConnectionLost) {
      this.#isLost = true;
      setTimeout(this.#update, AGAIN);
    }
    // What befalls the job as a whole is said once, by who follows it.
    if (fitView.fit.problem !== null) return;
    this.#hasFailed = true;
    this.#app.say(sentence(error), "error");
  }

  readonly #update = (): void => {
    const { fits, view } = this.#app;
    const { value } = view;
    if (fits.shown.length !== this.fitViews.length || fits.shown.some((fit, i) => this.fitViews[i]?.fit !== fit)) {
      const old = this.fitViews;
      this.fitViews = fits.shown.map((fit) => old.find((fitView) => fitView.fit === fit) ?? new FitView(fit, this));
      this.#leaving = old.filter((fitView) => !this.fitViews.includes(fitView)).concat(this.#leaving);
      this.#hang();
    } else if (this.#leaving.length > 0) this.#hang();
    this.points?.figure.setLayers(value.layers);
    this.points?.figure.setColors(this.viewport.palette, 0, 1);
    // Side by side, spikes are as long as those of the others.
    const largest = Math.max(0, ...this.fitViews.map((fitView) => fitView.fit.levels[fitView.wantedOf(value)]?.error.max ?? 0));
    const isTogether = value.overlaid && this.fitViews.length > 1;
    const look = { layers: value.layers, largest: this.fitViews.length > 1 && value.layers.spikes ? largest : 0, zoom: this.#detail(), cells: isTogether ? 1 : this.fitViews.length, isCommon: isTogether };
    if (isTogether !== this.viewport.isOverlaid) {
      this.viewport.isOverlaid = isTogether;
      this.#hang();
      this.#together();
    }
    this.viewport.front = isTogether ? (this.fitViews.find(({ fit }) => fit.id === value.front)?.figure ?? null) : null;
    const plays = ({ fit }: FitView) => this.fitViews.length <= MOST_STREAMED_FITS && (value.playing || (value.iteration === "latest" && fit.end === null));
    const pace = this.#still.matches ? 0 : Math.min(GLIDE, value.playing ? this.pace : GLIDE);
    this.fitViews.forEach((fitView, i) => {
      fitView.figure.setColors(this.viewport.palette, i, this.fitViews.length);
      fitView.figure.setLayers(value.layers);
      const k = fitView.wantedOf(value);
      fitView.show(k, { ...look, isPlaying: plays(fitView) }, pace);
      if (value.playing) fitView.prepare(k);
    });
    this.viewport.invalidate();
  };

  /** Until a fit has its picture, what it comes after stays: nothing flickers. */
  #hang(): void {
    const ready = this.fitViews.every(({ shown }) => shown !== null);
    const instead = this.points === null ? this.#leaving.filter(({ shown }) => shown !== null) : [this.points];
    const lost = this.fitViews.map(({ fit }) => fit.problem !== null);
    const figures = this.fitViews.map(({ figure, shown }, i) => (shown === null && !lost[i] ? (instead[i]?.figure ?? figure) : figure));
    this.viewport.show(figures.length === 0 && this.points !== null ? [this.points.figure] : figures);
    if (!ready) return;
    if (this.fitViews.length > 0) {
      this.points?.figure.dispose();
      this.points = null;
    }
    for (const fitView of this.#leaving) fitView.close();
    this.#leaving = [];
  }

  /** Where several fits are drawn in one scene, they have one box. */
  #together(): void {
    const all = this.fitViews.flatMap(({ data }) => data ?? []);
    const [first] = all;
    if (first === undefined) return;
    const isTogether = this.viewport.isOverlaid;
    const box = isTogether ? around(all.map(({ axes }) => axes)) : first.axes;
    for (const { data, figure } of this.fitViews) if (data !== null) figure.setPlace(isTogether ? box : data.axes);
    const isSame = this.box !== null && this.box.radius === box.radius && this.box.centre.every((c, axis) => c === box.centre[axis]);
    const look: readonly Data[] = isTogether ? all : [first];
    if (!isSame && (isTogether || this.#isTogether)) this.viewport.camera.look(look, box);
    this.box = box;
    this.#isTogether = isTogether;
  }

  /** Colours fits in one scene by how far they are from the first one, while errors are shown. */
  #compare(): void {
    const [first, ...others] = this.fitViews;
    this.difference = null;
    if (!this.viewport.isOverlaid || !this.#app.view.value.layers.heat || first?.shown == null) return;
    const all = others.map(({ shown }) => (shown === null ? null : apart(first.shown!.samples, shown.samples)));
    const largest = Math.max(0, ...all.map((lengths) => lengths?.reduce((most, length) => Math.max(most, length), 0) ?? 0));
    if (largest === 0) return;
    this.difference = largest;
    first.figure.setHeat(null);
    others.forEach(({ figure }, i) => figure.setHeat(all[i] === null ? null : Float32Array.from(all[i]!, (length) => heatOf(length, largest / 1000, largest))));
    for (const { figure } of this.fitViews) figure.setLayers(this.#app.view.value.layers);
  }

  /** How fine samples are at this zoom, as powers of two. */
  #detail(): number {
    return 2 ** Math.floor(Math.log2(Math.max(1, this.viewport.camera.zoom / 1.3)));
  }

  /** Draws until all figures have arrived. */
  #glide(): void {
    this.#frame ||= requestAnimationFrame((now) => {
      this.#frame = 0;
      const moving = this.fitViews.map(({ figure }) => figure.step(now));
      this.viewport.invalidate();
      if (moving.includes(true)) this.#glide();
    });
  }
}
