/** The triangles of a grid that are inside an outline: those at its edge end there, whatever the grid. */

import type { Samples } from "../fit/geometry.js";
import type { Outline } from "../fit/outline.js";
import { every } from "./grid.js";
import { type Chain, GridLoops } from "./loops.js";
import { type PlaceOf, contains, trianglesOf } from "./triangulate.js";

/** What is left of a grid of samples. */
export interface Cut {
  /** Three vertices for each triangle: those of the grid by their numbers, then those of the outline. */
  readonly indices: Uint32Array;
  /** Where the vertices of the outline are: pairs of a row and a column, with fractions. */
  readonly places: Float64Array;
  /** Two vertices for each edge of the outline. */
  readonly boundary: Uint32Array;
  /** 1 for each vertex of the grid that is left, else 0. */
  readonly inside: Uint8Array;
}

/** That of all samples, and of some. */
export interface Cuts extends Cut {
  /** What is left of every `step` rows and columns, and the last ones; places are those among all. */
  at(step: number): Cut;
}

const made = new WeakMap<Outline, Map<string, Cuts>>();

/** What is inside an outline; null if nothing is cut off. */
export function cutAt(outline: Outline, { parameters: [us, vs], rows, columns }: Samples): Cuts | null {
  if (outline.loops.length === 0 || vs === undefined) return null;
  const known = made.get(outline) ?? new Map<string, Cuts>();
  made.set(outline, known);
  const key = `${rows} ${columns}`;
  const cuts = known.get(key) ?? cutsOf(outline, us, vs);
  known.set(key, cuts);
  return cuts;
}

function cutsOf({ loops }: Outline, us: Float64Array, vs: Float64Array): Cuts {
  const along = (list: Float64Array, value: number) => ((value - list[0]!) / (list.at(-1)! - list[0]!)) * (list.length - 1);
  const placed = loops.map((loop) => loop.map((value, k) => along(k % 2 === 0 ? us : vs, value)));
  const some = new Map<number, Cut>();
  const at = (step: number) => {
    const cut = some.get(step) ?? cutOf(placed, every(step, us.length), every(step, vs.length));
    some.set(step, cut);
    return cut;
  };
  return { ...at(1), at };
}

/** Cuts a grid with lines at these rows and columns along loops of places in it, of which it is on the left. */
export function cutOf(loops: readonly Float64Array[], rows: readonly number[], columns: readonly number[]): Cut {
  const parts = new GridLoops(rows, columns);
  for (const loop of loops) parts.follow(loop);
  const placeOf = (vertex: number) => parts.placeOf(vertex);
  const across = columns.length;
  const inside = parts.inside();
  const indices: number[] = [];
  for (let i = 0; i + 1 < rows.length; i++) {
    for (let j = 0; j + 1 < across; j++) {
      const a = i * across + j;
      const corners = [a, a + across, a + across + 1, a + 1] as const;
      const chains = parts.chains.get(a);
      if (chains !== undefined) for (const { around, holes } of polygonsOf(chains, corners, inside[a] === 1, placeOf)) indices.push(...trianglesOf(around, holes, placeOf));
      else if (inside[a] === 1) indices.push(a, a + across, a + 1, a + across, a + across + 1, a + 1);
    }
  }
  return { indices: Uint32Array.from(indices), places: parts.places(), boundary: Uint32Array.from(parts.boundary), inside };
}

/** Vertices around a part of a cell, and around its holes. */
interface Polygon {
  readonly around: readonly number[];
  readonly holes: readonly (readonly number[])[];
}

/** What is left of a cell: from the end of each chain along the sides of the cell to the next one. */
function polygonsOf(chains: readonly Chain[], corners: readonly number[], isInside: boolean, placeOf: PlaceOf): Polygon[] {
  const open = chains.filter(({ isClosed }) => !isClosed);
  const rest = new Set(open);
  const outer: number[][] = open.length === 0 && isInside ? [[...corners]] : [];
  for (const first of open) {
    if (!rest.has(first)) continue;
    const around: number[] = [];
    for (let chain = first; rest.delete(chain); ) {
      around.push(...chain.vertices);
      const way = ({ from }: Chain) => (((from - chain.to) % 4) + 4) % 4;
      const next = open.reduce((best, other) => (way(other) < way(best) ? other : best));
      for (let side = Math.ceil(chain.to); side <= chain.to + way(next); side++) around.push(corners[side % 4]!);
      chain = next;
    }
    outer.push(around);
  }
  const closed = chains.filter(({ isClosed }) => isClosed);
  const parts = [...outer, ...closed.filter(({ isHole }) => !isHole).map(({ vertices }) => vertices)].map((around) => ({ around, holes: [] as (readonly number[])[] }));
  for (const { vertices } of closed.filter(({ isHole }) => isHole)) parts.find(({ around }) => contains(around, vertices[0]!, placeOf))?.holes.push(vertices);
  return parts;
}

/** Two vertices for each edge of an outline at which a grid ends: along the seam of one that is closed it goes on. */
export function edgesOf({ places, boundary, inside }: Cut, closed: readonly [boolean, boolean], rows: number, columns: number): number[] {
  const last = [rows - 1, columns - 1] as const;
  const first = rows * columns;
  const edges: number[] = [];
  for (let k = 0; k < boundary.length; k += 2) {
    const [a, b] = [(boundary[k]! - first) * 2, (boundary[k + 1]! - first) * 2];
    const isSeam = [0, 1].some((axis) => {
      const side = places[a + axis]!;
      if (!closed[axis] || side !== places[b + axis] || (side !== 0 && side !== last[axis])) return false;
      const along = Math.round((places[a + 1 - axis]! + places[b + 1 - axis]!) / 2);
      const other = last[axis]! - side;
      return inside[axis === 0 ? other * columns + along : along * columns + other] === 1;
    });
    if (!isSeam) edges.push(boundary[k]!, boundary[k + 1]!);
  }
  return edges;
}

/** The values between those of the vertices of a grid, `size` for each, at places in it. */
export function valuesAt(places: Float64Array, values: Float32Array, size: number, rows: number, columns: number): Float32Array {
  const found = new Float32Array((places.length / 2) * size);
  for (let k = 0, to = 0; k < places.length; k += 2) {
    const i = Math.min(rows - 2, Math.floor(places[k]!));
    const j = Math.min(columns - 2, Math.floor(places[k + 1]!));
    const [s, t] = [places[k]! - i, places[k + 1]! - j];
    const a = (i * columns + j) * size;
    const b = a + columns * size;
    for (let part = 0; part < size; part++, to++) {
      found[to] = (1 - s) * ((1 - t) * values[a + part]! + t * values[a + size + part]!) + s * ((1 - t) * values[b + part]! + t * values[b + size + part]!);
    }
  }
  return found;
}
