/** The geometry of iterations, as far as it was asked for. */

import type { Job, api } from "piad";

import { type Points, type Samples, pointsOf, thinned } from "./geometry.js";
import type { Axes } from "./axes.js";
import { Recent } from "./lru.js";

// How many bytes of geometry a job keeps.
const MOST = 64_000_000;
// Finer nets are a veil over the surface.
const MOST_NET = 15_000;
// Coordinates beyond this are read with 64 bits.
const LARGE = 1e35;

/** What is read of the fit whose geometry is kept. */
interface Source {
  readonly signal: AbortSignal;
  readonly levels: readonly { readonly error: { readonly max: number | null } }[];
  known(): Promise<Job>;
  data(): Promise<{ readonly axes: Axes }>;
}

/** Samples and control points of the iterations of a job. Each is asked for once while it is kept. */
export class Gallery {
  readonly #fit: Source;
  readonly #kept = new Recent<Points>(MOST);
  readonly #coming = new Map<string, Promise<Points>>();

  constructor(fit: Source) {
    this.#fit = fit;
  }

  /** The curve or surface of an iteration; `precise` with 64 bits. */
  samples(k: number, samples: api.Samples, precise: boolean, axes: Axes): Promise<Samples> {
    const encoding = precise || axes.isMoved ? "base64" : "base64_f32";
    return this.#get(`${k} ${samples} ${encoding}`, async (signal) => {
      const job = await this.#fit.known();
      const level = await job.iteration(k, { view: "samples", samples, encoding: await this.#fits(encoding, k), signal });
      return { ...pointsOf(level.samples, axes, level.parameters), parameters: level.parameters };
    }) as Promise<Samples>;
  }

  /** The same if it is here already. */
  kept(k: number, samples: api.Samples, precise: boolean, axes: Axes): Samples | undefined {
    const encoding = precise || axes.isMoved ? "base64" : "base64_f32";
    return this.#kept.get(`${k} ${samples} ${encoding}`) as Samples | undefined;
  }

  /** The control polygon or net of an iteration. */
  control(k: number, axes: Axes): Promise<Points> {
    return this.#get(`${k} control`, async (signal) => {
      const job = await this.#fit.known();
      const level = await job.iteration(k, { view: "control_points", encoding: "base64", signal });
      return thinned(pointsOf(level.controlPoints, axes), MOST_NET);
    });
  }

  /** 32 bits do not hold coordinates beyond their range: of the data, or of an iteration that is far from them. */
  async #fits(encoding: api.NumberEncoding, k: number): Promise<api.NumberEncoding> {
    const { axes } = await this.#fit.data();
    const largest = Math.hypot(...axes.centre) + axes.radius;
    const error = this.#fit.levels[k]?.error.max ?? Infinity;
    return largest > LARGE || largest < 1e-37 || error > LARGE ? "base64" : encoding;
  }

  #get(key: string, ask: (signal: AbortSignal) => Promise<Points>): Promise<Points> {
    const kept = this.#kept.get(key);
    if (kept !== undefined) return Promise.resolve(kept);
    const coming = this.#coming.get(key);
    if (coming !== undefined) return coming;
    const asked = ask(this.#fit.signal)
      .then((points) => {
        this.#kept.set(key, points, points.exact.byteLength + points.positions.byteLength);
        return points;
      })
      .finally(() => this.#coming.delete(key));
    this.#coming.set(key, asked);
    return asked;
  }
}
