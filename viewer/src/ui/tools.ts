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

/** What is colours on the whole surface: one of them at a time. */
const COLOURS: readonly Layer[] = ["heat", "between", "comb", "zebra"];

export const TOOLS: readonly Tool[] = [
  { layer: "data", name: "Data", key: "d", help: "The data points" },
  { layer: "polygon", name: "Control net", key: "n", help: "The control polygon, or the net of a surface" },
  { layer: "heat", name: "Error", key: "r", help: "The distance from the data as colours; of fits in one scene, that from the first" },
  { layer: "spikes", name: "Error vectors", key: "s", help: "From the fit to its data points, enlarged" },
  { layer: "between", name: "Between", key: "b", help: "Where the fit leaves its data between neighbours" },
  { layer: "comb", name: "Curvature", key: "c", help: "The curvature, along a curve as a comb, of a surface as colours" },
  { layer: "zebra", name: "Zebra", key: "z", help: "Reflected stripes, which show how smooth a surface is", of: "surface" },
];

export function tools(app: App, scene: SceneController): void {
  const root = byId("tools");
  const { view, fits } = app;
  const kindOf = () => fits.shown[0]?.head?.kind ?? fits.shown[0]?.job?.status.kind;
  const isSurface = () => kindOf() === "surface";
  const toggle = (layer: Layer) => {
    const layers: Record<Layer, boolean> = { ...view.value.layers, [layer]: !view.value.layers[layer] };
    if (isSurface() && layers[layer] && COLOURS.includes(layer)) for (const other of COLOURS) if (other !== layer) layers[other] = false;
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
  const measure = chip("Measure", "The distance between two points that are clicked (m)", () => view.set({ measuring: !view.value.measuring }));
  const overlay = chip("Overlay", "All fits in one scene, not side by side (o)", () => view.set({ overlaid: !view.value.overlaid }));
  root.append(...buttons, measure, overlay, whole);

  const update = () => {
    const kind = kindOf();
    TOOLS.forEach(({ layer, of }, i) => {
      buttons[i]!.setAttribute("aria-pressed", String(view.value.layers[layer]));
      buttons[i]!.hidden = of !== undefined && kind !== undefined && of !== kind;
    });
    what.textContent = kind === "curve" ? "polygon" : "net";
    measure.setAttribute("aria-pressed", String(view.value.measuring));
    overlay.setAttribute("aria-pressed", String(view.value.overlaid));
    overlay.hidden = fits.shown.length < 2;
  };
  view.subscribe(update);
  fits.subscribe(update);
  update();
  addEventListener("keydown", (event) => keys(event, scene, toggle, buttons, { m: measure, o: overlay }));
}

function chip(name: string, title: string, onclick: () => void): HTMLButtonElement {
  return el("button", { type: "button", class: "chip", title, onclick }, name);
}

/** A letter for each tool; the camera with shift and arrows, plus, minus and zero. */
function keys(event: KeyboardEvent, scene: SceneController, toggle: (layer: Layer) => void, buttons: readonly HTMLElement[], others: Readonly<Record<string, HTMLElement>>): void {
  const { target, key, altKey, ctrlKey, metaKey, shiftKey } = event;
  if (altKey || ctrlKey || metaKey || event.defaultPrevented) return;
  if (target instanceof Element && target.closest("input:not([type=range]), textarea, select, [contenteditable]")) return;
  const { camera } = scene.viewport;
  const at = TOOLS.findIndex((tool) => tool.key === key);
  const turn = { ArrowLeft: [-0.12, 0], ArrowRight: [0.12, 0], ArrowUp: [0, 0.12], ArrowDown: [0, -0.12] }[key];
  if (at >= 0 && !buttons[at]!.hidden) toggle(TOOLS[at]!.layer);
  else if (others[key]?.hidden === false) others[key].click();
  else if (turn !== undefined && shiftKey) camera.move(turn[0]!, turn[1]!, 1);
  else if (key === "+" || key === "=") camera.move(0, 0, 1.25);
  else if (key === "-") camera.move(0, 0, 0.8);
  else if (key === "0") camera.reset();
  else return;
  event.preventDefault();
}
