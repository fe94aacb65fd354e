/** Data points, what was understood of them, and how they are fitted. */

import type { api } from "piad";

import type { App, How, Panel } from "../app.js";
import { byId, el } from "../html.js";
import { Store } from "../store.js";
import { sentence } from "../text/errors.js";
import { whenReleased } from "../ui/press.js";
import { Description } from "./description.js";
import { dataOf, editable, shapeOf, words } from "./draft.js";
import type { InputFile } from "./drop.js";
import { Editor } from "./editor.js";
import type { Draft } from "./form.js";
import { InputError, type ParsedInput, type Reading, parseInput } from "./parse-input.js";
import type { Fields } from "./pointer.js";
import { presetOf, suggested, suits, withPreset } from "./presets.js";
import { snippet } from "./snippet.js";
import { sources } from "./sources.js";
import { ALL, type Source, understood } from "./understood.js";

export const importPanel: Panel = (root, app) => void new Import(root, app);

class Import {
  readonly #app: App;
  readonly #draft = new Store<Draft>({ request: {}, touched: false });
  readonly #data = el("div", { class: "data", "aria-live": "polite" });
  readonly #wrong = el("div", {});
  readonly #settings = el("div", {}, el("p", { class: "hint" }, "Asking the server what it can do …"));
  #editor: Editor | null = null;
  #reading = new AbortController();
  #source: Source | null = null;
  /** The jobs that have been made of the source. */
  readonly #made = new Set<string>();
  /** The newest job whose request was asked for. */
  #followed = "";

  constructor(root: HTMLElement, app: App) {
    this.#app = app;
    const element = sources(app, (input) => void this.#read(input, {}), ({ request }) => {
      this.#forget();
      this.#draft.set({ request: editable(request()), touched: false });
      void this.#send("replace");
    });
    element.append(this.#wrong, this.#data);
    root.replaceChildren(element, this.#settings);
    app.view.subscribe((now, before) => now.jobs !== before.jobs && this.#wrong.replaceChildren());
    this.#draft.subscribe((now, before) => now.request !== before.request && whenReleased(() => this.#show()));
    app.fits.subscribe(() => this.#follow());
    this.#begin();
    this.#follow();
  }

  /** Makes the form when the server has said what it can do. */
  #begin(): void {
    Description.of(this.#app.client).then(
      (description) => {
        this.#editor = new Editor(this.#app, this.#draft, description, (how) => void this.#send(how));
        this.#settings.replaceWith(this.#editor.element);
      },
      (error: Error) => {
        const again = el("button", { type: "button", class: "plain", onclick: () => this.#begin() }, "Try again");
        this.#settings.replaceChildren(el("p", { class: "hint" }, `The server does not say what it can do. ${error.message}`), again);
      },
    );
  }

  /** While nothing has been changed, the request is that of the newest job on the screen. */
  #follow(): void {
    const fit = this.#app.fits.shown.at(-1);
    if (fit === undefined || fit.id === this.#followed || this.#draft.value.touched) return;
    this.#followed = fit.id;
    if (this.#made.has(fit.id)) return;
    fit.input().then(
      (request) => {
        if (this.#draft.value.touched || this.#followed !== fit.id) return;
        this.#forget();
        this.#draft.set({ request: editable(request) });
      },
      () => {},
    );
  }

  #forget(): void {
    this.#source = null;
    this.#made.clear();
    this.#wrong.replaceChildren();
  }

  #show(): void {
    const { request } = this.#draft.value;
    const again = (next: Fields) => this.#fit(next, presetOf(request));
    const focused = this.#data.querySelector(":focus")?.closest(".field")?.querySelector(".name")?.textContent;
    this.#data.replaceChildren(...understood(this.#app, request, this.#source, { request: again, reading: (reading) => void this.#read(this.#source!.input, reading) }));
    const fields = [...this.#data.querySelectorAll(".field")];
    fields.find((field) => field.querySelector(".name")?.textContent === focused)?.querySelector<HTMLElement>("input, select")?.focus();
  }

  /** Reads a file, draws its points, and fits them. */
  async #read(input: InputFile, reading: Reading): Promise<void> {
    if (reading.part === ALL) return this.#all(input, reading);
    byId("tab-import").click();
    this.#reading.abort();
    const { signal } = (this.#reading = new AbortController());
    this.#wrong.replaceChildren();
    const title = input.name ?? "The text";
    try {
      const result = await this.#parsed(input, reading, signal);
      const isSame = this.#source?.input === input;
      const preset = isSame ? presetOf(this.#draft.value.request) : null;
      this.#forget();
      this.#source = { input, reading, notices: result.notices, parts: result.parts };
      this.#fit(result.request, preset);
      this.#app.say(`${title} is read: ${words(this.#draft.value.request)}.`);
    } catch (error) {
      if (signal.aborted) return;
      const faults = error instanceof InputError ? error.faults : [{ detail: error instanceof Error ? error.message : String(error), line: null, column: null }];
      this.#wrong.replaceChildren(snippet(title, input.text, faults));
      this.#wrong.scrollIntoView({ block: "nearest" });
    }
  }

  async #parsed(input: InputFile, reading: Reading, signal: AbortSignal): Promise<ParsedInput> {
    const result = await parseInput(input, input.name?.replace(/\.[^.]*$/, "") ?? null, reading, signal);
    const parts = result.parts ?? (reading.part === undefined ? null : (this.#source?.parts ?? null));
    return { ...result, parts, request: editable(result.request as unknown as api.JobRequest) };
  }

  /** Shows points, and fits them with a preset: the one before if it suits them. A request with settings keeps these. */
  #fit(request: Fields, before: ReturnType<typeof presetOf>): void {
    const isSet = request["method"] !== undefined || request["stop"] !== undefined;
    // The preset of scans would make a curve a surface again.
    const isKept = before !== null && suits(request, before) && !(before === "scan" && shapeOf(request) === "curve");
    const next = isSet && before === null ? request : withPreset(request, isKept ? before : suggested(request));
    this.#draft.set({ request: next, touched: true });
    this.#show();
    if (dataOf(next) === null) return;
    try {
      this.#app.preview(typeof next["name"] === "string" ? next["name"] : "Points", next as unknown as api.JobRequest);
    } catch {
      // The server says what is wrong with points that cannot be drawn.
    }
    void this.#send("replace");
  }

  /** Fits all parts of a file, in one scene. */
  async #all(input: InputFile, reading: Reading): Promise<void> {
    const { parts } = this.#source ?? {};
    const preset = presetOf(this.#draft.value.request);
    const { signal } = this.#reading;
    try {
      const jobs = await Promise.all(
        Array.from({ length: parts?.count ?? 0 }, async (_, i) => {
          const { request } = await this.#parsed(input, { ...reading, part: String(i + 1) }, signal);
          return this.#app.client.create(withPreset(request, preset !== null && suits(request, preset) ? preset : suggested(request)) as unknown as api.JobRequest);
        }),
      );
      for (const { id } of jobs) this.#made.add(id);
      if (this.#source !== null) this.#source = { ...this.#source, reading };
      this.#show();
      this.#app.view.set({ jobs: jobs.map(({ id }) => id), overlaid: true, iteration: "latest", playing: false, selection: null });
    } catch (error) {
      this.#app.say(sentence(error), "error");
    }
  }

  async #send(how: How): Promise<void> {
    const { request } = this.#draft.value;
    this.#editor?.clear();
    this.#wrong.replaceChildren();
    this.#editor?.element.setAttribute("aria-busy", "true");
    try {
      const id = await this.#app.fit(request as unknown as api.JobRequest, how);
      this.#made.add(id);
      if (this.#draft.value.request === request) this.#draft.set({ touched: false });
    } catch (error) {
      const editor = this.#editor;
      if (editor === null) this.#app.say(sentence(error), "error");
      else whenReleased(() => editor.refused(error, request));
    } finally {
      this.#editor?.element.removeAttribute("aria-busy");
    }
  }
}
