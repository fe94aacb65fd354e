/** What an edit would make, while a point is dragged. */

import type { SampledIteration, api } from "piad";

import { countsOfShape } from "../fit/controls.js";
import type { Data } from "../fit/data.js";
import { indexOf } from "../fit/data.js";
import type { Fit } from "../fit/fit.js";
import { type Samples, pointsOf } from "../fit/geometry.js";
import type { Held } from "../scene/fit-view.js";
import type { Place } from "../state.js";

/** A data point that goes elsewhere, gets another weight, or both. */
export interface Move {
  readonly place: Place;
  readonly point?: readonly number[];
  readonly weight?: number;
}

// From so many points on only what is around the moved one is fitted again.
const MANY = 2000;
// How many points to each side those are.
const AROUND = { curve: 8, surface: 4 } as const;
// A glance need not be exact.
const GLANCE = 40;
// A glance that takes longer than this, in milliseconds, is given up for the newest.
const STALE = 1000;

/** By the server this page is known as one that drags; what it asks for takes the place of what it asked before. */
const SESSION = Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, "0")).join("");

/** The request that makes a move last. */
export function editOf(fit: Fit, data: Data, move: Move): api.EditRequest {
  const { place, point, weight } = move;
  const request: Record<string, unknown> = { name: fit.head?.name ?? null };
  if (weight !== undefined && data.weights === null) {
    const flat = Array.from({ length: data.rows * data.columns }, (_, i) => (i === indexOf(data, place) ? weight : 1));
    request["weights"] = data.isSurface ? Array.from({ length: data.rows }, (_, i) => flat.slice(i * data.columns, (i + 1) * data.columns)) : flat;
  } else {
    request["points"] = [{ index: place, ...(point && { point }), ...(weight !== undefined && { weight }) }];
  }
  const local = localTo(fit, data, place);
  if (local !== null) request["method"] = local;
  return request as api.EditRequest;
}

/** Asks for glances, one at a time: the newest counts. */
export class Preview {
  readonly #fit: Fit;
  readonly #data: Data;
  readonly #samples: api.Samples;
  readonly #shown: (samples: Samples, held: Held) => void;
  readonly #failed: (error: unknown) => void;
  #next: Move | null = null;
  #running: { readonly controller: AbortController; readonly since: number } | null = null;
  #ended = false;

  constructor(fit: Fit, data: Data, samples: api.Samples, shown: (samples: Samples, held: Held) => void, failed: (error: unknown) => void) {
    this.#fit = fit;
    this.#data = data;
    this.#samples = samples;
    this.#shown = shown;
    this.#failed = failed;
  }

  move(move: Move): void {
    this.#next = move;
    if (this.#running === null) void this.#work();
    else if (performance.now() - this.#running.since > STALE) this.#running.controller.abort();
  }

  /** Nothing that comes later is shown. */
  end(): void {
    this.#ended = true;
    this.#next = null;
    this.#running?.controller.abort();
  }

  async #work(): Promise<void> {
    while (this.#next !== null) {
      const move = this.#next;
      this.#next = null;
      const controller = new AbortController();
      this.#running = { controller, since: performance.now() };
      try {
        const level = await this.#glance(move, controller.signal);
        if (!this.#ended && level !== null) {
          const controls = countsOfShape(level.shape) ?? this.#fit.levels.at(-1)?.controls ?? 0;
          const samples = { ...pointsOf(level.samples, this.#data.axes, level.parameters), parameters: level.parameters };
          this.#shown(samples, { number: level.number, error: level.error, controls });
        }
      } catch (error) {
        if (!controller.signal.aborted && !this.#ended) this.#failed(error);
      }
    }
    this.#running = null;
  }

  /** The last iteration of an edit that nobody keeps. */
  async #glance(move: Move, signal: AbortSignal): Promise<SampledIteration | null> {
    const tolerance = this.#fit.head?.stop.tolerance ?? 0;
    const request = { ...editOf(this.#fit, this.#data, move), stop: { tolerance, max_iterations: GLANCE } };
    const job = await this.#fit.known();
    const encoding = this.#data.isSurface && !this.#data.axes.isMoved ? "base64_f32" : "base64";
    const stream = job.editStream(
      { ...request, ephemeral: true, session: SESSION },
      { view: "samples", samples: this.#samples, encoding, every: 1_000_000, describe: "none", signal },
    );
    let last: SampledIteration | null = null;
    for await (const iteration of stream) last = iteration;
    return last;
  }
}

/** The points around a moved one, of fits in which others need not move. */
function localTo(fit: Fit, data: Data, place: Place): api.Method | null {
  const kind = fit.head?.method.kind;
  const count = data.rows * data.columns;
  if (count < MANY || data.isScattered || kind === undefined) return null;
  if (!["global", "weighted", "local", "adaptive", "chebyshev", "direct"].includes(kind)) return null;
  const near = (at: number, most: number, around: number) => {
    const first = Math.max(0, at - around);
    return Array.from({ length: Math.min(most - 1, at + around) - first + 1 }, (_, i) => first + i);
  };
  const indices = typeof place === "number"
    ? near(place, data.columns, AROUND.curve)
    : near(place[0], data.rows, AROUND.surface).flatMap((i) => near(place[1], data.columns, AROUND.surface).map((j) => [i, j]));
  return { kind: "local", indices } as api.Method;
}
