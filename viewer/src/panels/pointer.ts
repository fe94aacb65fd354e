/** Values in a request, by JSON pointers (RFC 6901), and those that are one for both directions or one for each. */

export type Json = null | boolean | number | string | readonly Json[] | { readonly [name: string]: Json };
export type Fields = { readonly [name: string]: Json };

export function isFields(value: unknown): value is Fields {
  return typeof value === "object" && value !== null && !Array.isArray(value);
}

/** The names that a pointer is made of. */
export function namesOf(pointer: string): string[] {
  return pointer.split("/").slice(1).map((name) => name.replace(/~1/g, "/").replace(/~0/g, "~"));
}

/** The value at a pointer; undefined where there is none. */
export function at(value: Json | undefined, pointer: string): Json | undefined {
  return namesOf(pointer).reduce<Json | undefined>((part, name) => {
    if (Array.isArray(part)) return part[Number(name)] as Json | undefined;
    return isFields(part) ? part[name] : undefined;
  }, value);
}

/** The same request with another value at a pointer; undefined takes it out, and objects that are left empty. */
export function put(value: Fields, pointer: string, part: Json | undefined): Fields {
  const [name = "", ...rest] = namesOf(pointer);
  const old = value[name];
  let next = part;
  if (rest.length > 0) {
    const inner = put(isFields(old) ? old : {}, `/${rest.join("/")}`, part);
    next = Object.keys(inner).length === 0 ? undefined : inner;
  }
  const { [name]: _, ...others } = value;
  if (next === undefined) return others;
  // What is changed stays where it was among the fields.
  return name in value ? { ...value, [name]: next } : { ...others, [name]: next };
}

/** A direction of a surface. */
export type Side = "u" | "v";

/** Whether a value is one for each direction. */
export function isPair(value: Json | undefined): value is { readonly u?: Json; readonly v?: Json } {
  return isFields(value) && Object.keys(value).length > 0 && Object.keys(value).every((name) => name === "u" || name === "v");
}

/** What a value is for one direction. */
export function ofSide(value: Json | undefined, side: Side): Json | undefined {
  return isPair(value) ? value[side] : value;
}

/** The value with another one for one direction; where both are the same it is one for both. */
export function withSide(value: Json | undefined, side: Side, part: Json | undefined): Json | undefined {
  const pair = { u: ofSide(value, "u"), v: ofSide(value, "v"), [side]: part };
  if (JSON.stringify(pair.u) === JSON.stringify(pair.v)) return pair.u;
  const given = Object.entries(pair).filter((entry): entry is [string, Json] => entry[1] !== undefined);
  return Object.fromEntries(given);
}
