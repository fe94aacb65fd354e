/** A field of the form: a label, one input or one for each direction, and what the server says about it. */

import { el } from "../html.js";
import { whenReleased } from "../ui/press.js";
import { isSame } from "./complaints.js";
import { type Description, type Kind, type Schema, sentence, spoken } from "./description.js";
import type { Json } from "./pointer.js";

/** One input, bound to a place in the request. */
export interface Slot {
  /** Its direction, where there are two. */
  readonly side: string | null;
  /** The pointers of which it is told what is wrong. */
  readonly claims: readonly string[];
  get(): Json | undefined;
  set(value: Json | undefined): void;
}

export interface FieldOptions {
  readonly label: string;
  readonly help: string;
  readonly kind: Kind;
  /** What it is when nothing is given. */
  readonly usual: string;
  readonly slots: readonly Slot[];
  /** How choices are called. */
  readonly names?: (choice: string) => string;
  /** Whether something has to be chosen. */
  readonly needed?: boolean;
}

type Control = HTMLInputElement | HTMLSelectElement;

interface Part {
  readonly slot: Slot;
  readonly control: Control;
  readonly said: HTMLElement;
  /** The value that is wrong; null if none is. */
  wrong: { readonly value: Json | undefined } | null;
}

let numbers = 0;

export class Field {
  readonly element: HTMLElement;
  readonly help: string;
  readonly label: string;
  /** The pointers of what it shows. */
  readonly claims: readonly string[];
  readonly #slots: Part[];
  readonly #options: FieldOptions;

  constructor(options: FieldOptions) {
    const { label, slots, help } = options;
    const id = `field-${++numbers}`;
    this.help = help;
    this.label = label;
    this.claims = slots.flatMap(({ claims }) => claims);
    this.#options = options;
    this.#slots = slots.map((slot, i) => {
      const said = el("p", { class: "said", id: `${id}-said-${i}`, hidden: true });
      const control = controlOf(options, `${id}-${i}`, slot);
      control.setAttribute("aria-describedby", `${id}-help ${said.id}`);
      if (slots.length > 1) control.setAttribute("aria-label", `${label}, ${slot.side}`);
      const part: Part = { slot, control, said, wrong: null };
      control.addEventListener("change", () => {
        slot.set(this.#read(control));
        whenReleased(() => forgive(part));
      });
      return part;
    });
    const name = slots.length > 1 ? el("span", { class: "name" }, label) : el("label", { class: "name", for: `${id}-0` }, label);
    const inputs = this.#slots.map(({ control }, i) => el("span", { class: "slot" }, slots.length > 1 && el("span", { class: "side", "aria-hidden": "true" }, slots[i]!.side), control, ...listOf(options, control)));
    const more = el("span", { class: "aside", id: `${id}-help` }, help);
    this.element = el("div", { class: "field", "data-slots": slots.length, "data-field": slots[0]?.claims[0] }, name, el("div", { class: "inputs" }, ...inputs), ...this.#slots.map(({ said }) => said), more);
    this.refresh();
  }

  /** Whether the request says more of it than what is usual. */
  get isGiven(): boolean {
    return this.#slots.some(({ slot }) => ![undefined, null, false, this.#options.usual].includes(slot.get() as string | undefined));
  }

  /** Shows what the request says. */
  refresh(): void {
    for (const part of this.#slots) {
      const { slot, control } = part;
      const value = slot.get();
      forgive(part);
      if (control instanceof HTMLInputElement && control.type === "checkbox") control.checked = value === true;
      else if (control instanceof HTMLSelectElement) select(control, value, this.#options);
      else if (document.activeElement !== control) control.value = shown(value);
    }
  }

  /** Takes what is wrong at a pointer; false if that is not its place. */
  tell(pointer: string, words: string): boolean {
    const found = this.#slots.find(({ slot }) => slot.claims.some((claim) => pointer === claim || pointer.startsWith(`${claim}/`)));
    if (found === undefined) return false;
    found.said.textContent = sentence(words);
    found.said.hidden = false;
    found.wrong = { value: found.slot.get() };
    found.control.setAttribute("aria-invalid", "true");
    return true;
  }

  /** Forgets what was wrong. */
  clear(): void {
    for (const part of this.#slots) clear(part);
  }

  #read(control: Control): Json | undefined {
    if (control instanceof HTMLInputElement && control.type === "checkbox") return control.checked ? true : undefined;
    return valueOf(control.value, this.#options.kind);
  }
}

/** Forgets what was wrong with a value that is another now. */
function forgive(part: Part): void {
  if (part.wrong !== null && !isSame(part.wrong.value, part.slot.get())) clear(part);
}

function clear(part: Part): void {
  part.wrong = null;
  part.said.hidden = true;
  part.said.textContent = "";
  part.control.removeAttribute("aria-invalid");
}

function controlOf({ kind, usual, names, needed, label }: FieldOptions, id: string, slot: Slot): Control {
  if (kind.boolean && kind.choices.length === 0) return el("input", { type: "checkbox", id, "aria-label": label });
  if (kind.choices.length > 0 && !kind.number) {
    const options = kind.choices.map((choice) => el("option", { value: choice }, names?.(choice) ?? spoken(choice)));
    const none = needed === true ? [] : [el("option", { value: "" }, usual === "" ? "–" : `Default: ${names?.(usual) ?? spoken(usual)}`)];
    return el("select", { id }, ...none, ...options.filter(({ value }) => needed === true || value !== usual));
  }
  const placeholder = usual !== "" ? usual : kind.choices.length > 0 ? `number or ${kind.choices.join(", ")}` : kind.more && !kind.number ? "JSON" : "";
  return el("input", { type: "text", id, placeholder: slot.side === null ? placeholder : usual, autocomplete: "off", spellcheck: "false", inputmode: kind.number && kind.choices.length === 0 && !kind.more ? "decimal" : "text" });
}

/** The words that may be written instead of a number. */
function listOf({ kind }: FieldOptions, control: Control): HTMLElement[] {
  if (control instanceof HTMLSelectElement || kind.choices.length === 0) return [];
  control.setAttribute("list", `${control.id}-list`);
  return [el("datalist", { id: `${control.id}-list` }, ...kind.choices.map((choice) => el("option", { value: choice })))];
}

/** A value that is none of the choices is shown as one more. */
function select(control: HTMLSelectElement, value: Json | undefined, { usual, needed }: FieldOptions): void {
  control.querySelector("[data-given]")?.remove();
  const text = value === undefined ? (needed === true ? usual : "") : typeof value === "string" ? value : JSON.stringify(value);
  const wanted = text === usual && needed !== true ? "" : text;
  const known = [...control.options].some((option) => option.value === wanted);
  if (!known) {
    const label = typeof value === "string" ? spoken(value) : "As given in the request";
    control.append(el("option", { value: wanted, "data-given": true }, label));
  }
  control.value = wanted;
}

function shown(value: Json | undefined): string {
  if (value === undefined || value === null) return "";
  return typeof value === "string" ? value : JSON.stringify(value).replace(/,/g, ", ");
}

/** What somebody wrote. What cannot be understood goes to the server as it is, which says what it expects. */
export function valueOf(text: string, kind: Kind): Json | undefined {
  const trimmed = text.trim();
  if (trimmed === "") return undefined;
  const isText = !kind.number && !kind.boolean && !kind.more && kind.choices.length === 0;
  if (isText || kind.choices.includes(trimmed)) return trimmed;
  for (const attempt of kind.more ? [trimmed, `[${trimmed}]`] : [trimmed.replace(/^\+/, "").replace(/^(-?)\./, "$10.").replace(/^(-?\d+),(\d+)$/, "$1.$2")]) {
    try {
      return JSON.parse(attempt) as Json;
    } catch {
      continue;
    }
  }
  return trimmed;
}

/** A field of a schema of the server. */
export function fieldOf(description: Description, schema: Schema, label: string, slots: readonly Slot[], rest: Partial<FieldOptions> = {}): Field {
  const kind = description.kind(schema);
  return new Field({ label, kind, help: description.help(schema), usual: description.usual(schema), slots, ...rest });
}
