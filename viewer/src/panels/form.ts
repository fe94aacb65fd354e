/** How the points are fitted: the fields that this server has for the chosen shape, basis and method. */

import type { api } from "piad";

import { el } from "../html.js";
import type { Store } from "../store.js";
import { type Description, type Schema, spoken } from "./description.js";
import { type Shape, canBeTrimmed, shapeOf } from "./draft.js";
import { Field, type FieldOptions, type Slot, fieldOf } from "./field.js";
import { type Fields, type Json, type Side, at, isFields, ofSide, put, withSide } from "./pointer.js";
import { toleranceField } from "./tolerance.js";
import { isTrimmed, trimFields } from "./trim.js";

/** What is being written. */
export interface Draft {
  readonly request: Fields;
  /** True if it was changed since it was a job. */
  readonly touched: boolean;
}

// Fields of the API that are one field here.
const TOLERANCES: readonly string[] = ["tolerance", "relative_tolerance"];

export class Form {
  /** What most fits need: the name and the tolerance. */
  readonly head = el("div", { class: "form" });
  /** All else. */
  readonly element = el("div", { class: "form" });
  readonly #unit: () => string;
  readonly #description: Description;
  readonly #draft: Store<Draft>;
  #fields: Field[] = [];
  #made = "";

  /** `unit` is that of the data. */
  constructor(description: Description, draft: Store<Draft>, unit: () => string) {
    this.#unit = unit;
    this.#description = description;
    this.#draft = draft;
    this.refresh();
  }

  /** Shows what the request says. Other kinds have other fields. */
  refresh(): void {
    const { request } = this.#draft.value;
    const shape = shapeOf(request);
    const made = [shape, "scattered" in this.#geometry, ...this.#sides.map((side) => `${this.#basis(side)} ${this.#isClosed(side)}`), this.#method.kind, canBeTrimmed(request), isTrimmed(this.#geometry["trim"])].join();
    if (made === this.#made) {
      for (const field of this.#fields) field.refresh();
      return;
    }
    this.#made = made;
    const focused = document.activeElement?.closest("[data-field]")?.getAttribute("data-field");
    this.#fields = [];
    const [head = [], ...sections] = shape === null ? [] : this.#sections(shape);
    this.head.replaceChildren(...head);
    this.element.replaceChildren(...sections.flat());
    for (const part of [this.head, this.element]) if (focused != null) part.querySelector<HTMLElement>(`[data-field="${focused}"] :is(input, select)`)?.focus();
  }

  /**
   * Takes what is wrong at a pointer; false if there is no field for it. What is wrong with an object, because one of its
   * fields is missing, is at that field: `detail` names it as the API does.
   */
  tell(pointer: string, detail: string, sentence: string): boolean {
    const named = [...detail.matchAll(/\b[a-z]+(?:_[a-z]+)+\b/g)].map(([name]) => `${pointer}/${name}`);
    return [pointer, ...named].some((place) => this.#fields.some((field) => field.tell(place, sentence)));
  }

  /** The label of a field, or of a choice, by its name in the API; null if the form has none. */
  labelOf(name: string): string | null {
    const field = this.#fields.find(({ claims }) => claims.some((claim) => claim.endsWith(`/${name}`)));
    return field?.label ?? this.#description.titles("Method").get(name)?.title ?? null;
  }

  clear(): void {
    for (const field of this.#fields) field.clear();
  }

  get #geometry(): Fields {
    const { request } = this.#draft.value;
    const geometry = request[shapeOf(request) ?? ""];
    return isFields(geometry) ? geometry : {};
  }

  get #sides(): readonly (Side | null)[] {
    return shapeOf(this.#draft.value.request) === "surface" ? ["u", "v"] : [null];
  }

  get #method(): api.Capabilities["methods"][number] {
    const { methods } = this.#description.capabilities;
    const kind = at(this.#draft.value.request, "/method/kind");
    return methods.find((method) => method.kind === kind) ?? methods[0]!;
  }

  #sections(shape: Shape): HTMLElement[][] {
    const name = fieldOf(this.#description, this.#description.field("JobRequest", "name"), "Name", this.#slots("/name", "", [null]));
    const basis = this.#basisFields(shape);
    const method = this.#methodFields(shape);
    const rules = ["tolerance", "relative_tolerance"].map((field) => this.#description.field("StopRules", field)) as [Schema, Schema];
    const set = (request: Fields) => this.#draft.set({ request, touched: true });
    const tolerance = toleranceField(() => this.#draft.value.request, set, this.#description.help(rules[0]), this.#description.usual(rules[1]), this.#unit);
    const stop = this.#all("StopRules", "/stop", TOLERANCES);
    const trim = canBeTrimmed(this.#draft.value.request) ? trimFields(this.#description, this.#slots("/surface/trim", "", [null])[0]!) : [];
    const more = this.#moreFields(shape);
    // What is wrong with the distance is said at its own field, which comes after the switch.
    this.#fields = [name, tolerance, ...basis, ...method, ...stop, ...[...trim].reverse(), ...more];
    const outline = trim.length === 0 ? [] : [section("Outline", trim)];
    return [[name.element, tolerance.element], [section("Basis", basis), section("Method", method), section("Stop", stop), ...outline, section("Corners, ends, parameters, weights", more, !more.some(isGiven))]];
  }

  #basis(side: Side | null): string {
    const basis = this.#geometry["basis"];
    const one = side === null ? basis : ofSide(basis, side);
    const kind = typeof one === "string" ? one : at(one, "/kind");
    return typeof kind === "string" ? kind : this.#description.capabilities.bases[0]!.kind;
  }

  #isClosed(side: Side | null): boolean {
    const { closed } = this.#geometry;
    return (side === null ? closed : ofSide(closed, side)) === true;
  }

  #basisFields(shape: Shape): Field[] {
    const { capabilities } = this.#description;
    const pointer = `/${shape}/basis`;
    const kinds = this.#sides.map((side) => this.#basis(side));
    const able = kinds.map((kind) => capabilities.bases.find((basis) => basis.kind === kind));
    const titles = this.#description.titles("Basis");
    const names = (kind: string) => titles.get(kind)?.title ?? spoken(kind);
    const help = kinds.map((kind) => titles.get(kind)?.help ?? "").join(" ");
    const choices = capabilities.bases.map(({ kind }) => kind);
    const kind = new Field({ label: "Kind", help, kind: { choices, number: false, boolean: false, more: false, pair: false }, usual: choices[0]!, needed: true, names, slots: this.#slots(pointer, "kind") });
    const fields = [kind];
    for (const name of ["degree", "knots"]) {
      const schema = this.#description.field("Basis", name);
      const sides = this.#sides.filter((_, i) => isOf(schema, kinds[i]!));
      if (sides.length === 0) continue;
      const options: Partial<FieldOptions> = name === "knots" ? { kind: { ...this.#description.kind(schema), choices: this.#knots(kinds) } } : {};
      fields.push(fieldOf(this.#description, schema, spoken(name), this.#slots(pointer, name, sides), options));
    }
    const schema = this.#description.field(shape === "curve" ? "CurveInput" : "SurfaceInput", "closed");
    const sides = this.#sides.filter((_, i) => able[i]?.closed === true);
    if (sides.length > 0) fields.push(fieldOf(this.#description, schema, "Closed", this.#slots(`/${shape}/closed`, "", sides)));
    return fields;
  }

  /** The rules for knots that the bases and the method have. */
  #knots(kinds: readonly string[]): string[] {
    const ofBases = this.#description.capabilities.bases.filter(({ kind }) => kinds.includes(kind)).flatMap((basis) => basis.knots ?? []);
    const all: readonly string[] = this.#method.knots ?? ofBases;
    return [...new Set(all)].filter((rule) => rule !== "explicit");
  }

  #methodFields(shape: Shape): Field[] {
    const titles = this.#description.titles("Method");
    const method = this.#method;
    const choices = this.#description.capabilities.methods.filter(({ surface }) => surface || shape === "curve").map(({ kind }) => kind);
    const names = (kind: string) => titles.get(kind)?.title ?? spoken(kind);
    const slot: Slot = {
      side: null,
      claims: ["/method/kind"],
      get: () => method.kind,
      set: (kind) => this.#set("/method", this.#keeping(String(kind))),
    };
    const none = { choices, number: false, boolean: false, more: false, pair: false };
    const kind = new Field({ label: "Kind", help: titles.get(method.kind)?.help ?? "", kind: none, usual: choices[0]!, needed: true, names, slots: [slot] });
    const settings = method.settings.flatMap((name) => {
      const schema = this.#description.field("Method", name);
      if (shape === "curve" && schema.description?.startsWith("Surfaces:")) return [];
      return [fieldOf(this.#description, schema, spoken(name), this.#slotsOf(`/method/${name}`, schema))];
    });
    return [kind, ...settings];
  }

  /** The method with another kind, and the settings that this has, too. */
  #keeping(kind: string): Json {
    const settings: readonly string[] = this.#description.capabilities.methods.find((method) => method.kind === kind)?.settings ?? [];
    const old = this.#draft.value.request["method"];
    const kept = Object.entries(isFields(old) ? old : {}).filter(([name]) => settings.includes(name));
    return { kind, ...Object.fromEntries(kept) };
  }

  #moreFields(shape: Shape): Field[] {
    const name = shape === "curve" ? "CurveInput" : "SurfaceInput";
    const parameters = this.#description.field(name, "parameters");
    const rules = this.#description.kind(parameters).choices;
    const grid = !("scattered" in this.#geometry);
    const choices = this.#description.capabilities.parameters.filter((rule) => rule !== "explicit" && rules.includes(rule));
    const kind = { ...this.#description.kind(parameters), choices: grid ? choices : rules };
    const of = (field: string, rest: Partial<FieldOptions> = {}, slots?: readonly Slot[]) => {
      const schema = this.#description.field(name, field);
      return fieldOf(this.#description, schema, spoken(field), slots ?? this.#slotsOf(`/${shape}/${field}`, schema), rest);
    };
    // What is closed has no ends.
    const open = this.#sides.filter((side) => !this.#isClosed(side));
    const ends = open.length === 0 ? [] : [of("ends", {}, this.#slots(`/${shape}/ends`, "", open))];
    const rational = this.#description.field("JobRequest", "rational");
    const ways = { ...this.#description.kind(rational), choices: this.#description.capabilities.rational };
    const ofCurve = shape === "curve" && this.#basis(null) === "bspline" ? [of("corners"), of("polyline"), of("order")] : [];
    const ofGrid = shape === "surface" && "points" in this.#geometry && this.#sides.every((side) => this.#basis(side) === "bspline") ? [of("creases")] : [];
    return [...ofCurve, ...ofGrid, ...ends, of("parameters", { kind, usual: this.#description.usual(this.#description.schema("ParameterChoice")) }), of("weights"), fieldOf(this.#description, rational, "Rational", this.#slots("/rational", "", [null]), { kind: ways })];
  }

  /** All fields of a schema but some. */
  #all(name: string, pointer: string, but: readonly string[]): Field[] {
    const fields = Object.entries(this.#description.schema(name).properties ?? {}).filter(([field]) => !but.includes(field));
    return fields.map(([field, schema]) => fieldOf(this.#description, schema, spoken(field), this.#slots(`${pointer}/${field}`, "", [null])));
  }

  #slotsOf(pointer: string, schema: Schema): Slot[] {
    return this.#slots(pointer, "", this.#description.kind(schema).pair ? this.#sides : [null]);
  }

  /** Inputs for a place in the request, or for a field in each direction there. */
  #slots(pointer: string, field: string, sides: readonly (Side | null)[] = this.#sides): Slot[] {
    const inner = field === "" ? "" : `/${field}`;
    return sides.map((side) => ({
      side,
      claims: side === null ? [`${pointer}${inner}`, ...(field === "degree" ? [pointer.replace(/basis$/, "degree")] : [])] : [`${pointer}/${side}${inner}`, `${pointer}${inner}`],
      get: () => {
        const value = at(this.#draft.value.request, pointer);
        const one = side === null ? value : ofSide(value, side);
        return field === "" ? one : at(one, inner);
      },
      set: (part) => {
        const value = at(this.#draft.value.request, pointer);
        const one = side === null ? value : ofSide(value, side);
        const next = field === "" ? part : this.#basisWith(one, field, part);
        this.#set(pointer, side === null ? next : withSide(value, side, next));
      },
    }));
  }

  /** A basis with another field. One that is not a B-spline has no degree and knots of its own. */
  #basisWith(basis: Json | undefined, field: string, part: Json | undefined): Json {
    const old: Fields = isFields(basis) ? basis : { kind: this.#description.capabilities.bases[0]!.kind };
    const next = put(old, `/${field}`, part);
    if (field !== "kind") return next;
    const kept = Object.entries(next).filter(([name]) => isOf(this.#description.field("Basis", name), String(part)));
    return Object.fromEntries(kept);
  }

  #set(pointer: string, value: Json | undefined): void {
    this.#draft.set({ request: put(this.#draft.value.request, pointer, value), touched: true });
  }
}

/** Whether a field belongs to a kind: its description says "Only with" of those that have it. */
function isOf({ description = "" }: Schema, kind: string): boolean {
  const only = /Only with ((?:`\w+`(?:, )?)+)/.exec(description)?.[1];
  return only === undefined || only.includes(`\`${kind}\``);
}

function isGiven(field: Field): boolean {
  return field.isGiven;
}

function section(title: string, fields: readonly Field[], folded?: boolean): HTMLElement {
  const inner = fields.map(({ element }) => element);
  if (folded === undefined) return el("fieldset", {}, el("legend", {}, title), ...inner);
  return el("details", { open: !folded }, el("summary", {}, title), ...inner);
}
