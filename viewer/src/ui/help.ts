/** The list of keys. */

import { byId, el } from "../html.js";
import { TOOLS } from "./tools.js";

const KEYS: readonly (readonly [keys: string, what: string])[] = [
  ["Space", "play or pause"],
  ["← →", "one iteration back or forward"],
  ["Page up, Page down", "ten iterations"],
  ["Home, End", "the first or the last iteration"],
  ["< >", "play slower or faster"],
  ["l", "loop"],
  ["e", "edit: drag data points; Alt for one drag"],
  ["Ctrl+Z, Ctrl+Shift+Z", "undo, redo"],
  ["Escape", "give up a drag, close what is open"],
  ["m", "measure between two points"],
  ["o", "several fits in one scene, or side by side"],
  ...TOOLS.map(({ key, help }) => [key, help.charAt(0).toLowerCase() + help.slice(1)] as const),
  ["Shift+← → ↑ ↓", "turn, or shift what is flat"],
  ["+ −", "come nearer, go away"],
  ["0", "see all of it"],
  ["?", "this list"],
];

/** Opens the list by the button and by its key. */
export function help(): void {
  const rows = KEYS.map(([keys, what]) => el("div", {}, el("dt", {}, keys), el("dd", {}, what)));
  const close = el("button", { type: "button", class: "plain", onclick: () => dialog.close() }, "Close");
  const dialog = el("dialog", { class: "question keys", "aria-label": "Keys" }, el("h2", {}, "Keys"), el("dl", {}, ...rows), close);
  document.body.append(dialog);
  const open = () => {
    if (!dialog.open) dialog.showModal();
    // The focus is on the button at the end.
    dialog.scrollTop = 0;
  };
  byId("help").addEventListener("click", open);
  addEventListener("keydown", ({ key, target, ctrlKey, altKey, metaKey }) => {
    if (key !== "?" || ctrlKey || altKey || metaKey) return;
    if (target instanceof Element && target.closest("input:not([type=range]), textarea, select, [contenteditable]")) return;
    open();
  });
}
