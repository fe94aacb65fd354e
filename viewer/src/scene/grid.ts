/** Triangles and normals of points in rows and columns. */

/** Every so many of the numbers from 0 on, and the last one. */
export function every(step: number, count: number): number[] {
  const list = Array.from({ length: Math.ceil((count - 1) / step) }, (_, i) => i * step);
  return [...list, count - 1];
}

/** Two triangles for each cell between the rows and columns. */
export function indicesOf(rows: number, columns: number): Uint32Array {
  const indices = new Uint32Array((rows - 1) * (columns - 1) * 6);
  let at = 0;
  for (let i = 0; i + 1 < rows; i++) {
    for (let j = 0; j + 1 < columns; j++) {
      const a = i * columns + j;
      const b = a + columns;
      indices[at++] = a;
      indices[at++] = b;
      indices[at++] = a + 1;
      indices[at++] = b;
      indices[at++] = b + 1;
      indices[at++] = a + 1;
    }
  }
  return indices;
}

/** The lines along rows and columns, two indices each. */
export function netOf(rows: number, columns: number): Uint32Array {
  const lines: number[] = [];
  for (let i = 0; i < rows; i++) {
    for (let j = 0; j < columns; j++) {
      const a = i * columns + j;
      if (j + 1 < columns) lines.push(a, a + 1);
      if (i + 1 < rows) lines.push(a, a + columns);
    }
  }
  return Uint32Array.from(lines);
}

/** Normals by differences of the neighbours, across the seam where a surface is closed. */
export function normalsOf(p: Float32Array, rows: number, columns: number, normals: Float32Array): void {
  const [closedU, closedV] = closedOf(p, rows, columns);
  for (let i = 0; i < rows; i++) {
    const [up, down] = neighbours(i, rows, closedU);
    for (let j = 0; j < columns; j++) {
      const [left, right] = neighbours(j, columns, closedV);
      const a = (up * columns + j) * 3;
      const b = (down * columns + j) * 3;
      const c = (i * columns + left) * 3;
      const d = (i * columns + right) * 3;
      const [ux, uy, uz] = [p[b]! - p[a]!, p[b + 1]! - p[a + 1]!, p[b + 2]! - p[a + 2]!];
      const [vx, vy, vz] = [p[d]! - p[c]!, p[d + 1]! - p[c + 1]!, p[d + 2]! - p[c + 2]!];
      const [x, y, z] = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
      const length = Math.sqrt(x * x + y * y + z * z) || 1;
      const at = (i * columns + j) * 3;
      normals[at] = x / length;
      normals[at + 1] = y / length;
      normals[at + 2] = z / length;
    }
  }
}

/** True for each direction in which a surface is closed: the last row, or column, is the first one. */
export function closedOf(p: Float32Array, rows: number, columns: number): [boolean, boolean] {
  return [isSame(p, 0, (rows - 1) * columns, columns), isSame(p, 0, columns - 1, 1)];
}

function neighbours(i: number, count: number, closed: boolean): [number, number] {
  if (!closed) return [Math.max(0, i - 1), Math.min(count - 1, i + 1)];
  return [i === 0 ? count - 2 : i - 1, i === count - 1 ? 1 : i + 1];
}

/** Whether points are the same as others, as far as 32 bits tell. */
function isSame(p: Float32Array, a: number, b: number, count: number): boolean {
  if (a === b) return false;
  let extent = 0;
  let apart = 0;
  for (let i = 0; i < count * 3; i++) {
    apart = Math.max(apart, Math.abs(p[a * 3 + i]! - p[b * 3 + i]!));
    extent = Math.max(extent, Math.abs(p[a * 3 + i]! - p[(i % 3) + 3 * Math.floor(p.length / 6)]!));
  }
  return apart <= extent * 1e-5;
}
