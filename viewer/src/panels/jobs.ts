/** The jobs of the server, live. */

import type { Job, api } from "piad";

import type { App, Panel } from "../app.js";
import { el } from "../html.js";
import { whenReleased } from "../ui/press.js";
import { sentence } from "../text/errors.js";
import { Description, spoken } from "./description.js";
import { Row, nameOf } from "./jobrow.js";

// How many jobs are shown at first, and how many more each time.
const PAGE = 25;

// The most jobs among which is searched.
const SEARCHED = 1000;

// How often the server is asked, in milliseconds: while jobs run, and else.
const BUSY = 1000;
const QUIET = 8000;

export const jobs: Panel = (root, app) => new List(root, app);

class List {
  readonly #app: App;
  readonly #rows = new Map<string, Row>();
  readonly #list = el("ul", { class: "joblist" });
  readonly #none = el("p", { class: "hint", hidden: true });
  readonly #more = el("button", { type: "button", class: "plain", hidden: true }, "Show more");
  readonly #state: HTMLSelectElement;
  readonly #words = el("input", { type: "search", id: "job-words", placeholder: "Name, method or kind", "aria-label": "Search the jobs", autocomplete: "off" });
  #most = PAGE;
  #timer = 0;
  #asking: AbortController | null = null;
  #seen = false;

  constructor(root: HTMLElement, app: App) {
    this.#app = app;
    this.#state = el("select", { id: "job-state" }, el("option", { value: "" }, "All"));
    this.#state.addEventListener("change", () => {
      this.#most = PAGE;
      void this.#ask();
    });
    this.#words.addEventListener("input", () => {
      this.#most = PAGE;
      void this.#ask();
    });
    this.#more.addEventListener("click", () => {
      this.#most += PAGE;
      void this.#ask();
    });
    root.replaceChildren(el("div", { class: "row" }, this.#words, el("label", { for: "job-state" }, "State"), this.#state), this.#list, this.#none, this.#more);
    // It asks while it is seen: not under another tab, below the screen, or in a window behind.
    new IntersectionObserver((entries) => {
      this.#seen = entries.at(-1)?.isIntersecting ?? false;
      void this.#ask();
      if (this.#seen) void this.#learn();
    }).observe(root);
    document.addEventListener("visibilitychange", () => void this.#ask());
    app.fits.subscribe(() => this.#mark());
    let shown = "";
    app.view.subscribe(({ jobs: ids }) => {
      if (ids.join() === shown) return;
      shown = ids.join();
      void this.#ask();
    });
  }

  /** Offers the states that the server knows. */
  async #learn(): Promise<void> {
    if (this.#state.options.length > 1) return;
    const description = await Description.of(this.#app.client).catch(() => null);
    if (description === null || this.#state.options.length > 1) return;
    const states = description.kind(description.schema("JobState")).choices;
    this.#state.append(...states.map((state) => el("option", { value: state }, spoken(state))));
  }

  /** Asks for the list, and again after a while. */
  async #ask(): Promise<void> {
    clearTimeout(this.#timer);
    this.#asking?.abort();
    if (!this.#seen || document.hidden) return;
    const asking = (this.#asking = new AbortController());
    try {
      const found: Job[] = [];
      const state = this.#state.value as api.JobState | "";
      // One more than is shown tells whether there are more.
      const words = this.#words.value.trim().toLowerCase();
      const options = { page: words === "" ? Math.min(this.#most + 1, 1000) : SEARCHED, signal: asking.signal, ...(state === "" ? {} : { state }) };
      let seen = 0;
      for await (const job of this.#app.client.jobs(options)) {
        if ((has(job, words) && found.push(job) > this.#most) || ++seen >= SEARCHED) break;
      }
      whenReleased(() => this.#show(found));
      this.#timer = window.setTimeout(() => void this.#ask(), found.some((job) => !job.ended) ? BUSY : QUIET);
    } catch (error) {
      if (asking.signal.aborted) return;
      this.#say(`The jobs could not be read. ${sentence(error)}`);
      this.#timer = window.setTimeout(() => void this.#ask(), QUIET);
    }
  }

  #show(found: readonly Job[]): void {
    const shown = found.slice(0, this.#most);
    const ids = new Set(shown.map(({ id }) => id));
    for (const [id, row] of this.#rows) {
      if (ids.has(id)) continue;
      row.element.remove();
      this.#rows.delete(id);
    }
    shown.forEach((job, i) => {
      const row = this.#rows.get(job.id) ?? new Row(this.#app, job, () => void this.#ask());
      this.#rows.set(job.id, row);
      row.update(job);
      // What is in its place stays there, with the focus that it may have.
      if (this.#list.children[i] !== row.element) this.#list.insertBefore(row.element, this.#list.children[i] ?? null);
    });
    this.#more.hidden = found.length <= this.#most;
    const [state, words] = [this.#state.value, this.#words.value.trim()];
    const none = words !== "" ? `No job has “${words}” in its name, method or kind.` : state !== "" ? `No job is ${state}.` : "There are no jobs. Drop a file of points, or open an example.";
    this.#say(shown.length > 0 ? "" : none);
    this.#mark();
  }

  /** Marks what is on the screen. */
  #mark(): void {
    const ids = this.#app.view.value.jobs;
    for (const [id, row] of this.#rows) row.mark(ids.indexOf(id), ids.length);
  }

  #say(sentence: string): void {
    this.#none.textContent = sentence;
    this.#none.hidden = sentence === "";
  }
}

/** True if a job has words in its name, its method or its kind. */
function has(job: Job, words: string): boolean {
  const { method, kind, id } = job.status;
  return words === "" || [nameOf(job), method.kind.replace(/_/g, " "), kind, id].some((text) => text.toLowerCase().includes(words));
}
