/** What the server refuses in a request and no field of the form shows, as long as the request has it. */

import { el } from "../html.js";
import { sentence, spoken } from "./description.js";
import { dataOf } from "./draft.js";
import { type Fields, type Json, at, namesOf } from "./pointer.js";

export interface Complaint {
  readonly pointer?: string;
  readonly detail: string;
}

export class Complaints {
  readonly element = el("ul", { class: "wrong", hidden: true });
  #told: { readonly complaint: Complaint; readonly value: Json | undefined }[] = [];

  tell(complaints: readonly Complaint[], request: Fields): void {
    this.#told = complaints.map((complaint) => ({ complaint, value: valueOf(complaint, request) }));
    this.#show(request);
  }

  /** Leaves out what is about values that are others now. */
  refresh(request: Fields): void {
    const left = this.#told.filter(({ complaint, value }) => isSame(value, valueOf(complaint, request)));
    if (left.length === this.#told.length) return;
    this.#told = left;
    this.#show(request);
  }

  clear(): void {
    this.tell([], {});
  }

  #show(request: Fields): void {
    this.element.replaceChildren(...this.#told.map(({ complaint: { pointer, detail } }) => el("li", {}, placed(pointer, detail, request), sentence(detail))));
    this.element.hidden = this.#told.length === 0;
  }
}

/** True if two values of a request are equal. */
export function isSame(a: Json | undefined, b: Json | undefined): boolean {
  return a === b || JSON.stringify(a) === JSON.stringify(b);
}

/** What a complaint is about: a value, or the request as a whole. */
function valueOf({ pointer = "" }: Complaint, request: Fields): Json | undefined {
  return pointer === "" ? request : at(request, pointer);
}

/** The location of an error in words, unless it says it itself: data points by their numbers, all else by the names of fields. */
function placed(pointer: string | undefined, detail: string, request: Fields): Node | null {
  if (pointer === undefined || pointer === "" || /^(point|row) \d/.test(detail)) return null;
  const points = dataOf(request)?.pointer;
  const rest = points !== undefined && pointer.startsWith(`${points}/`) ? pointer.slice(points.length + 1).split("/") : null;
  const names = namesOf(pointer).slice(1).map((name) => spoken(name));
  const place = rest === null ? (names.length > 0 ? names.join(", ") : spoken(pointer.slice(1))) : points === "/surface/points" ? `Row ${Number(rest[0]) + 1}${rest[1] === undefined ? "" : `, column ${Number(rest[1]) + 1}`}` : `Point ${Number(rest[0]) + 1}`;
  return el("b", {}, `${place}: `);
}
