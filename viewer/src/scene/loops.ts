/** Loops in a grid: their parts in each cell, and which vertices are inside. */

/** A part of a loop within one cell. */
export interface Chain {
  /** In their order along the loop, from side to side of the cell, or all of the loop. */
  readonly vertices: readonly number[];
  /** Where it begins and ends along the sides of the cell, counter-clockwise: 0 to 4 from its first corner. */
  readonly from: number;
  readonly to: number;
  /** True if the loop does not leave the cell. */
  readonly isClosed: boolean;
  /** True if it is clockwise, of closed ones. */
  readonly isHole: boolean;
}

// A corner that is nearer to a line than this counts as beside it, so that each is in one cell; in rows.
const BESIDE = 1e-6;
// Corners on the sides of the grid are outside by this much, so that its cells are whole.
const BEYOND = 1e-3;

type Cell = readonly [row: number, column: number];

/** A corner of a loop, or where it crosses a line from one cell to the next. */
interface Stop {
  readonly vertex: number;
  /** The cell after the line; null of a corner. */
  readonly entered: Cell | null;
}

/** x is along the rows of a grid, y along its columns; the lines need not be equally far apart. */
export class GridLoops {
  /** By the number of the first corner of the cell. */
  readonly chains = new Map<number, Chain[]>();
  /** Pairs of vertices. */
  readonly boundary: number[] = [];
  readonly #rows: readonly number[];
  readonly #columns: readonly number[];
  readonly #places: number[] = [];
  /** How much more often loops go around a vertex than around the one before it, along each column. */
  readonly #turns: Int32Array;

  constructor(rows: readonly number[], columns: readonly number[]) {
    this.#rows = rows;
    this.#columns = columns;
    this.#turns = new Int32Array(rows.length * columns.length);
  }

  /** Row and column of each vertex of the loops. */
  places(): Float64Array {
    return Float64Array.from(this.#places);
  }

  /** Row and column of a vertex, also one of the grid. */
  placeOf(vertex: number): [number, number] {
    const across = this.#columns.length;
    const at = (vertex - this.#rows.length * across) * 2;
    if (at >= 0) return [this.#places[at]!, this.#places[at + 1]!];
    return [this.#rows[Math.floor(vertex / across)]!, this.#columns[vertex % across]!];
  }

  /** 1 for each vertex of the grid on the left of the loops, else 0. */
  inside(): Uint8Array {
    const [down, across] = [this.#rows.length, this.#columns.length];
    const inside = new Uint8Array(down * across);
    for (let j = 0; j < across; j++) {
      for (let i = 0, turns = 0; i < down; i++) inside[i * across + j] = (turns += this.#turns[i * across + j]!) > 0 ? 1 : 0;
    }
    return inside;
  }

  /** Goes along a loop, given by pairs of a row and a column. */
  follow(loop: Float64Array): void {
    const count = loop.length / 2;
    if (count < 3) return;
    const x = Float64Array.from({ length: count }, (_, k) => beside(loop[k * 2]!, this.#rows));
    const y = Float64Array.from({ length: count }, (_, k) => beside(loop[k * 2 + 1]!, this.#columns));
    const stops: Stop[] = [];
    let cell: Cell = [cellOf(x[0]!, this.#rows), cellOf(y[0]!, this.#columns)];
    for (let k = 0, next = 1; k < count; k++, next = (k + 1) % count) {
      stops.push({ vertex: this.#vertex(x[k]!, y[k]!), entered: null });
      const lines = [...crossings(x[k]!, x[next]!, this.#rows, 0), ...crossings(y[k]!, y[next]!, this.#columns, 1)].sort((a, b) => a.share - b.share);
      for (const { axis, line, step, share } of lines) {
        cell = axis === 0 ? [cell[0] + step, cell[1]] : [cell[0], cell[1] + step];
        if (axis === 1) this.#turn(cell[0] + 1, line, -step);
        const place = [x[k]! + (x[next]! - x[k]!) * share, y[k]! + (y[next]! - y[k]!) * share] as const;
        const vertex = axis === 0 ? this.#vertex(this.#rows[line]!, place[1]) : this.#vertex(place[0], this.#columns[line]!);
        stops.push({ vertex, entered: cell });
      }
    }
    stops.forEach(({ vertex }, k) => this.boundary.push(vertex, stops[(k + 1) % stops.length]!.vertex));
    this.#divide(stops, cell);
  }

  /** Keeps a loop by its parts in cells; `cell` is that of a loop that crosses no line. */
  #divide(stops: readonly Stop[], cell: Cell): void {
    const begin = stops.findIndex(({ entered }) => entered !== null);
    if (begin < 0) return this.#keep(cell, { vertices: stops.map(({ vertex }) => vertex), from: 0, to: 0, isClosed: true, isHole: this.#areaOf(stops) < 0 });
    let first = stops[begin]!;
    let vertices = [first.vertex];
    for (let k = 1; k <= stops.length; k++) {
      const stop = stops[(begin + k) % stops.length]!;
      vertices.push(stop.vertex);
      if (stop.entered === null) continue;
      const within = first.entered!;
      this.#keep(within, { vertices, from: this.#along(within, first.vertex), to: this.#along(within, stop.vertex), isClosed: false, isHole: false });
      [first, vertices] = [stop, [stop.vertex]];
    }
  }

  #keep([i, j]: Cell, chain: Chain): void {
    if (i < 0 || j < 0 || i + 1 >= this.#rows.length || j + 1 >= this.#columns.length) return;
    const at = i * this.#columns.length + j;
    const others = this.chains.get(at);
    if (others === undefined) this.chains.set(at, [chain]);
    else others.push(chain);
  }

  #vertex(x: number, y: number): number {
    this.#places.push(within(x, this.#rows), within(y, this.#columns));
    return this.#rows.length * this.#columns.length + this.#places.length / 2 - 1;
  }

  /** Loops go around the vertices of a column from this row on more often, or less. */
  #turn(row: number, column: number, by: number): void {
    if (row < this.#rows.length) this.#turns[row * this.#columns.length + column]! += by;
  }

  /** Where a vertex is along the sides of a cell. */
  #along([i, j]: Cell, vertex: number): number {
    const [x, y] = this.placeOf(vertex);
    const [left, right, low, high] = [this.#rows[i]!, this.#rows[i + 1]!, this.#columns[j]!, this.#columns[j + 1]!];
    const share = (value: number, from: number, to: number) => Math.min(1, Math.max(0, (value - from) / (to - from)));
    if (y === low) return share(x, left, right);
    if (x === right) return 1 + share(y, low, high);
    if (y === high) return 2 + share(x, right, left);
    return 3 + share(y, high, low);
  }

  /** Positive if a loop is counter-clockwise. */
  #areaOf(stops: readonly Stop[]): number {
    return stops.reduce((sum, { vertex }, k) => {
      const [x0, y0] = this.placeOf(vertex);
      const [x1, y1] = this.placeOf(stops[(k + 1) % stops.length]!.vertex);
      return sum + x0 * y1 - x1 * y0;
    }, 0);
  }
}

interface Crossing {
  readonly axis: 0 | 1;
  readonly line: number;
  /** To the cell after the line, or to that before it. */
  readonly step: 1 | -1;
  /** How far along the edge. */
  readonly share: number;
}

/** The lines that an edge crosses; neither end is on one. */
function crossings(from: number, to: number, lines: readonly number[], axis: 0 | 1): Crossing[] {
  const [first, last] = [cellOf(from, lines), cellOf(to, lines)];
  const step = last > first ? 1 : -1;
  return Array.from({ length: Math.abs(last - first) }, (_, k) => {
    const line = step > 0 ? first + 1 + k : first - k;
    return { axis, line, step, share: (lines[line]! - from) / (to - from) };
  });
}

/** The cell after the last line that is not after a value; -1 before the first line. */
function cellOf(value: number, lines: readonly number[]): number {
  let low = -1;
  let high = lines.length;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (lines[middle]! <= value) low = middle;
    else high = middle;
  }
  return low;
}

/** A value that is beside all lines; on the first or the last one it is outside. */
function beside(value: number, lines: readonly number[]): number {
  const [first, last] = [lines[0]!, lines.at(-1)!];
  if (value < first + BESIDE) return first - BEYOND;
  if (value > last - BESIDE) return last + BEYOND;
  const cell = cellOf(value + BESIDE, lines);
  return Math.abs(value - lines[cell]!) <= BESIDE ? lines[cell]! + BESIDE : value;
}

function within(value: number, lines: readonly number[]): number {
  return Math.min(lines.at(-1)!, Math.max(lines[0]!, value));
}
