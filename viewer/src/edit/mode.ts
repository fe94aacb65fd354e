/** The Edit mode, in which drags move data points. Without it they turn the scene, and swipes scroll the page. */

import type { App } from "../app.js";
import { byId, el } from "../html.js";

export function mode(app: App): void {
  const { view } = app;
  const toggle = () => {
    const editing = !view.value.editing;
    // Points that are moved have to be seen.
    view.set({ editing, ...(editing && { layers: { ...view.value.layers, data: true } }) });
  };
  const title = "Move data points by dragging them (e); with Alt pressed, for one drag";
  const button = el("button", { type: "button", class: "chip", id: "edit", title, onclick: toggle }, "Edit");
  byId("tools").append(button);
  const hint = el("p", { class: "movable" }, "Edit (E) moves data points");
  byId("viewport").append(hint);
  const update = () => {
    const { editing } = view.value;
    // Who has used it once knows it.
    if (editing) hint.hidden = true;
    button.setAttribute("aria-pressed", String(editing));
    byId("viewport").classList.toggle("edits", editing);
  };
  view.subscribe(update);
  update();
  addEventListener("keydown", (event) => {
    const { target, key, altKey, ctrlKey, metaKey } = event;
    if (key !== "e" || altKey || ctrlKey || metaKey || event.defaultPrevented) return;
    if (target instanceof Element && target.closest("input:not([type=range]), textarea, select, [contenteditable]")) return;
    event.preventDefault();
    toggle();
  });
}
