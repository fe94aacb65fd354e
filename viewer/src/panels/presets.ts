/** Settings by what the data are. */

import { type Fields, type Json, at, isFields, put } from "./pointer.js";
import { dataOf, shapeOf, sizeOf } from "./draft.js";

export interface Preset {
  readonly kind: "through" | "within" | "smooth" | "scan";
  readonly title: string;
  readonly about: string;
}

export const PRESETS: readonly Preset[] = [
  { kind: "through", title: "Through the points", about: "Exact points: of a drawing, a known curve, or set by hand" },
  { kind: "within", title: "Within a tolerance", about: "As few control points as keep the fit near each point" },
  { kind: "smooth", title: "Smooth a noisy measurement", about: "Between the points, as smooth as their noise suggests" },
  { kind: "scan", title: "Surface from a scan", about: "Points without rows, trimmed to where they are" },
];

type PresetKind = Preset["kind"];

// What a fit may be away from its points by default, as a part of the size of the data.
const NEAR = 1e-3;
// Scans are noisier, and where they end or have gaps a little stiffness keeps the surface near.
const NEAR_SCAN = 4e-3;
const STIFF = 1e-9;
// Interpolation through more points than these is seldom what somebody wants.
const FEW = 400;
// The fields of curves and surfaces that the settings of a preset do not go with.
const LOST: Readonly<Record<PresetKind, readonly string[]>> = {
  through: ["trim", "polyline"],
  within: ["ends", "creases", "trim"],
  smooth: ["ends", "creases", "trim", "corners", "polyline"],
  scan: ["ends", "corners", "creases", "polyline"],
};
// What second differences of neighbours have in common: two thirds less of noise, and about as much of a smooth line.
const NOISY = -0.3;
// Second differences below this part of the size of the data are rounding, not noise.
const ROUNDING = 1e-6;

/** True if a preset can be used for the data of a request. */
export function suits(request: Fields, kind: PresetKind): boolean {
  const data = dataOf(request);
  if (data === null) return false;
  const isLoose = data.pointer !== "/curve/points" && data.pointer !== "/surface/points";
  if (kind === "through") return !isLoose && !hasGaps(request);
  return kind !== "scan" || data.coordinates === 3;
}

/** The preset for data: as they were understood, by their number and by how they tremble. */
export function suggested(request: Fields): PresetKind {
  const data = dataOf(request);
  if (!suits(request, "through")) return suits(request, "scan") && data?.pointer === "/surface/scattered" && !hasRows(request) ? "scan" : "within";
  if (isNoisy(request)) return "smooth";
  return (data?.count ?? 0) > FEW ? "within" : "through";
}

/** The preset that a request has; null if its settings are others. */
export function presetOf(request: Fields): PresetKind | null {
  const [kind, fairness, controls] = ["kind", "fairness", "control_points"].map((name) => at(request, `/method/${name}`));
  if (kind === undefined) return suits(request, "through") ? "through" : "within";
  if (kind !== "least_squares") return kind === "global" ? "through" : null;
  if (fairness === "auto") return "smooth";
  if (controls !== "auto") return null;
  if (at(request, "/surface/trim") !== undefined) return "scan";
  return fairness === undefined ? "within" : null;
}

/** A request with the settings of a preset instead of its own. */
export function withPreset(request: Fields, kind: PresetKind): Fields {
  const shape = shapeOf(request);
  if (shape === null) return request;
  const { method: _, stop, ...rest } = kind === "scan" ? asScan(request) : request;
  const limit = at(stop, "/max_iterations");
  const others: Fields = limit === undefined ? {} : { max_iterations: limit };
  const robust: Fields = at(request, "/method/robust") === true ? { robust: true } : {};
  const bare = without(rest, LOST[kind]);
  const end = (rules: Fields): Fields => (Object.keys(rules).length === 0 ? bare : { ...bare, stop: rules });
  switch (kind) {
    case "through":
      return end(others);
    case "within":
      return { ...end({ relative_tolerance: NEAR, ...others }), method: { kind: "least_squares", control_points: "auto", ...robust } };
    case "smooth":
      return { ...end(others), method: { kind: "least_squares", control_points: manyOf(request), fairness: "auto", ...robust } };
    case "scan":
      return put({ ...end({ relative_tolerance: NEAR_SCAN, ...others }), method: { kind: "least_squares", control_points: "auto", fairness: STIFF, ...robust } }, "/surface/trim", true);
  }
}

/** The same points as those of a surface near them, without an order. */
export function asScan(request: Fields): Fields {
  const data = dataOf(request);
  if (data === null || data.pointer === "/surface/scattered" || data.pointer === "/surface/sections") return request;
  const points = at(request, data.pointer) as readonly Json[];
  const { curve: _, surface: __, ...rest } = request;
  const flat = data.rows === null ? points : (points as readonly (readonly Json[])[]).flat();
  return { ...rest, surface: { scattered: flat.filter((point) => point !== null) } };
}

/** The same points as those of a curve along them; `order` is how they follow each other. */
export function asCurve(request: Fields, order: "given" | "nearest"): Fields {
  const data = dataOf(request);
  if (data === null || data.pointer === "/curve/points") return request;
  const points = at(request, data.pointer) as readonly Json[];
  const { curve: _, surface: __, method: ___, ...rest } = request;
  const flat = data.rows === null ? points : (points as readonly (readonly Json[])[]).flat();
  return { ...rest, curve: { points: flat.filter((point) => point !== null), ...(order === "nearest" && { order }) } };
}

/** As many control points as smoothing can have: there the number matters little. */
function manyOf(request: Fields): Json {
  const data = dataOf(request);
  const count = data?.count ?? 0;
  const few = (most: number, of: number) => Math.max(4, Math.min(most, Math.floor(of / 2)));
  if (shapeOf(request) === "curve") return few(60, count);
  const rows = data?.rows ?? Math.sqrt(count);
  return { u: few(24, rows), v: few(24, count / rows) };
}

/** A request whose curve or surface has none of these fields, and no knots that belong to an interpolation. */
function without(request: Fields, names: readonly string[]): Fields {
  const shape = shapeOf(request);
  const geometry = request[shape ?? ""];
  if (shape === null || !isFields(geometry)) return request;
  const left = Object.fromEntries(Object.entries(geometry).filter(([name]) => !names.includes(name)));
  return { ...request, [shape]: names.includes("ends") && at(left, "/basis/knots") !== undefined ? { ...left, basis: put(left["basis"] as Fields, "/knots", undefined) } : left };
}

function hasGaps(request: Fields): boolean {
  const rows = at(request, "/surface/points");
  return Array.isArray(rows) && (rows as readonly Json[]).some((row) => Array.isArray(row) && row.includes(null));
}

/** True if scattered points are sections: their surface is not that of a scan. */
function hasRows(request: Fields): boolean {
  return at(request, "/surface/parameters/sections") !== undefined;
}

/** True if the points of a curve, or of the rows of a grid, tremble rather than bend. */
function isNoisy(request: Fields): boolean {
  const data = dataOf(request);
  if (data === null || data.count < 30) return false;
  const points = at(request, data.pointer) as unknown as readonly (readonly number[])[];
  const rows = data.rows === null ? [points] : (points as unknown as readonly (readonly (readonly number[])[])[]);
  let [together, alone] = [0, 0];
  for (const row of rows) {
    let before: readonly number[] | null = null;
    for (let i = 1; i + 1 < row.length; i++) {
      const [a, b, c] = [row[i - 1]!, row[i]!, row[i + 1]!].map((point) => [point].flat());
      const bend = b!.map((value, axis) => value - (a![axis]! + c![axis]!) / 2);
      alone += bend.reduce((sum, value) => sum + value * value, 0);
      if (before !== null) together += bend.reduce((sum, value, axis) => sum + value * before![axis]!, 0);
      before = bend;
    }
  }
  return Math.sqrt(alone / data.count) > ROUNDING * sizeOf(request) && together / alone < NOISY;
}
