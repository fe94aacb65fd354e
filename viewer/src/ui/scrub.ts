/** The slider over all iterations, and what can be said of the one that is shown. */

import type { App } from "../app.js";
import { byId, el } from "../html.js";
import { icon } from "./icons.js";
import { count, short } from "../text/numbers.js";
import { SPEEDS, changeSpeed, stepBy, togglePlay } from "./player.js";

export function scrub(app: App): void {
  const root = byId("scrub");
  const { view, fits } = app;
  const play = el("button", { type: "button", class: "play", id: "play", onclick: () => togglePlay(app) });
  const step = (by: -1 | 1, name: string) => el("button", { type: "button", class: "icon", title: `${name} (${by < 0 ? "←" : "→"})`, "aria-label": name, onclick: () => stepBy(app, by) }, icon(by < 0 ? "back" : "forward"));
  const speed = el("select", { id: "speed", "aria-label": "Speed", title: "Speed (< and >)" }, ...SPEEDS.map((factor) => el("option", { value: factor }, speedName(factor))));
  speed.addEventListener("change", () => view.set({ speed: Number(speed.value) }));
  const loop = el("button", { type: "button", class: "icon", id: "loop", title: "Play again and again (l)", "aria-label": "Loop", onclick: () => view.set({ looping: !view.value.looping }) }, icon("loop"));
  const slider = el("input", { type: "range", id: "slider", min: 0, max: 0, step: 1, value: 0, "aria-label": "Iteration" });
  const number = el("output", { id: "number", for: "slider" });
  const facts = el("dl", { id: "facts" });
  root.append(el("div", { id: "playing" }, step(-1, "Step back"), play, step(1, "Step forward"), speed, loop), slider, number, facts);
  slider.addEventListener("input", () => view.set({ iteration: slider.valueAsNumber, playing: false }));

  let wasPlaying: boolean | null = null;
  const update = () => {
    const { iteration, playing, looping } = view.value;
    speed.value = String(view.value.speed);
    loop.setAttribute("aria-pressed", String(looping));
    const latest = Math.max(0, ...fits.shown.map((fit) => fit.latest));
    const k = iteration === "latest" ? latest : Math.min(iteration, latest);
    if (playing !== wasPlaying) {
      wasPlaying = playing;
      play.replaceChildren(icon(playing ? "pause" : "play"));
      play.setAttribute("aria-label", playing ? "Pause" : "Play");
      play.title = `${playing ? "Pause" : "Play"} (space)`;
    }
    slider.max = String(latest);
    slider.value = String(k);
    slider.disabled = fits.shown.length === 0;
    slider.style.setProperty("--done", latest > 0 ? `${(k / latest) * 100}%` : "0%");
    const [fit] = fits.shown;
    const level = fit?.levels[Math.min(k, fit.latest)];
    slider.setAttribute("aria-valuetext", level === undefined ? "no iteration" : `iteration ${k} of ${latest}, error ${short(level.error.max)}`);
    number.replaceChildren(el("b", {}, count(k)), ` of ${count(latest)}`);
    facts.replaceChildren(
      ...(level === undefined ? [] : [
        ["largest error", short(level.error.max)],
        ["root mean square", short(level.error.rms)],
        ["moved", count(level.moved)],
      ]).map(([name, value]) => el("div", {}, el("dt", {}, name), el("dd", {}, value))),
    );
  };
  view.subscribe(update);
  fits.subscribe(update);
  update();
  addEventListener("keydown", (event) => keys(app, event));
}

/** "¼×", "2×". */
function speedName(factor: number): string {
  return `${({ 0.25: "¼", 0.5: "½" } as Record<number, string>)[factor] ?? factor}×`;
}

/** Arrow keys wherever nothing else wants them. */
function keys(app: App, event: KeyboardEvent): void {
  const { target, key, altKey, ctrlKey, metaKey, shiftKey } = event;
  if (altKey || ctrlKey || metaKey || event.defaultPrevented) return;
  const element = target instanceof Element ? target : null;
  if (element?.closest("input, textarea, select, [contenteditable], [role=tab], [role=listbox], [role=menu]")) return;
  if (key === "ArrowRight" && !shiftKey) stepBy(app, 1);
  else if (key === "ArrowLeft" && !shiftKey) stepBy(app, -1);
  else if (key === "PageDown") stepBy(app, 10);
  else if (key === "PageUp") stepBy(app, -10);
  else if (key === "Home") stepBy(app, -Infinity);
  else if (key === "End") stepBy(app, Infinity);
  else if (key === "l") app.view.set({ looping: !app.view.value.looping });
  else if (key === "<" || key === ">") changeSpeed(app, key === ">" ? 1 : -1);
  else if (key === " " && element?.closest("button, a, summary") == null) togglePlay(app);
  else return;
  event.preventDefault();
}
