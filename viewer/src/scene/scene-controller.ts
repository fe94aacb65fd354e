/** The fits of the view on one viewport. */

import { ConnectionLost } from "piad";

import type { App } from "../app.js";
import type { Axes } from "../fit/axes.js";
import { drawnOf, shareOf } from "../fit/data.js";
import type { Fit } from "../fit/fit.js";
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

/** Keeps what is on the viewport as the view says. */
export class SceneController implements Listener {
  readonly viewport: Viewport;
  fitViews: readonly FitView[] = [];
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
  #isLost = false;
  #hasFailed = false;
  #leaving: readonly FitView[] = [];

  constructor(app: App, viewport: Viewport) {
    this.#app = app;
    this.viewport = viewport;
    app.fits.subscribe(this.#update);
    app.view.subscribe(this.#update);
    let detail = 1;
    viewport.onDraw = () => {
      const now = this.#detail();
      if (now !== detail) this.#update();
      detail = now;
    };
    onPalette(() => {
      viewport.palette = palette();
      this.#update();
    });
    this.#update();
  }

  of(fit: Fit): FitView | undefined {
    return this.fitViews.find((fitView) => fitView.fit === fit);
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
      if (data.axes !== this.#framed) this.viewport.camera.look(data);
      this.#framed = data.axes;
    }
    this.#update();
  }

  drawn(): void {
    if (this.#leaving.length > 0) this.#hang();
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
    // Side by side, spikes are as long as those of the others.
    const largest = Math.max(0, ...this.fitViews.map((fitView) => fitView.fit.levels[fitView.wantedOf(value)]?.error.max ?? 0));
    const look = { layers: value.layers, largest: this.fitViews.length > 1 && value.layers.spikes ? largest : 0, zoom: this.#detail(), cells: this.fitViews.length };
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
    const instead = this.#leaving.filter(({ shown }) => shown !== null);
    const lost = this.fitViews.map(({ fit }) => fit.problem !== null);
    this.viewport.show(this.fitViews.map(({ figure, shown }, i) => (shown === null && !lost[i] ? (instead[i]?.figure ?? figure) : figure)));
    if (!ready) return;
    for (const fitView of this.#leaving) fitView.close();
    this.#leaving = [];
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
