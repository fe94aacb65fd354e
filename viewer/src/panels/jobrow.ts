/** A job in the list. */

import { ApiError, type Job } from "piad";

import type { App } from "../app.js";
import { el } from "../html.js";
import { MOST_JOBS } from "../state.js";
import { STATES } from "../ui/labels.js";
import { fromOne } from "../text/errors.js";
import { ago, count, short } from "../text/numbers.js";
import { sentence, spoken } from "./description.js";

export class Row {
  readonly element: HTMLElement;
  readonly #app: App;
  readonly #changed: () => void;
  readonly #name = el("button", { type: "button", class: "name" });
  readonly #about = el("span", {});
  readonly #age = el("time", {});
  readonly #warnings = el("ul", { class: "warnings", hidden: true });
  readonly #state = el("span", { class: "state" });
  readonly #bar = el("progress", { max: 1 });
  readonly #beside = el("button", { type: "button", class: "quiet" }, "Compare");
  readonly #cancel = el("button", { type: "button", class: "quiet" }, "Cancel");
  readonly #delete = el("button", { type: "button", class: "quiet" }, "Delete");
  readonly #sure = el("span", { class: "sure", role: "group", hidden: true });
  #job: Job;

  /** `changed` is called when the job is no longer as the list says. */
  constructor(app: App, job: Job, changed: () => void) {
    this.#app = app;
    this.#job = job;
    this.#changed = changed;
    this.#name.addEventListener("click", () => app.open(job.id));
    this.#beside.addEventListener("click", () => (app.view.value.jobs.includes(job.id) ? app.close(job.id) : app.open(job.id, "compare")));
    this.#cancel.addEventListener("click", () => void this.#try(() => this.#job.cancel()));
    this.#delete.addEventListener("click", () => this.#ask(true));
    const yes = el("button", { type: "button", class: "quiet danger", onclick: () => void this.#gone() }, "Delete for good");
    const no = el("button", { type: "button", class: "quiet", onclick: () => this.#ask(false) }, "Keep");
    this.#sure.append(yes, no);
    this.#sure.addEventListener("keydown", ({ key }) => {
      if (key === "Escape") this.#ask(false);
    });
    this.element = el("li", {}, el("div", { class: "head" }, this.#name, this.#state), el("p", { class: "facts" }, this.#about, this.#age), this.#warnings, this.#bar, el("div", { class: "row" }, this.#beside, this.#cancel, this.#delete, this.#sure));
    this.update(job);
  }

  update(job: Job): void {
    this.#job = job;
    const { status } = job;
    const name = nameOf(job);
    set(this.#name, name);
    this.#name.title = status.id;
    set(this.#state, STATES[status.state]);
    set(this.#age, ago(status.created_at));
    this.#age.dateTime = status.created_at;
    this.#age.title = new Date(status.created_at).toLocaleString();
    this.#state.dataset["state"] = status.state;
    const error = status.error === null ? "" : ` · error\u00a0${short(status.error.max)}`;
    const iterations = status.iteration === null ? "" : ` · iteration\u00a0${count(status.iteration)}`;
    set(this.#about, `${spoken(status.kind)}, ${count(status.points)} points · ${spoken(status.method.kind).toLowerCase()}${iterations}${error}`);
    const title = status.problem?.detail ?? status.detail ?? "";
    if (this.#about.title !== title) this.#about.title = title;
    const warnings = status.warnings.map(({ detail }) => sentence(fromOne(detail)));
    if (warnings.join() !== [...this.#warnings.children].map((item) => item.textContent).join()) {
      this.#warnings.replaceChildren(...warnings.map((warning) => el("li", {}, warning)));
    }
    this.#warnings.hidden = warnings.length === 0;
    this.#bar.value = status.progress;
    this.#bar.setAttribute("aria-label", `Progress of ${name}`);
    this.#bar.hidden = job.ended;
    this.#cancel.hidden = job.ended;
    for (const [button, verb] of [[this.#cancel, "Cancel"], [this.#delete, "Delete"]] as const) button.setAttribute("aria-label", `${verb} ${name}`);
    this.#sure.setAttribute("aria-label", `Delete ${name}?`);
  }

  /** Whether it is on the screen: as which of how many, or -1. */
  mark(place: number, of: number): void {
    const shown = place >= 0;
    this.element.toggleAttribute("data-shown", shown);
    this.element.dataset["series"] = shown && of > 1 ? String(place + 1) : "";
    this.#name.setAttribute("aria-current", String(shown));
    set(this.#beside, shown ? "Take off" : "Compare");
    this.#beside.setAttribute("aria-label", `${shown ? "Take off the screen:" : "Compare:"} ${this.#name.textContent}`);
    this.#beside.hidden = shown ? of < 2 : of === 0;
    this.#beside.disabled = !shown && of >= MOST_JOBS;
  }

  #ask(sure: boolean): void {
    this.#sure.hidden = !sure;
    this.#delete.hidden = sure;
    if (sure) this.#sure.querySelector("button")?.focus();
    else this.#delete.focus();
  }

  async #gone(): Promise<void> {
    await this.#try(async () => {
      await this.#job.delete();
      if (this.#app.view.value.jobs.includes(this.#job.id)) this.#app.close(this.#job.id);
      this.#app.say(`${this.#name.textContent} is deleted.`);
      const next = this.element.nextElementSibling ?? this.element.previousElementSibling;
      next?.querySelector<HTMLElement>("button")?.focus();
    });
  }

  async #try(act: () => Promise<unknown>): Promise<void> {
    try {
      await act();
    } catch (error) {
      // A job may have ended meanwhile, which is no mistake of anybody.
      const late = error instanceof ApiError && (error.status === 409 || error.status === 404);
      this.#app.say(error instanceof ApiError ? error.detail : String(error), late ? "info" : "error");
    }
    this.#changed();
  }
}

/** What a job is called: what somebody called it, or what it is. */
export function nameOf({ status: { name, kind, points } }: Job): string {
  return name ?? `${spoken(kind)} of ${count(points)} points`;
}

/** Sets a text, unless it is that already. */
function set(element: HTMLElement, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}
