/** The request that is being written: data points, and how they are to be fitted. */

import type { api } from "piad";

import { type Fields, type Json, at, isFields, isPair } from "./pointer.js";

/** Requests with more points than this are shown without them. */
export const MOST_SHOWN = 600;

export type Shape = "curve" | "surface";

export function shapeOf(request: Fields): Shape | null {
  return isFields(request["curve"]) ? "curve" : isFields(request["surface"]) ? "surface" : null;
}

/** A request in the form in which its fields are edited: short forms written out, nothing that is null. */
export function editable(request: api.JobRequest): Fields {
  const fields = without(request as unknown as Json, 2) as Fields;
  const shape = shapeOf(fields);
  const method = fields["method"];
  const whole: Fields = typeof method === "string" ? { ...fields, method: { kind: method } } : fields;
  if (shape === null) return whole;
  const { degree, ...geometry } = whole[shape] as Fields;
  const basis = geometry["basis"] ?? degreeAsBasis(degree);
  return { ...whole, [shape]: basis === undefined ? geometry : { ...geometry, basis: written(basis) } };
}

function degreeAsBasis(degree: Json | undefined): Json | undefined {
  if (degree === undefined) return undefined;
  const basis = (value: Json | undefined): Json => ({ kind: "bspline", degree: value ?? null });
  return isPair(degree) ? { u: basis(degree.u), v: basis(degree.v) } : basis(degree);
}

function written(basis: Json): Json {
  if (typeof basis === "string") return { kind: basis };
  if (isPair(basis)) return Object.fromEntries(Object.entries(basis).map(([side, one]) => [side, written(one)]));
  return basis;
}

/** Without fields that are null, which is the same as not given; `depth` objects deep. */
function without(value: Json, depth: number): Json {
  if (!isFields(value) || depth < 0) return value;
  const given = Object.entries(value).filter(([, part]) => part !== null);
  return Object.fromEntries(given.map(([name, part]) => [name, without(part, depth - 1)]));
}

/** Where the data points of a request are, and how many. */
export function dataOf(request: Fields): { pointer: string; count: number; rows: number | null; coordinates: number } | null {
  const shape = shapeOf(request);
  if (shape === null) return null;
  for (const pointer of [`/${shape}/points`, `/${shape}/scattered`, `/${shape}/sections`]) {
    const points = at(request, pointer);
    if (!Array.isArray(points)) continue;
    const grid = pointer === "/surface/points" || pointer === "/surface/sections";
    const first: unknown = grid ? (points as Json[][]).flat().find((point) => point !== null) : points[0];
    const count = grid ? (points as Json[][]).reduce((sum, row) => sum + (Array.isArray(row) ? row.length : 0), 0) : points.length;
    return { pointer, count, rows: grid ? points.length : null, coordinates: Array.isArray(first) ? first.length : 0 };
  }
  return null;
}

/** The diagonal of the box around the data points of a request. */
export function sizeOf(request: Fields): number {
  const data = dataOf(request);
  const points = data === null ? [] : (at(request, data.pointer) as readonly Json[]);
  const low: number[] = [];
  const high: number[] = [];
  for (const point of data?.rows == null ? points : (points as readonly (readonly Json[])[]).flat()) {
    (Array.isArray(point) ? (point as number[]) : [point]).forEach((value, axis) => {
      if (typeof value !== "number") return;
      low[axis] = Math.min(low[axis] ?? value, value);
      high[axis] = Math.max(high[axis] ?? value, value);
    });
  }
  return Math.hypot(...high.map((value, axis) => value - low[axis]!));
}

/** What stands for points that are too many to be shown. */
export function standIn(request: Fields): string | null {
  const data = dataOf(request);
  return data === null || data.count <= MOST_SHOWN ? null : `… ${data.count} points …`;
}

/** The request as text that people read: an object a line, points side by side. */
export function textOf(request: Fields): string {
  const stand = standIn(request);
  const pointer = dataOf(request)?.pointer;
  const lines = (value: Json, indent: string, path: string): string => {
    if (stand !== null && path === pointer) return JSON.stringify(stand);
    const inner = `${indent}  `;
    if (isFields(value)) {
      const parts = Object.entries(value).map(([name, part]) => `${inner}${JSON.stringify(name)}: ${lines(part, inner, `${path}/${name}`)}`);
      return parts.length === 0 ? "{}" : `{\n${parts.join(",\n")}\n${indent}}`;
    }
    const compact = JSON.stringify(value);
    if (!Array.isArray(value) || compact.length < 60) return Array.isArray(value) ? compact.replace(/,/g, ", ") : compact;
    if (value.every((part) => typeof part === "number")) return compact.replace(/,/g, ", ");
    return `[\n${value.map((part) => `${inner}${lines(part, inner, "-")}`).join(",\n")}\n${indent}]`;
  };
  return lines(request, "", "");
}

/** The request that a text says; what stands for points becomes those of `before` again. */
export function requestOf(text: string, before: Fields): Fields {
  const value = JSON.parse(text) as Json;
  if (!isFields(value)) throw new SyntaxError("A job is an object with a curve or a surface.");
  const stand = standIn(before);
  const data = dataOf(before);
  if (stand === null || data === null || at(value, data.pointer) !== stand) return value;
  const [, shape = "", name = ""] = data.pointer.split("/");
  return { ...value, [shape]: { ...(value[shape] as Fields), [name]: at(before, data.pointer) ?? null } };
}

/** What data points are, in words: "12 × 10 points in space". */
export function words(request: Fields): string {
  const data = dataOf(request);
  if (data === null) return "No points";
  const { count, rows, coordinates } = data;
  const sections = data.pointer === "/surface/sections" ? rows : lengthOf(at(request, "/surface/parameters/sections"));
  const many = rows === null || sections !== null ? `${count}` : `${rows} × ${Math.round(count / Math.max(rows, 1))}`;
  const place = ["", "on a line", "in the plane", "in space"][coordinates] ?? "";
  if (sections !== null) return `Surface through ${sections} sections, ${count} points ${place}`;
  const mesh = lengthOf(at(request, "/surface/parameters/triangles"));
  if (mesh !== null) return `Surface to a mesh of ${count} points and ${mesh} triangles`;
  const scattered = data.pointer === "/surface/scattered" ? "scattered " : "";
  return `${shapeOf(request) === "surface" ? "Surface" : "Curve"}, ${many} ${scattered}points ${place}`.trim();
}

function lengthOf(value: Json | undefined): number | null {
  return Array.isArray(value) ? value.length : null;
}

/** True if a surface may have an outline of its own: near scattered points, or through a grid with gaps; or if it is to have one. */
export function canBeTrimmed(request: Fields): boolean {
  const surface = request["surface"];
  if (!isFields(surface)) return false;
  const isSpatial = (dataOf(request)?.coordinates ?? 0) > 1;
  return "trim" in surface || (isSpatial && ("scattered" in surface || hasGaps(surface["points"])));
}

function hasGaps(rows: Json | undefined): boolean {
  return Array.isArray(rows) && (rows as readonly Json[]).some((row) => Array.isArray(row) && row.includes(null));
}
