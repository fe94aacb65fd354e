/** The tolerance: one field, in the unit of the data or as a part of their size. */

import { el } from "../html.js";
import { sizeOf } from "./draft.js";
import { Field, type Slot } from "./field.js";
import { type Fields, type Json, at, put } from "./pointer.js";

const ABSOLUTE = "/stop/tolerance";
const RELATIVE = "/stop/relative_tolerance";

/** A field with a switch of its unit. `usual` is the part of the size without a tolerance. */
export function toleranceField(get: () => Fields, set: (request: Fields) => void, help: string, usual: string, unitOfData: () => string): Field {
  const absolute = el("option", { value: ABSOLUTE });
  const unit = el("select", { "aria-label": "Unit of the tolerance", class: "unit" }, el("option", { value: RELATIVE }, "× size"), absolute);
  const other = () => (unit.value === RELATIVE ? ABSOLUTE : RELATIVE);
  const slot: Slot = {
    side: null,
    claims: [ABSOLUTE, RELATIVE],
    get: () => at(get(), unit.value),
    set: (value) => set(put(put(get(), other(), undefined), unit.value, value)),
  };
  const number = { choices: [], number: true, boolean: false, more: false, pair: false };
  const field = new Field({ label: "Tolerance", help: `${help} In the unit of the data, or as a part of the diagonal of the box around them.`, kind: number, usual, slots: [slot] });
  field.element.querySelector(".slot")!.append(unit);
  // The same distance in the other unit.
  unit.addEventListener("change", () => {
    const value = at(get(), other());
    const size = sizeOf(get());
    slot.set(typeof value === "number" && size > 0 ? rounded(unit.value === RELATIVE ? value / size : value * size) : value);
  });
  const refresh = field.refresh.bind(field);
  field.refresh = () => {
    absolute.textContent = unitOfData() || "data units";
    for (const pointer of [ABSOLUTE, RELATIVE]) if (at(get(), pointer) !== undefined) unit.value = pointer;
    refresh();
  };
  field.refresh();
  return field;
}

function rounded(value: number): Json {
  return Number(value.toPrecision(4));
}
