/** The lines of a file around one that is wrong. */

import { el } from "../html.js";
import { sentence } from "./description.js";
import type { Fault } from "./parse-input.js";

// How many lines before and after the wrong one, and how much of each.
const AROUND = 2;
const WIDEST = 200;

/** What is wrong with a file, with the lines where it is. */
export function snippet(name: string, text: string, faults: readonly Fault[]): HTMLElement {
  const lines = text.split(/\r\n|\r|\n/);
  const parts = faults.slice(0, 3).map((fault) => part(name, lines, fault));
  const rest = faults.length - parts.length;
  return el("div", { class: "wrong", role: "alert" }, ...parts, rest > 0 && el("p", {}, `And ${rest} more.`));
}

function part(name: string, lines: readonly string[], { detail, line, column }: Fault): HTMLElement {
  const place = line === null ? name : `${name}, line ${line}`;
  const said = el("p", {}, el("b", {}, place), el("br"), sentence(detail));
  if (line === null || line < 1 || line > lines.length) return el("div", {}, said);
  const first = Math.max(1, line - AROUND);
  const shown = lines.slice(first - 1, line + AROUND);
  const rows = shown.map((content, i) => row(content, first + i, first + i === line, column));
  return el("div", {}, said, el("div", { class: "snippet", tabindex: 0, role: "group", "aria-label": `Lines around line ${line}` }, ...rows));
}

function row(content: string, number: number, wrong: boolean, column: number | null): HTMLElement {
  const marked = wrong && column !== null && column >= 1 && column <= content.length + 1;
  const from = marked ? column - 1 : content.length;
  const text = [content.slice(0, from), marked ? (content.charAt(from) || " ") : "", marked ? content.slice(from + 1) : ""].map((piece) => piece.slice(0, WIDEST));
  return el(
    "div",
    { class: wrong ? "line at" : "line" },
    el("span", { class: "number" }, number),
    el("code", {}, text[0], marked && el("mark", {}, text[1]), text[2] || (content === "" ? " " : "")),
    wrong && el("span", { class: "aside" }, " (the wrong line)"),
  );
}
