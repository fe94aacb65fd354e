/** What is drawn: buttons that stay pressed. */

import type { App } from "../app.js";
import { byId, el } from "../html.js";
import type { SceneController } from "../scene/scene-controller.js";
import type { Layer } from "../state.js";
import { icon } from "./icons.js";

interface Tool {
  readonly layer: Layer;
  readonly name: string;
  readonly key: string;
  readonly help: string;
  /** Of curves only, or of surfaces. */
  readonly of?: "curve" | "surface";
}

const TOOLS: readonly Tool[] = [
  { layer: "data", name: "Data", key: "d", help: "The data points" },
  { layer: "polygon", name: "Control net", key: "n", help: "The control polygon, or the net of a surface" },
  { layer: "heat", name: "Error", key: "r", help: "The distance from the data as colours", of: "surface" },
  { layer: "spikes", name: "Spikes", key: "s", help: "From the fit to its data points, enlarged" },
  { layer: "comb", name: "Curvature", key: "c", help: "The curvature along the curve", of: "curve" },
  { layer: "zebra", name: "Zebra", key: "z", help: "Reflected stripes, which show how smooth a surface is", of: "surface" },
];

export function tools(app: App, scene: SceneController): void {
  const root = byId("tools");
  const { view, fits } = app;
  const toggle = (layer: Layer) => {
    const layers = { ...view.value.layers, [layer]: !view.value.layers[layer] };
    // Stripes and colours are both the whole surface.
    if (layer === "zebra" && layers.zebra) Object.assign(layers, { heat: false });
    if (layer === "heat" && layers.heat) Object.assign(layers, { zebra: false });
    view.set({ layers });
  };
  const buttons = TOOLS.map((tool) => {
    const title = `${tool.help} (${tool.key})`;
    return el("button", { type: "button", class: "chip", title, "data-layer": tool.layer, onclick: () => toggle(tool.layer) }, tool.name);
  });
  // There is no room for all of it on a phone.
  const what = el("span", {}, "net");
  buttons[1]!.replaceChildren(el("span", { class: "long" }, "Control "), what);
  const whole = el("button", { type: "button", class: "icon", id: "whole", title: "See all of it (0)", "aria-label": "See all of it", onclick: () => scene.viewport.camera.reset() }, icon("whole"));
  root.append(...buttons, whole);

  const update = () => {
    const kind = fits.shown[0]?.head?.kind ?? fits.shown[0]?.job?.status.kind;
    TOOLS.forEach(({ layer, of }, i) => {
      buttons[i]!.setAttribute("aria-pressed", String(view.value.layers[layer]));
      buttons[i]!.hidden = of !== undefined && kind !== undefined && of !== kind;
    });
    what.textContent = kind === "curve" ? "polygon" : "net";
  };
  view.subscribe(update);
  fits.subscribe(update);
  update();
  addEventListener("keydown", (event) => keys(event, scene, toggle, buttons));
}

/** A letter for each tool; the camera with shift and arrows, plus, minus and zero. */
function keys(event: KeyboardEvent, scene: SceneController, toggle: (layer: Layer) => void, buttons: readonly HTMLElement[]): void {
  const { target, key, altKey, ctrlKey, metaKey, shiftKey } = event;
  if (altKey || ctrlKey || metaKey || event.defaultPrevented) return;
  if (target instanceof Element && target.closest("input:not([type=range]), textarea, select, [contenteditable]")) return;
  const { camera } = scene.viewport;
  const at = TOOLS.findIndex((tool) => tool.key === key);
  const turn = { ArrowLeft: [-0.12, 0], ArrowRight: [0.12, 0], ArrowUp: [0, 0.12], ArrowDown: [0, -0.12] }[key];
  if (at >= 0 && !buttons[at]!.hidden) toggle(TOOLS[at]!.layer);
  else if (turn !== undefined && shiftKey) camera.move(turn[0]!, turn[1]!, 1);
  else if (key === "+" || key === "=") camera.move(0, 0, 1.25);
  else if (key === "-") camera.move(0, 0, 0.8);
  else if (key === "0") camera.reset();
  else return;
  event.preventDefault();
}
