/** What there is to choose beside the preset: outliers, corners, straight edges and creases. */

import { el } from "../html.js";
import { whenReleased } from "../ui/press.js";
import { dataOf } from "./draft.js";
import { type Fields, type Json, at, isPair, ofSide, put } from "./pointer.js";
import { presetOf } from "./presets.js";

/** A choice that is on or off. */
interface Choice {
  readonly title: string;
  readonly about: string;
  readonly pointer: string;
  /** What the request has where it is chosen. */
  readonly value: Json;
  /** True if a request can have it. */
  suits(request: Fields): boolean;
}

const CHOICES: readonly Choice[] = [
  { title: "Leave out outliers", about: "Points far from where their neighbours predict them", pointer: "/method/robust", value: true, suits: canLeaveOut },
  { title: "Turn at corners", about: "Where the points turn sharply, by more than 30°", pointer: "/curve/corners", value: "auto", suits: canTurn },
  { title: "Straight edges are data, too", about: "Of an outline whose corners alone are given", pointer: "/curve/polyline", value: true, suits: canHaveEdges },
];

export class Choices {
  readonly element = el("div", { class: "choices", role: "group", "aria-label": "More about the data" });
  readonly #boxes = CHOICES.map(() => el("input", { type: "checkbox" }));
  readonly #labels = CHOICES.map(({ title, about }, i) => el("label", {}, this.#boxes[i], el("span", {}, el("b", {}, title), el("span", {}, about))));
  readonly #creases = (["u", "v"] as const).map((side) => ({ side, input: el("input", { type: "text", inputmode: "numeric", autocomplete: "off", placeholder: "none", "aria-label": side === "u" ? "Creases along rows" : "Creases along columns" }) }));
  readonly #lines = el("div", { class: "field" }, el("span", { class: "name", title: "The lines of the grid across which the surface may turn, by their numbers: 13, 20" }, "Creases"), el("div", { class: "inputs" }, ...this.#creases.map(({ side, input }) => el("span", { class: "slot" }, el("span", { class: "side" }, side === "u" ? "rows" : "columns"), input))));

  /** `choose` fits the request with another choice. */
  constructor(get: () => Fields, choose: (request: Fields) => void) {
    this.element.append(...this.#labels, this.#lines);
    CHOICES.forEach(({ pointer, value }, i) => {
      const box = this.#boxes[i]!;
      box.addEventListener("change", () => whenReleased(() => choose(put(get(), pointer, box.checked ? value : undefined))));
    });
    for (const { side, input } of this.#creases) input.addEventListener("change", () => choose(put(get(), `/surface/creases/${side}`, linesOf(input.value))));
  }

  /** Shows what the request says. */
  refresh(request: Fields): void {
    CHOICES.forEach((choice, i) => {
      const value = at(request, choice.pointer);
      this.#boxes[i]!.checked = value !== undefined && value !== false;
      this.#labels[i]!.hidden = !choice.suits(request) && !this.#boxes[i]!.checked;
    });
    const able = this.#creases.map(({ side, input }) => {
      const value = at(request, `/surface/creases/${side}`);
      if (document.activeElement !== input) input.value = Array.isArray(value) ? value.map((line) => Number(line) + 1).join(", ") : "";
      input.parentElement!.hidden = !canCrease(request, side);
      return !input.parentElement!.hidden;
    });
    this.#lines.hidden = !able.includes(true);
    this.element.hidden = [...this.#labels, this.#lines].every(({ hidden }) => hidden);
  }
}

/** "13, 20" as numbers from 0; what is no number goes to the server, which says so. */
function linesOf(text: string): Json | undefined {
  const words = text.split(/[\s,;]+/).filter((word) => word !== "");
  return words.length === 0 ? undefined : words.map((word) => (/^\d+$/.test(word) ? Number(word) - 1 : word));
}

function isLeastSquares(request: Fields): boolean {
  return at(request, "/method/kind") === "least_squares";
}

function canLeaveOut(request: Fields): boolean {
  const pointer = dataOf(request)?.pointer;
  return isLeastSquares(request) && at(request, "/curve/polyline") !== true && (pointer === "/curve/points" || pointer === "/surface/scattered");
}

function isBspline(basis: Json | undefined): boolean {
  return basis === undefined || at(basis, "/kind") === "bspline";
}

/** With smoothness chosen by the data there are no corners, and along edges they are found without being asked for. */
function canTurn(request: Fields): boolean {
  const curve = at(request, "/curve");
  return curve !== undefined && isBspline(at(curve, "/basis")) && at(curve, "/basis/knots") === undefined && at(curve, "/polyline") !== true && at(request, "/method/fairness") !== "auto";
}

function canHaveEdges(request: Fields): boolean {
  return at(request, "/curve") !== undefined && presetOf(request) === "within" && at(request, "/method/robust") !== true;
}

function canCrease(request: Fields, side: "u" | "v"): boolean {
  const surface = at(request, "/surface");
  const { closed, basis } = { closed: at(surface, "/closed"), basis: at(surface, "/basis") };
  const isClosed = (isPair(closed) ? ofSide(closed, side) : closed) === true;
  return dataOf(request)?.pointer === "/surface/points" && presetOf(request) === "through" && !isClosed && isBspline(ofSide(basis, side));
}
