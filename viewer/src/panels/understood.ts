/** What was understood of the data, to be changed: how the points belong together, columns, parts, the unit. */

import type { App } from "../app.js";
import { el } from "../html.js";
import { MOST_JOBS, UNITS } from "../state.js";
import { dataOf, words } from "./draft.js";
import type { InputFile } from "./drop.js";
import type { Parts, Reading } from "./parse-input.js";
import { type Fields, at, isPair, put } from "./pointer.js";
import { asCurve, asScan } from "./presets.js";

/** The file that the data of a request come from. */
export interface Source {
  readonly input: InputFile;
  readonly reading: Reading;
  readonly notices: readonly string[];
  readonly parts: Parts | null;
}

/** The choice of all parts. */
export const ALL = "*";

/** What is done when something is changed. */
export interface Changes {
  /** The same points otherwise. */
  request(request: Fields): void;
  /** The same file, read otherwise. */
  reading(reading: Reading): void;
}

const ARRANGEMENTS = {
  curve: "Curve, in given order",
  nearest: "Curve, to next neighbours",
  grid: "Surface, in rows",
  sections: "Surface, through sections",
  scattered: "Surface, scattered points",
} as const;

type Arrangement = keyof typeof ARRANGEMENTS;

/** Shows a request and its source. */
export function understood(app: App, request: Fields, source: Source | null, changes: Changes): Node[] {
  const data = dataOf(request);
  if (data === null) return [];
  const notices = (source?.notices ?? []).map((notice) => el("p", { class: "hint" }, notice));
  const fields = [arrangement(request, source, changes), closed(request, changes), ...(source === null ? [] : ofFile(source, changes)), unit(app)];
  return [el("p", {}, el("b", {}, words(request))), ...notices, ...fields.filter((field) => field !== null)];
}

function arrangement(request: Fields, source: Source | null, changes: Changes): HTMLElement | null {
  const now = arrangementOf(request);
  const isSpatial = dataOf(request)?.coordinates === 3;
  if (now === null) return null;
  const isTable = source !== null && isText(source.input);
  const able: Record<Arrangement, boolean> = {
    curve: true,
    nearest: true,
    grid: now === "grid" || isTable,
    sections: now === "sections" || (isTable && (source.parts !== null || /\n\s*\n/.test(source.input.text))),
    scattered: isSpatial,
  };
  const rest = (reading: Reading): Reading => ({ ...(source?.reading.columns !== undefined && { columns: source.reading.columns }), ...reading });
  const choose = (value: string) => {
    if (value === "scattered") changes.request(asScan(request));
    else if (value === "nearest") changes.request(asCurve(request, "nearest"));
    else if (source === null) changes.request(asCurve(request, "given"));
    else if (value === "sections") changes.reading(rest({ "surface.sections": "true" }));
    else if (value === "curve") changes.request(asCurve(request, "given"));
    else changes.reading(rest({}));
  };
  const kinds = (Object.keys(able) as Arrangement[]).filter((kind) => kind === now || able[kind]);
  return kinds.length < 2 ? null : choice("Fit as", kinds.map((kind) => [kind, ARRANGEMENTS[kind]]), now, choose);
}

function arrangementOf(request: Fields): Arrangement | null {
  const data = dataOf(request);
  if (data === null || at(request, "/surface/parameters/triangles") !== undefined) return null;
  if (data.pointer === "/curve/points") return at(request, "/curve/order") === "nearest" ? "nearest" : "curve";
  if (data.pointer === "/surface/points") return "grid";
  return data.pointer === "/surface/sections" || at(request, "/surface/parameters/sections") !== undefined ? "sections" : "scattered";
}

/** A curve that returns to its first point. */
function closed(request: Fields, changes: Changes): HTMLElement | null {
  const value = at(request, "/curve/closed");
  if (at(request, "/curve") === undefined || isPair(value)) return null;
  const box = el("input", { type: "checkbox", id: "understood-closed", checked: value === true });
  box.addEventListener("change", () => changes.request(put(request, "/curve/closed", box.checked ? true : undefined)));
  return line("Closed", "understood-closed", box);
}

function ofFile({ input, reading, parts }: Source, changes: Changes): HTMLElement[] {
  const fields: HTMLElement[] = [];
  if (parts !== null) {
    const all = parts.count <= MOST_JOBS ? [[ALL, `All ${parts.count}`] as const] : [];
    const each = Array.from({ length: parts.count }, (_, i) => [String(i + 1), parts.names[i] === undefined || parts.names.length < parts.count ? `${i + 1}` : `${i + 1}: ${parts.names[i]}`] as const);
    fields.push(choice("Part", [...each, ...all], reading.part ?? "1", (part) => changes.reading({ ...reading, part })));
  }
  if (isTable(input)) {
    const columns = el("input", { type: "text", id: "understood-columns", value: reading.columns ?? "", placeholder: "by name, or the first", autocomplete: "off", spellcheck: "false", title: "Numbers or names: x=2,y=3 or easting,northing" });
    columns.addEventListener("change", () => {
      const { columns: _, ...rest } = reading;
      changes.reading(columns.value.trim() === "" ? rest : { ...rest, columns: columns.value.trim() });
    });
    fields.push(line("Columns", "understood-columns", columns));
  }
  return fields;
}

/** The unit of the coordinates, which the scale bar and the files have. */
function unit({ view }: App): HTMLElement {
  return choice("Unit", [["", "not known"], ...UNITS.map((unit) => [unit, unit] as const)], view.value.unit, (unit) => view.set({ unit }));
}

function isText({ text }: InputFile): boolean {
  return !text.includes("\u0000");
}

/** True if a file may be a table, whose columns can be chosen. */
function isTable(input: InputFile): boolean {
  return isText(input) && !/^\s*[[{<]|^(ply|solid|OFF|# \.PCD)\b/i.test(input.text) && /\d[ \t]*[,;\t ][ \t]*[-+.\d]/.test(input.text);
}

let numbers = 0;

function choice(label: string, options: readonly (readonly [value: string, name: string])[], now: string, choose: (value: string) => void): HTMLElement {
  const id = `understood-${++numbers}`;
  const select = el("select", { id }, ...options.map(([value, name]) => el("option", { value }, name)));
  select.value = now;
  select.addEventListener("change", () => choose(select.value));
  return line(label, id, select);
}

function line(label: string, id: string, control: HTMLElement): HTMLElement {
  return el("div", { class: "field" }, el("label", { class: "name", for: id }, label), el("div", { class: "inputs" }, el("span", { class: "slot" }, control)));
}
