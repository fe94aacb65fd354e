/** From the coordinates of the data to those of the scene. */

import type { SampledIteration } from "piad";

type Numbers = Float64Array | Float32Array;

interface Grid {
  readonly rows: number;
  readonly columns: number;
  readonly dimension: number;
}

/** A box of data: its centre, half of its sides, and half of its diagonal. */
export interface Box {
  readonly centre: readonly [number, number, number];
  readonly half: readonly [number, number, number];
  readonly radius: number;
}

/** The box around others. */
export function around(boxes: readonly Box[]): Box {
  const sides = ([0, 1, 2] as const).map((axis) => {
    const low = Math.min(...boxes.map(({ centre, half }) => centre[axis] - half[axis]));
    const high = Math.max(...boxes.map(({ centre, half }) => centre[axis] + half[axis]));
    return [(low + high) / 2, (high - low) / 2] as const;
  });
  const [centre, half] = [0, 1].map((part) => sides.map((side) => side[part]!)) as unknown as [Box["centre"], Box["half"]];
  return { centre, half, radius: Math.hypot(...half) || 1 };
}

// Data further away from zero than so many of their extents lose too much in 32 bits.
const FAR = 64;

// What is further away than so many radii is drawn that far away: 32 bits would not hold what diverges.
const EDGE = 1e3;
// Further than this 32 bits do not reach, whatever the radius.
const REACH = 1e37;

// How many digits of the size of the data a hand can place a point to.
const HAND = 4;

/** Where data points are, and how they become three coordinates: of more than three the first ones. */
export class Axes implements Box {
  readonly centre: readonly [number, number, number];
  /** Half of the diagonal of the box around the data. */
  readonly radius: number;
  readonly half: readonly [number, number, number];
  readonly dimension: number;
  /** Whether `positions` are as seen from the centre. */
  readonly isMoved: boolean;
  // How much a whole range of parameters is on the screen, where values have no place of their own.
  readonly #stretch: number;

  constructor(data: Numbers, dimension: number, isSurface: boolean) {
    this.dimension = dimension;
    const [low, high] = box(data, dimension);
    const size = Math.max(high[0] - low[0], Number.MIN_VALUE);
    this.#stretch = dimension === 1 ? size * (isSurface ? 1.2 : 1.8) : 0;
    if (dimension === 1) {
      const last = isSurface ? 2 : 1;
      [low[last], high[last]] = [low[0], high[0]];
      for (let i = 0; i < last; i++) [low[i], high[i]] = [0, this.#stretch];
    }
    this.centre = [0, 1, 2].map((i) => ((low[i] ?? 0) + (high[i] ?? 0)) / 2) as unknown as Axes["centre"];
    this.half = [0, 1, 2].map((i) => ((high[i] ?? 0) - (low[i] ?? 0)) / 2) as unknown as Axes["half"];
    this.radius = Math.hypot(...this.half) || 1;
    this.isMoved = Math.hypot(...this.centre) > FAR * this.radius;
  }

  /** Whether other data are so much like these that they are seen best in the same place. */
  isLike(other: Axes): boolean {
    const apart = Math.hypot(...this.centre.map((c, i) => c - (other.centre[i] ?? 0)));
    const ratio = this.radius / other.radius;
    return this.dimension === other.dimension && this.isFlat === other.isFlat && apart < 0.3 * this.radius && ratio < 1.4 && ratio > 0.7;
  }

  /** Whether everything lies in a plane that is looked at from the front. */
  get isFlat(): boolean {
    return this.half[2] === 0;
  }

  /** What has to be taken off coordinates to get positions. */
  get origin(): readonly [number, number, number] {
    return this.isMoved ? this.centre : [0, 0, 0];
  }

  /** Three coordinates for each point; the same array where it has them already. */
  positions(data: Numbers, grid: Grid, parameters?: SampledIteration["parameters"]): Float32Array {
    const { dimension } = grid;
    if (dimension === 3 && !this.isMoved) {
      const near = this.#within(data);
      return near instanceof Float32Array ? near : Float32Array.from(near);
    }
    const count = grid.rows * grid.columns;
    const [x, y, z] = this.origin;
    const positions = new Float64Array(count * 3);
    for (let i = 0; i < count; i++) {
      const from = i * dimension;
      const to = i * 3;
      if (dimension === 1) {
        this.#value(positions, to, data[from] ?? NaN, i, grid, parameters);
        continue;
      }
      positions[to] = (data[from] ?? NaN) - x;
      positions[to + 1] = (data[from + 1] ?? NaN) - y;
      positions[to + 2] = dimension > 2 ? (data[from + 2] ?? NaN) - z : 0;
    }
    return Float32Array.from(this.#within(positions));
  }

  /** The same array, or a copy in which what is beyond the edge is on it, in the direction in which it was. */
  #within(all: Numbers): Numbers {
    const edge = Math.min(EDGE * this.radius, REACH);
    const [x, y, z] = this.centre.map((c, i) => c - (this.origin[i] ?? 0)) as [number, number, number];
    let positions = all;
    for (let i = 0; i < all.length; i += 3) {
      const [ax, ay, az] = [all[i]! - x, all[i + 1]! - y, all[i + 2]! - z];
      const size = Math.max(Math.abs(ax), Math.abs(ay), Math.abs(az));
      if (!(size > edge)) continue;
      if (positions === all) positions = all.slice();
      positions[i] = x + partOf(ax, size) * edge;
      positions[i + 1] = y + partOf(ay, size) * edge;
      positions[i + 2] = z + partOf(az, size) * edge;
    }
    return positions;
  }

  /** A number has its parameters as its place. */
  #value(positions: Numbers, to: number, value: number, i: number, grid: Grid, parameters?: SampledIteration["parameters"]): void {
    const [x, y, z] = this.origin;
    const column = i % grid.columns;
    const row = (i - column) / grid.columns;
    const [first, second] = parameters ?? [];
    if (grid.rows === 1 || second === undefined) {
      positions[to] = share(first, column, grid.columns) * this.#stretch - x;
      positions[to + 1] = value - y;
      return;
    }
    positions[to] = share(first, row, grid.rows) * this.#stretch - x;
    positions[to + 1] = share(second, column, grid.columns) * this.#stretch - y;
    positions[to + 2] = value - z;
  }

  /** The coordinates that are drawn from a place in the scene, as fine as a hand is. */
  coordinates(x: number, y: number, z: number): number[] {
    const place = [x + this.origin[0], y + this.origin[1], z + this.origin[2]];
    const used = this.dimension === 1 ? [this.half[2] > 0 ? (place[2] ?? 0) : (place[1] ?? 0)] : place.slice(0, this.dimension);
    const digits = Math.min(20, Math.max(0, HAND - Math.floor(Math.log10(this.radius))));
    return used.map((value) => Number(value.toFixed(digits)));
  }
}

/** A part of a size, from -1 to 1; of an infinite size only its infinite parts are left. */
function partOf(part: number, size: number): number {
  return Number.isFinite(size) ? part / size : Number.isFinite(part) ? 0 : Math.sign(part);
}

/** How far a parameter is in its range; without parameters how far an index is. */
function share(parameters: Float64Array | undefined, index: number, count: number): number {
  if (parameters === undefined || parameters.length < 2) return count > 1 ? index / (count - 1) : 0;
  const first = parameters[0] ?? 0;
  return ((parameters[index] ?? NaN) - first) / ((parameters.at(-1) ?? 1) - first);
}

function box(data: Numbers, dimension: number): [number[] & { 0: number }, number[] & { 0: number }] {
  const low = [Infinity, Infinity, Infinity].fill(0, dimension) as number[] & { 0: number };
  const high = [-Infinity, -Infinity, -Infinity].fill(0, dimension) as number[] & { 0: number };
  for (let i = 0; i < data.length; i++) {
    const value = data[i] ?? NaN;
    const axis = i % dimension;
    if (axis > 2) continue;
    if (value < (low[axis] ?? 0)) low[axis] = value;
    if (value > (high[axis] ?? 0)) high[axis] = value;
  }
  return [low, high];
}
