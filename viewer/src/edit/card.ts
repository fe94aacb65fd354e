/** The chosen data point: its coordinates and its weight, to be changed with keys as well. */

import type { App } from "../app.js";
import { indexOf } from "../fit/data.js";
import { el } from "../html.js";
import type { SceneController } from "../scene/scene-controller.js";
import { icon } from "../ui/icons.js";
import { axisName, placeName, short } from "../text/numbers.js";
import type { Drag } from "./drag.js";
import type { Preview } from "./preview.js";

// Weights from a tenth to ten, equal steps of the slider being equal factors.
const MOST = 10;

export function card(app: App, scene: SceneController, drag: Drag, root: HTMLElement): void {
  const box = el("form", { class: "card", "aria-label": "The chosen data point", hidden: true });
  root.append(box);
  let shown = "";
  const update = () => {
    const { selection, jobs } = app.view.value;
    const key = JSON.stringify([selection, jobs[0], scene.fitViews[0]?.data !== null]);
    if (key === shown) return;
    shown = key;
    const fitView = scene.fitViews[0];
    const data = fitView?.data ?? null;
    box.hidden = selection === null || data === null;
    scene.fitViews[0]?.figure.mark(null);
    if (selection === null || fitView === undefined || data === null) return scene.viewport.invalidate();
    const index = indexOf(data, selection);
    const at = index * data.dimension;
    const numbers = Array.from(data.exact.subarray(at, at + data.dimension));
    fitView.figure.mark([data.positions[index * 3]!, data.positions[index * 3 + 1]!, data.positions[index * 3 + 2]!]);
    scene.viewport.invalidate();
    const inputs = numbers.map((value, axis) => {
      const name = axisName(axis, data.dimension);
      const input = el("input", { type: "number", step: "any", value, "aria-label": name });
      input.addEventListener("change", () => void drag.keep(fitView, { place: selection, point: inputs.map((one) => one.valueAsNumber) }));
      return input;
    });
    const close = el("button", { type: "button", class: "icon", "aria-label": "Close", onclick: () => app.view.set({ selection: null }) }, icon("close"));
    box.replaceChildren(
      el("div", { class: "head" }, el("h2", {}, typeof selection === "number" ? `Point ${placeName(selection)}` : `Point in ${placeName(selection)}`), close),
      el("div", { class: "numbers" }, ...inputs.map((input, axis) => el("label", {}, el("span", {}, axisName(axis, data.dimension)), input))),
      ...weight(),
    );

    /** Fits with many fixed knots have no weights one by one. */
    function weight(): HTMLElement[] {
      if (data === null || fitView === undefined || selection === null || data.isScattered || fitView.fit.head?.rational === "fixed") return [];
      const value = data.weights?.[index] ?? 1;
      const text = el("output", {}, short(value));
      const slider = el("input", { type: "range", min: -1, max: 1, step: 0.01, value: Math.log(value) / Math.log(MOST), "aria-label": "Weight" });
      const now = () => Number((MOST ** slider.valueAsNumber).toPrecision(4));
      let preview: Preview | null = null;
      const place = selection;
      slider.addEventListener("input", () => {
        slider.style.setProperty("--done", `${(slider.valueAsNumber + 1) * 50}%`);
        text.textContent = short(now());
        preview ??= drag.preview(fitView);
        preview.move({ place, weight: now() });
      });
      slider.addEventListener("change", () => {
        preview?.end();
        preview = null;
        void drag.keep(fitView, { place, weight: now() });
      });
      slider.style.setProperty("--done", `${(slider.valueAsNumber + 1) * 50}%`);
      return [el("label", { class: "weight" }, el("span", {}, "weight"), slider, text)];
    }
  };
  box.addEventListener("submit", (event) => event.preventDefault());
  app.view.subscribe(update);
  app.fits.subscribe(update);
  addEventListener("keydown", ({ key }) => key === "Escape" && app.view.set({ selection: null }));
}
