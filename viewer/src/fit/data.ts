/** The data points of a job. */

import type { api } from "piad";

import { Axes } from "./axes.js";
import type { Place } from "../state.js";

/** More points than these are not asked for: browsers would not hold them as text. */
export const MOST_POINTS = 1_500_000;
/** More points than these are not drawn: they are nearer to each other than dots are wide, and processors draw too. */
const MOST_DRAWN = 30_000;

/** Data points in rows; of curves and of scattered points one row. */
export interface Data {
  /** NaN where a grid has no point. */
  readonly exact: Float64Array;
  readonly positions: Float32Array;
  readonly dimension: number;
  readonly rows: number;
  readonly columns: number;
  readonly isSurface: boolean;
  readonly isScattered: boolean;
  /** Whether the rows, and the columns, go around. */
  readonly closed: readonly [boolean, boolean];
  readonly weights: readonly number[] | null;
  /** Of the points, or of the rows and columns of a grid. */
  readonly parameters: readonly Float64Array[];
  readonly axes: Axes;
  /** How many control points there are in each direction; 1 row of a curve. */
  readonly controls: readonly [number, number];
  /** The numbers of points that a robust fit leaves out. */
  readonly outliers: readonly number[];
}

/** Reads the data points of a job. It has the axes of data that are much like it. */
export function dataOf(request: api.JobRequest, head: api.JobEvent, like: readonly Axes[] = []): Data {
  const lists = listsOf(request);
  const { isScattered } = lists;
  const isSurface = head.kind === "surface";
  const dimension = head.dimension;
  const rows = lists.rows.length;
  const columns = lists.rows[0]?.length ?? 0;
  const exact = new Float64Array(rows * columns * dimension).fill(NaN);
  lists.rows.forEach((row, i) =>
    row.forEach((point, j) => {
      if (point !== null) exact.set(typeof point === "number" ? [point] : (point as number[]), (i * columns + j) * dimension);
    }),
  );
  const parameters = parametersOf(head);
  const grid = { rows, columns, dimension };
  const own = new Axes(exact, dimension, isSurface);
  const used = like.find((axes) => axes.isLike(own)) ?? own;
  const positions = used.positions(exact, grid, parameters as never);
  const weights = weightsOf(request);
  const both = typeof head.closed === "boolean" ? [head.closed, head.closed] as const : [head.closed.u, head.closed.v] as const;
  return { exact, positions, ...grid, isSurface, isScattered, closed: both, weights, parameters, axes: used, controls: controlsOf(head), outliers: head.outliers?.indices ?? [] };
}

/** The data points of a request that is no job yet. */
export function dataBefore(request: api.JobRequest): Data {
  const { rows } = listsOf(request);
  const point = rows.map((row) => row.find((point) => point !== null)).find((point) => point !== undefined);
  const head = { kind: request.curve ? "curve" : "surface", dimension: Array.isArray(point) ? point.length : 1, parameters: [], closed: false, control_points: 0 };
  return dataOf(request, head as unknown as api.JobEvent);
}

/** What stands for data that are too many: where they are, by a curve or surface that is near to them. */
export function unseen(near: Float64Array | Float32Array, head: api.JobEvent, like: readonly Axes[]): Data {
  const isSurface = head.kind === "surface";
  const { dimension } = head;
  const own = new Axes(near, dimension, isSurface);
  return {
    exact: new Float64Array(0),
    positions: new Float32Array(0),
    dimension,
    rows: 0,
    columns: 0,
    isSurface,
    isScattered: true,
    closed: [false, false],
    weights: null,
    parameters: [],
    axes: like.find((axes) => axes.isLike(own)) ?? own,
    controls: controlsOf(head),
    outliers: [],
  };
}

function controlsOf({ control_points: count }: api.JobEvent): readonly [number, number] {
  return typeof count === "number" ? [1, count] : [count.u, count.v];
}

/** Of how many data points, in each direction, one is drawn. */
export function shareOf(data: Data, most = MOST_DRAWN): number {
  const count = data.rows * data.columns;
  return Math.ceil(data.rows > 1 ? Math.sqrt(count / most) : count / most);
}

/** The numbers of the data points that stand for all, as every third of each row and column does. */
export function chosen(data: Data, most = MOST_DRAWN): Uint32Array {
  const step = Math.max(1, shareOf(data, most));
  const across = Math.ceil(data.columns / step);
  const down = data.rows > 1 ? Math.ceil(data.rows / step) : data.rows;
  return Uint32Array.from({ length: across * down }, (_, i) => Math.floor(i / across) * step * data.columns + (i % across) * step);
}

/** Which of those that are drawn a data point is; -1 for none of them. */
export function drawnIndexOf(data: Data, index: number): number {
  const step = Math.max(1, shareOf(data));
  const [row, column] = [Math.floor(index / data.columns), index % data.columns];
  if (row % step > 0 || column % step > 0) return -1;
  return (row / step) * Math.ceil(data.columns / step) + column / step;
}

/** Where the data points are that are drawn. */
export function drawnOf(data: Data): Float32Array {
  const { positions } = data;
  if (shareOf(data) <= 1) return positions.slice();
  const points = new Float32Array(chosen(data).length * 3);
  chosen(data).forEach((index, to) => points.set(positions.subarray(index * 3, index * 3 + 3), to * 3));
  return points;
}

/** The place of the point with this number. */
export function placeOf({ isSurface, isScattered, columns }: Data, index: number): Place {
  return isSurface && !isScattered ? [Math.floor(index / columns), index % columns] : index;
}

/** The number of the point at this place. */
export function indexOf({ columns }: Data, place: Place): number {
  return typeof place === "number" ? place : place[0] * columns + place[1];
}

/**
 * Where a parameter is among increasing ones: "2.5" is between the third and the fourth. After the last one of
 * a direction that is closed it goes on to the end of the range, where the first one comes again.
 */
export function among(parameters: Float64Array, t: number, end: number): number {
  let low = 0;
  let high = parameters.length - 1;
  if (high < 1) return 0;
  if (t >= parameters[high]!) return high + (end > parameters[high]! ? Math.min(1, (t - parameters[high]!) / (end - parameters[high]!)) : 0);
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (parameters[middle]! <= t) low = middle;
    else high = middle;
  }
  return low + Math.max(0, (t - parameters[low]!) / (parameters[high]! - parameters[low]!));
}

type Row = readonly (readonly number[] | number | null)[];

function listsOf(request: api.JobRequest): { rows: readonly Row[]; isScattered: boolean } {
  if (request.curve) return { rows: [request.curve.points as unknown as Row], isScattered: false };
  const surface = request.surface as { points?: readonly Row[] | null; scattered?: Row | null; sections?: readonly Row[] | null; spacing?: readonly [number, number] | null; origin?: readonly [number, number] | null } | null | undefined;
  const scattered = surface?.scattered ?? surface?.sections?.flat();
  if (scattered) return { rows: [scattered], isScattered: true };
  const [rows, spacing] = [surface?.points ?? [], surface?.spacing];
  const [x, y] = surface?.origin ?? [0, 0];
  if (!spacing) return { rows, isScattered: false };
  return { rows: rows.map((row, i) => row.map((height, j) => (height === null ? null : [x + j * spacing[0], y + i * spacing[1], ...[height].flat()]))), isScattered: false };
}

function parametersOf({ parameters }: api.JobEvent): Float64Array[] {
  const both = typeof parameters === "object" && !Array.isArray(parameters) ? [parameters.u, parameters.v] : [parameters];
  return both.map((list) => Float64Array.from(Array.isArray(list) ? list : []));
}

/** Weights of single points; those of rows and columns are not looked at one by one. */
function weightsOf(request: api.JobRequest): readonly number[] | null {
  const weights = request.curve?.weights ?? request.surface?.weights ?? null;
  if (!Array.isArray(weights)) return null;
  return (weights as readonly (number | readonly number[])[]).flat() as number[];
}
