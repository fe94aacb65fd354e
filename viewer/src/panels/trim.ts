/** The fields of the form that trim a surface to its data. */

import type { Description, Schema } from "./description.js";
import { Field, type Slot, fieldOf } from "./field.js";
import { type Json, at, isFields } from "./pointer.js";

/** A switch, and the distance if it is on; `slot` is the place of both in the request. */
export function trimFields(description: Description, slot: Slot): Field[] {
  const schema = description.schema("Trim");
  const yesOrNo = { choices: [], number: false, boolean: true, more: false, pair: false };
  const isOn = (): boolean => isTrimmed(slot.get());
  const trim: Slot = { ...slot, get: isOn };
  const fields = [new Field({ label: "Trim to the data", help: description.help(schema), kind: yesOrNo, usual: "", slots: [trim] })];
  if (!isOn()) return fields;
  const distance: Slot = {
    side: null,
    claims: slot.claims.map((claim) => `${claim}/distance`),
    get: () => at(slot.get(), "/distance"),
    set: (value) => slot.set(value === undefined ? true : { distance: value }),
  };
  return [...fields, fieldOf(description, distanceOf(schema), "Distance", [distance], { usual: "from the data" })];
}

/** True if a value of the field asks for an outline. */
export function isTrimmed(value: Json | undefined): boolean {
  return value === true || isFields(value);
}

function distanceOf({ oneOf = [] }: Schema): Schema {
  return oneOf.flatMap(({ properties }) => properties?.["distance"] ?? [])[0] ?? {};
}
