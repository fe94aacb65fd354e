/** The fits of the view on one stage. */

import { ConnectionLost } from "piad";

import type { App } from "../app.js";
import type { Axes } from "../fit/axes.js";
import { drawnOf, shareOf } from "../fit/data.js";
import type { Fit } from "../fit/fit.js";
import { Exhibit, type Listener } from "./exhibit.js";
import { count } from "../text/numbers.js";
import { sentence } from "../text/errors.js";
import { onPalette, palette } from "./palette.js";
import { Stage } from "./stage.js";

// Milliseconds that the way from one iteration to the next takes, unless they follow each other faster.
const GLIDE = 160;
// Of more fits than these no streams of samples are open: browsers have six connections to a server.
const MOST_STREAMED_FITS = 2;
// After a lost connection, in milliseconds.
const AGAIN = 3000;

/** Keeps what is on the stage as the view says. */
export class Hall implements Listener {
  readonly stage: Stage;
  exhibits: readonly Exhibit[] = [];
  /** How long each iteration is shown while they are played, in milliseconds. */
  pace = GLIDE;
  /** Called when the first picture has been drawn. */
  onFirst: () => void = () => {};
  /** Called when a picture has changed. */
  onPicture: () => void = () => {};
  readonly #app: App;
  readonly #still = matchMedia("(prefers-reduced-motion: reduce)");
  #framed: Axes | null = null;
  #frame = 0;
  #isSeen = false;
  #isLost = false;
  #hasFailed = false;
  #leaving: readonly Exhibit[] = [];

  constructor(app: App, stage: Stage) {
    this.#app = app;
    this.stage = stage;
    app.fits.subscribe(this.#update);
    app.view.subscribe(this.#update);
    let detail = 1;
    stage.onDraw = () => {
      const now = this.#detail();
      if (now !== detail) this.#update();
      detail = now;
    };
    onPalette(() => {
      stage.palette = palette();
      this.#update();
    });
    this.#update();
  }

  of(fit: Fit): Exhibit | undefined {
    return this.exhibits.find((exhibit) => exhibit.fit === fit);
  }

  loaded(exhibit: Exhibit): void {
    const { data } = exhibit;
    // The first of the jobs says where the camera is; edits of it leave the camera where it is.
    if (data !== null && data.exact.length === 0) {
      this.#app.say(`There are ${count(exhibit.fit.head?.points ?? 0)} data points, which are not drawn.`);
    } else if (data !== null && shareOf(data) > 1) {
      this.#app.say(`${count(drawnOf(data).length / 3)} of ${count(data.positions.length / 3)} data points are drawn.`);
    }
    if (data !== null && exhibit === this.exhibits[0]) {
      if (data.axes !== this.#framed) this.stage.rig.look(data);
      this.#framed = data.axes;
    }
    this.#update();
  }

  drawn(): void {
    if (this.#leaving.length > 0) this.#hang();
    this.stage.invalidate();
    if (!this.#isSeen) {
      // After the stage, in the same frame.
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
    this.onPicture();
  }

  failed(exhibit: Exhibit, error: unknown): void {
    if (error instanceof ConnectionLost) {
      this.#isLost = true;
      setTimeout(this.#update, AGAIN);
    }
    // What befalls the job as a whole is said once, by who follows it.
    if (exhibit.fit.problem !== null) return;
    this.#hasFailed = true;
    this.#app.say(sentence(error), "error");
  }

  readonly #update = (): void => {
    const { fits, view } = this.#app;
    const { value } = view;
    if (fits.shown.length !== this.exhibits.length || fits.shown.some((fit, i) => this.exhibits[i]?.fit !== fit)) {
      const old = this.exhibits;
      this.exhibits = fits.shown.map((fit) => old.find((exhibit) => exhibit.fit === fit) ?? new Exhibit(fit, this));
      this.#leaving = old.filter((exhibit) => !this.exhibits.includes(exhibit)).concat(this.#leaving);
      this.#hang();
    } else if (this.#leaving.length > 0) this.#hang();
    // Side by side, spikes are as long as those of the others.
    const largest = Math.max(0, ...this.exhibits.map((exhibit) => exhibit.fit.levels[exhibit.wantedOf(value)]?.error.max ?? 0));
    const look = { layers: value.layers, largest: this.exhibits.length > 1 && value.layers.spikes ? largest : 0, zoom: this.#detail(), cells: this.exhibits.length };
    const plays = ({ fit }: Exhibit) => this.exhibits.length <= MOST_STREAMED_FITS && (value.playing || (value.iteration === "latest" && fit.end === null));
    const pace = this.#still.matches ? 0 : Math.min(GLIDE, value.playing ? this.pace : GLIDE);
    this.exhibits.forEach((exhibit, i) => {
      exhibit.figure.setColors(this.stage.palette, i, this.exhibits.length);
      exhibit.figure.setLayers(value.layers);
      const k = exhibit.wantedOf(value);
      exhibit.show(k, { ...look, isPlaying: plays(exhibit) }, pace);
      if (value.playing) exhibit.prepare(k);
    });
    this.stage.invalidate();
  };

  /** Until an exhibit has its picture, what it comes after stays: nothing flickers. */
  #hang(): void {
    const ready = this.exhibits.every(({ shown }) => shown !== null);
    const instead = this.#leaving.filter(({ shown }) => shown !== null);
    const lost = this.exhibits.map(({ fit }) => fit.problem !== null);
    this.stage.show(this.exhibits.map(({ figure, shown }, i) => (shown === null && !lost[i] ? (instead[i]?.figure ?? figure) : figure)));
    if (!ready) return;
    for (const exhibit of this.#leaving) exhibit.close();
    this.#leaving = [];
  }

  /** How fine samples are at this zoom, as powers of two. */
  #detail(): number {
    return 2 ** Math.floor(Math.log2(Math.max(1, this.stage.rig.zoom / 1.3)));
  }

  /** Draws until all figures have arrived. */
  #glide(): void {
    this.#frame ||= requestAnimationFrame((now) => {
      this.#frame = 0;
      const moving = this.exhibits.map(({ figure }) => figure.step(now));
      this.stage.invalidate();
      if (moving.includes(true)) this.#glide();
    });
  }
}
