/** The request as it is sent: as JSON, which can be written, and as a line of a shell. */

import type { App } from "../app.js";
import { el } from "../html.js";
import type { Store } from "../store.js";
import { copy, save } from "./copy.js";
import { curl } from "./curl.js";
import { requestOf, textOf } from "./draft.js";
import type { Draft } from "./form.js";

/** Shows the request in two ways. `onWritten` is called when somebody has written it. */
export class RequestText {
  readonly element: HTMLElement;
  readonly #draft: Store<Draft>;
  readonly #area = el("textarea", { id: "request-json", rows: 14, spellcheck: "false", autocomplete: "off", "aria-describedby": "request-json-said" });
  readonly #said = el("p", { class: "said", id: "request-json-said", hidden: true });
  readonly #line = el("pre", { tabindex: 0, "aria-label": "The request for curl" });
  readonly #file = el("button", { type: "button", class: "quiet" }, "Save job.json");

  constructor(app: App, draft: Store<Draft>) {
    this.#draft = draft;
    const copied = (what: string, text: () => string) => async () => {
      const done = await copy(text());
      app.say(done ? `${what} is on the clipboard.` : `${what} could not be copied.`, done ? "info" : "error");
    };
    const json = el("button", { type: "button", class: "quiet", onclick: copied("The request", () => this.#json()) }, "Copy JSON");
    const line = el("button", { type: "button", class: "quiet", onclick: copied("The command", () => this.#curl().command) }, "Copy curl");
    this.#file.addEventListener("click", () => save(new Blob([this.#json()], { type: "application/json" }), "job.json"));
    this.#area.addEventListener("input", () => this.#written());
    this.element = el(
      "details",
      { class: "request", ontoggle: () => this.refresh() },
      el("summary", {}, "The request, as JSON and for curl"),
      el("label", { for: "request-json", class: "aside" }, "The request as JSON"),
      this.#area,
      this.#said,
      this.#line,
      el("div", { class: "row" }, json, line, this.#file),
    );
  }

  /** Shows what the request says, unless somebody is writing it. */
  refresh(): void {
    if (!(this.element as HTMLDetailsElement).open) return;
    const { request } = this.#draft.value;
    if (document.activeElement !== this.#area) {
      this.#area.value = textOf(request);
      this.#tell("");
    }
    const { command, file } = this.#curl();
    this.#line.textContent = command.length > 4000 ? `${command.slice(0, 4000)} …` : command;
    this.#file.hidden = !file;
  }

  #json(): string {
    return JSON.stringify(this.#draft.value.request);
  }

  #curl(): { command: string; file: boolean } {
    return curl(new URL("v1/jobs", document.baseURI).href, this.#json());
  }

  #written(): void {
    try {
      const request = requestOf(this.#area.value, this.#draft.value.request);
      this.#tell("");
      this.#draft.set({ request, touched: true });
    } catch (error) {
      this.#tell(error instanceof Error ? `Not sent as it stands. ${error.message}` : String(error));
    }
  }

  #tell(sentence: string): void {
    this.#said.textContent = sentence;
    this.#said.hidden = sentence === "";
    if (sentence === "") this.#area.removeAttribute("aria-invalid");
    else this.#area.setAttribute("aria-invalid", "true");
  }
}
