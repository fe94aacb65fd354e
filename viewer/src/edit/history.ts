/** Edits that can be taken back: each is a job of its own. */

import type { App } from "../app.js";
import { byId, el } from "../html.js";
import { icon } from "../ui/icons.js";

export class History {
  readonly #app: App;
  readonly #undo = el("button", { type: "button", class: "icon", id: "undo", title: "Undo (Ctrl+Z)", "aria-label": "Undo", onclick: () => this.undo() }, icon("undo"));
  readonly #redo = el("button", { type: "button", class: "icon", id: "redo", title: "Redo (Ctrl+Shift+Z)", "aria-label": "Redo", onclick: () => this.redo() }, icon("redo"));
  #done: (readonly [before: string, after: string])[] = [];
  #undone: (readonly [before: string, after: string])[] = [];

  constructor(app: App) {
    this.#app = app;
    byId("tools").append(this.#undo, this.#redo);
    app.view.subscribe(() => this.#update());
    this.#update();
    addEventListener("keydown", (event) => {
      if (!(event.ctrlKey || event.metaKey) || event.altKey || event.key.toLowerCase() !== "z") return;
      if (event.target instanceof Element && event.target.closest("input:not([type=range]), textarea, [contenteditable]")) return;
      event.preventDefault();
      if (event.shiftKey) this.redo();
      else this.undo();
    });
  }

  /** An edit has been made, and is shown in the place of its parent. */
  made(before: string, after: string): void {
    this.#done.push([before, after]);
    this.#undone = [];
    this.#exchange(before, after);
  }

  undo(): void {
    const step = this.#done.at(-1);
    if (step === undefined || !this.#shows(step[1])) return;
    this.#undone.push(this.#done.pop()!);
    this.#exchange(step[1], step[0]);
    this.#app.say("Undone.");
  }

  redo(): void {
    const step = this.#undone.at(-1);
    if (step === undefined || !this.#shows(step[0])) return;
    this.#done.push(this.#undone.pop()!);
    this.#exchange(step[0], step[1]);
    this.#app.say("Done again.");
  }

  #shows(id: string): boolean {
    return this.#app.view.value.jobs.includes(id);
  }

  #exchange(old: string, now: string): void {
    const jobs = this.#app.view.value.jobs.map((id) => (id === old ? now : id));
    this.#app.view.set({ jobs, iteration: "latest", playing: false });
    this.#update();
  }

  #update(): void {
    const [done, undone] = [this.#done.at(-1), this.#undone.at(-1)];
    const [canUndo, canRedo] = [done !== undefined && this.#shows(done[1]), undone !== undefined && this.#shows(undone[0])];
    this.#undo.disabled = !canUndo;
    this.#redo.disabled = !canRedo;
  }
}
