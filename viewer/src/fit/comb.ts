/** The curvature of a curve, by differences of its samples. */

/** Curvature times normal at each point, three numbers each, and the largest curvature but for where the curve all but turns back. */
export interface Curvature {
  readonly vectors: Float32Array;
  readonly most: number;
}

/** Of points with three coordinates each. Where the curve stands still there is none. */
export function curvature(p: Float64Array | Float32Array): Curvature {
  const count = p.length / 3;
  const vectors = new Float32Array(p.length);
  const sizes: number[] = [];
  const closed = count > 3 && distance(p, 0, count - 1) < distance(p, 0, 1) * 1e-3;
  for (let i = 0; i < count; i++) {
    const before = i > 0 ? i - 1 : closed ? count - 2 : 0;
    const after = i + 1 < count ? i + 1 : closed ? 1 : count - 1;
    if (before === i || after === i) continue;
    const a = distance(p, before, i);
    const b = distance(p, i, after);
    if (!(a > 0) || !(b > 0)) continue;
    let size = 0;
    for (let axis = 0; axis < 3; axis++) {
      // The second derivative by arc length, and so at right angles to the curve but for a small rest.
      const second = ((p[after * 3 + axis]! - p[i * 3 + axis]!) / b - (p[i * 3 + axis]! - p[before * 3 + axis]!) / a) / ((a + b) / 2);
      vectors[i * 3 + axis] = second;
      size += second * second;
    }
    sizes.push(Math.sqrt(size));
  }
  sizes.sort((x, y) => x - y);
  const common = sizes[Math.floor((sizes.length - 1) * 0.9)] ?? 0;
  return { vectors, most: Math.min(sizes.at(-1) ?? 0, 10 * common) };
}

function distance(p: Float64Array | Float32Array, i: number, j: number): number {
  return Math.hypot(p[i * 3]! - p[j * 3]!, p[i * 3 + 1]! - p[j * 3 + 1]!, p[i * 3 + 2]! - p[j * 3 + 2]!);
}

/** The largest of 1, 2, 5, 10, … that is not more. */
export function round125(value: number): number {
  if (!(value > 0) || !Number.isFinite(value)) return 1;
  const power = 10 ** Math.floor(Math.log10(value));
  const lead = value / power;
  return (lead >= 5 ? 5 : lead >= 2 ? 2 : 1) * power;
}
