/** The geometry of iterations, as far as it was asked for. */

import type { FittedIteration, Job, SampledIteration, api } from "piad";

import { type Points, type Samples, pointsOf, thinned } from "./geometry.js";
import type { Axes } from "./axes.js";
import { Recent } from "./lru.js";
import { Playback } from "./playback.js";
import { type Level, DeltaStream, type Request } from "./delta-stream.js";

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
export class GeometryCache {
  readonly #fit: Source;
  readonly #kept = new Recent<Points>(MOST);
  readonly #coming = new Map<string, Promise<Points>>();
  readonly #playback = new Playback();
  readonly #controlPlayback = new Playback();

  constructor(fit: Source) {
    this.#fit = fit;
  }

  /** The curve or surface of an iteration; `precise` with 64 bits. */
  samples(k: number, samples: api.Samples, precise: boolean, axes: Axes): Promise<Samples> {
    const exact = this.#kept.get(keyOf(k, samples, "base64"));
    if (exact !== undefined) return Promise.resolve(exact as Samples);
    const encoding = precise || axes.isMoved ? "base64" : "base64_f32";
    return this.#get(keyOf(k, samples, encoding), async (signal) => {
      const job = await this.#fit.known();
      return samplesOf(await job.iteration(k, { view: "samples", samples, encoding: await this.#fits(encoding, k), signal }), axes);
    }) as Promise<Samples>;
  }

  /**
   * The curve or surface of an iteration during playback, within a hundredth of its error: those that follow each
   * other come as differences.
   */
  async approximate(k: number, samples: api.Samples, axes: Axes): Promise<Samples> {
    const keep = (level: Level, isExact: boolean) => {
      if (level.view === "samples") this.#keep(keyOf(level.number, samples, isExact ? "base64" : "delta"), samplesOf(level, axes));
    };
    await this.#playback.reach(k, samples, this.keptSamples(k, samples) !== undefined, (after) => this.#stream({ samples, after, keep }));
    return this.keptSamples(k, samples) ?? this.samples(k, samples, false, axes);
  }

  /** The control polygon or net of an iteration during playback. */
  async approximateControl(k: number, axes: Axes): Promise<Points> {
    const kept = () => this.#kept.get(controlKeyOf(k, true)) ?? this.#kept.get(controlKeyOf(k, false));
    const keep = (level: Level, isExact: boolean) => {
      if (level.view === "control_points") this.#keep(controlKeyOf(level.number, isExact), netOf(level, axes));
    };
    await this.#controlPlayback.reach(k, null, kept() !== undefined, (after) => this.#stream({ after, keep }));
    return kept() ?? this.control(k, axes);
  }

  /** The best that is here of an iteration. */
  keptSamples(k: number, samples: api.Samples): Samples | undefined {
    for (const encoding of ["base64", "base64_f32", "delta"] as const) {
      const kept = this.#kept.get(keyOf(k, samples, encoding));
      if (kept !== undefined) return kept as Samples;
    }
    return undefined;
  }

  #stream(request: Pick<Request, "samples" | "after" | "keep">): DeltaStream {
    return new DeltaStream({ ...request, job: this.#fit.known(), signal: this.#fit.signal });
  }

  /** The control polygon or net of an iteration. */
  control(k: number, axes: Axes): Promise<Points> {
    return this.#get(controlKeyOf(k, true), async (signal) => {
      const job = await this.#fit.known();
      return netOf(await job.iteration(k, { view: "control_points", encoding: "base64", signal }), axes);
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
      .then((points) => this.#keep(key, points))
      .finally(() => this.#coming.delete(key));
    this.#coming.set(key, asked);
    return asked;
  }

  #keep(key: string, points: Points): Points {
    this.#kept.set(key, points, points.exact.byteLength + points.positions.byteLength);
    return points;
  }
}

function keyOf(k: number, samples: api.Samples, encoding: api.NumberEncoding): string {
  return `${k} ${samples} ${encoding}`;
}

function samplesOf(level: SampledIteration, axes: Axes): Samples {
  return { ...pointsOf(level.samples, axes, level.parameters), parameters: level.parameters };
}

function controlKeyOf(k: number, isExact: boolean): string {
  return isExact ? `${k} control` : `${k} control delta`;
}

function netOf(level: FittedIteration, axes: Axes): Points {
  return thinned(pointsOf(level.controlPoints, axes), MOST_NET);
}
