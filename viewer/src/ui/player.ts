/** Iterations that run by. */

import type { App } from "../app.js";
import type { SceneController } from "../scene/scene-controller.js";

// The first steps change most and are shown longest; milliseconds.
const FIRST = 620;
const LEAST = 45;
// Of more iterations than these, some are passed over.
const LONG = 120;

/** Goes through the iterations while the view says that they are played. */
export function player(app: App, scene: SceneController): void {
  const { view, fits } = app;
  let timer = 0;
  const paceOf = (k: number) => Math.max(LEAST, FIRST / (1 + k / 2.5));
  const step = () => {
    timer = 0;
    const { value } = view;
    if (!value.playing) return;
    const k = value.iteration === "latest" ? 0 : value.iteration;
    const latest = Math.max(-1, ...fits.shown.map((fit) => fit.latest));
    const arrived = scene.fitViews.every((fitView) => fitView.isSettled(value));
    if (latest > k && arrived) {
      scene.pace = paceOf(k + 1);
      view.set({ iteration: k + Math.max(1, Math.floor((latest - k) / LONG)) });
    } else if (latest >= 0 && k >= latest && arrived && fits.shown.every((fit) => fit.end !== null || fit.problem !== null)) {
      view.set({ iteration: "latest", playing: false });
      return;
    }
    timer = window.setTimeout(step, arrived ? paceOf(k) : LEAST);
  };
  const begin = () => {
    if (!view.value.playing || timer !== 0) return;
    if (view.value.iteration === "latest") view.set({ iteration: 0 });
    timer = window.setTimeout(step, scene.fitViews.some(({ shown }) => shown !== null) ? 0 : LEAST);
  };
  view.subscribe(begin);
  begin();
}

/** Plays from the beginning where the end has been reached, else goes on; or stops. */
export function togglePlay({ view, fits }: App): void {
  const { playing, iteration } = view.value;
  const latest = Math.max(0, ...fits.shown.map((fit) => fit.latest));
  const atEnd = iteration === "latest" || iteration >= latest;
  view.set(playing ? { playing: false } : { playing: true, iteration: atEnd ? 0 : iteration });
}

/** Goes some iterations forth or back. */
export function stepBy({ view, fits }: App, by: number): void {
  const latest = Math.max(0, ...fits.shown.map((fit) => fit.latest));
  const { iteration } = view.value;
  const k = Math.max(0, Math.min(latest, (iteration === "latest" ? latest : iteration) + by));
  view.set({ iteration: k, playing: false });
}
