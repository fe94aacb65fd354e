/** How the points are fitted: the presets, the fields, the request, and the buttons that send it. */

import { ApiError } from "piad";

import type { App, How } from "../app.js";
import { el } from "../html.js";
import type { Store } from "../store.js";
import { fromOne, sentence } from "../text/errors.js";
import { whenReleased } from "../ui/press.js";
import { Choices } from "./choices.js";
import { Complaints } from "./complaints.js";
import { type Description, spoken } from "./description.js";
import { dataOf } from "./draft.js";
import { type Draft, Form } from "./form.js";
import { type Fields, at } from "./pointer.js";
import { PRESETS, presetOf, suits, withPreset } from "./presets.js";
import { RequestText } from "./request.js";

// Stands where the help of a field is shown.
const HINT = "Choose a field to read what it means.";

export class Editor {
  readonly element: HTMLElement;
  readonly #draft: Store<Draft>;
  readonly #send: (how: How) => void;
  readonly #form: Form;
  readonly #text: RequestText;
  readonly #complaints = new Complaints();
  readonly #presets = el("fieldset", { class: "presets" }, el("legend", {}, "How to fit the data"));
  readonly #choices: Choices;
  readonly #advanced: HTMLDetailsElement;
  readonly #buttons: readonly HTMLButtonElement[];
  #points: unknown;

  /** `send` fits the request of the draft. */
  constructor(app: App, draft: Store<Draft>, description: Description, send: (how: How) => void) {
    this.#draft = draft;
    this.#send = send;
    const form = (this.#form = new Form(description, draft, () => app.view.value.unit));
    const text = (this.#text = new RequestText(app, draft));
    const help = el("p", { class: "help", "aria-hidden": "true" }, HINT);
    const fit = el("button", { type: "submit", class: "primary" }, "Fit");
    const compare = el("button", { type: "button", class: "plain", title: "Fit, and compare with what is on the screen", onclick: () => send("compare") }, "Compare");
    this.#buttons = [fit, compare];
    for (const { kind, title, about } of PRESETS) {
      const radio = el("input", { type: "radio", name: "preset", value: kind });
      radio.addEventListener("change", () => this.#choose(kind));
      this.#presets.append(el("label", {}, radio, el("span", {}, el("b", {}, title), el("span", {}, about))));
    }
    this.#choices = new Choices(() => draft.value.request, (request) => this.#fit(request));
    this.#advanced = el("details", { class: "advanced" }, el("summary", {}, "Advanced"), form.element, text.element);
    this.element = el("form", { novalidate: true, autocomplete: "off" }, this.#presets, this.#choices.element, form.head, this.#advanced, el("div", { role: "alert" }, this.#complaints.element), el("footer", {}, help, el("div", { class: "row" }, fit, compare)));
    this.element.addEventListener("submit", (event) => {
      event.preventDefault();
      send("replace");
    });
    this.element.addEventListener("focusin", ({ target }) => {
      const field = target instanceof Element ? target.closest(".field") : null;
      help.textContent = field?.querySelector("[id$=-help]")?.textContent || HINT;
    });
    this.#points = pointsOf(draft.value.request);
    draft.subscribe(() => whenReleased(this.#update));
    app.view.subscribe((now, before) => now.unit !== before.unit && this.#form.refresh());
    this.#update();
  }

  /** Forgets what was wrong. */
  clear(): void {
    this.#form.clear();
    this.#complaints.clear();
  }

  /** Shows each thing that is wrong at its field; what has none above the buttons. */
  refused(error: unknown, request: Fields): void {
    const given = error instanceof ApiError && error.errors.length > 0 ? error.errors : [{ detail: sentence(error) }];
    const errors = given.map((one) => ({ ...one, detail: this.#inLabels(one.detail) }));
    const homeless = errors.filter(({ pointer }, i) => pointer === undefined || !this.#form.tell(pointer, given[i]!.detail, errors[i]!.detail));
    this.#complaints.tell(homeless, request);
    const first = this.element.querySelector<HTMLElement>("[aria-invalid=true]");
    for (let outer = first?.closest("details"); outer != null; outer = outer.parentElement?.closest("details")) outer.open = true;
    if (first !== null) first.focus();
    else this.#complaints.element.scrollIntoView({ block: "nearest" });
  }

  readonly #update = (): void => {
    const { request } = this.#draft.value;
    // Other data may mend anything.
    if (this.#points !== pointsOf(request)) this.clear();
    this.#points = pointsOf(request);
    this.#form.refresh();
    this.#text.refresh();
    this.#complaints.refresh(request);
    const none = dataOf(request) === null && Object.keys(request).length === 0;
    for (const button of this.#buttons) button.disabled = none;
    this.#choices.refresh(request);
    const preset = presetOf(request);
    for (const radio of this.#presets.querySelectorAll("input")) {
      radio.checked = radio.value === preset;
      radio.disabled = !suits(request, radio.value as (typeof PRESETS)[number]["kind"]);
    }
  };

  /** Another preset fits again. */
  #choose(kind: (typeof PRESETS)[number]["kind"]): void {
    this.#fit(withPreset(this.#draft.value.request, kind));
  }

  #fit(request: Fields): void {
    this.#draft.set({ request, touched: true });
    this.#send("replace");
  }

  /** An error with the labels of the form instead of the names of the API, and points counted from 1. */
  #inLabels(detail: string): string {
    return fromOne(detail.replace(/\b[a-z]+(?:_[a-z]+)+\b/g, (name) => this.#form.labelOf(name) ?? spoken(name)));
  }
}

/** The data points of a request. */
function pointsOf(request: Fields): unknown {
  return at(request, dataOf(request)?.pointer ?? "/-");
}
