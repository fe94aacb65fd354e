/** Iterations that are played one after the other. */

import type { App } from "../app.js";
import type { SceneController } from "../scene/scene-controller.js";

// How long all iterations take at normal speed, in milliseconds.
const WHOLE = 4000;
// The first steps change most and are shown longest, but no longer than this; milliseconds at normal speed.
const LONGEST = 620;
// No step is shorter, at any speed.
const LEAST = 30;
// Of more iterations than these, some are passed over.
const LONG = 120;

/** The speeds, as factors. */
export const SPEEDS = [0.25, 0.5, 1, 2, 4] as const;

/** Goes through the iterations while the view says that they are played. */
export function player(app: App, scene: SceneController): void {
  const { view, fits } = app;
  let timer = 0;
  let arrivedAt = 0;
  const step = () => {
    timer = 0;
    const { value } = view;
    if (!value.playing) return;
    const k = value.iteration === "latest" ? 0 : value.iteration;
    const latest = Math.max(-1, ...fits.shown.map((fit) => fit.latest));
    const arrived = scene.fitViews.every((fitView) => fitView.isSettled(value));
    const expected = Math.max(latest, ...fits.shown.map((fit) => (fit.end === null ? Math.min(LONG, fit.head?.predicted.iterations ?? 0) : 0)));
    if (arrived) arrivedAt ||= performance.now();
    // What an iteration takes to arrive is a part of its time.
    const rest = arrived ? paceOf(k, expected) / value.speed - (performance.now() - arrivedAt) : 0;
    if (latest > k && arrived && rest <= 0) {
      scene.pace = paceOf(k + 1, expected) / value.speed;
      arrivedAt = 0;
      view.set({ iteration: Math.min(latest, k + Math.max(1, Math.ceil(latest / LONG))) });
    } else if (latest >= 0 && k >= latest && arrived && rest <= 0 && fits.shown.every((fit) => fit.end !== null || fit.problem !== null)) {
      arrivedAt = 0;
      view.set(value.looping && latest > 0 ? { iteration: 0 } : { iteration: "latest", playing: false });
      if (!value.looping) return;
    }
    timer = window.setTimeout(step, Math.max(arrived ? 4 : LEAST, rest));
  };
  const begin = () => {
    if (!view.value.playing || timer !== 0) return;
    arrivedAt = 0;
    if (view.value.iteration === "latest") view.set({ iteration: 0 });
    timer = window.setTimeout(step, scene.fitViews.some(({ shown }) => shown !== null) ? 0 : LEAST);
  };
  view.subscribe(begin);
  begin();
}

/** How long an iteration is shown of this number of them, in milliseconds at normal speed. */
function paceOf(k: number, count: number): number {
  const share = (at: number) => 1 / (1 + at / 8);
  const shown = Math.min(count + 1, LONG);
  let sum = 0;
  for (let at = 0; at < shown; at++) sum += share(at);
  return Math.min(LONGEST, Math.max(LEAST, (WHOLE * share((k / Math.max(1, count)) * shown)) / sum));
}

/** Plays from the beginning where the end has been reached, else goes on; or stops. */
export function togglePlay({ view, fits }: App): void {
  const { playing, iteration } = view.value;
  const latest = Math.max(0, ...fits.shown.map((fit) => fit.latest));
  const atEnd = iteration === "latest" || iteration >= latest;
  view.set(playing ? { playing: false } : { playing: true, iteration: atEnd ? 0 : iteration });
}

/** Plays faster or slower by a step of the speeds. */
export function changeSpeed({ view }: App, by: 1 | -1): void {
  const at = SPEEDS.indexOf(view.value.speed as (typeof SPEEDS)[number]) + by;
  view.set({ speed: SPEEDS[Math.max(0, Math.min(SPEEDS.length - 1, at))]! });
}

/** Goes some iterations forth or back. */
export function stepBy({ view, fits }: App, by: number): void {
  const latest = Math.max(0, ...fits.shown.map((fit) => fit.latest));
  const { iteration } = view.value;
  const k = Math.max(0, Math.min(latest, (iteration === "latest" ? latest : iteration) + by));
  view.set({ iteration: k, playing: false });
}
