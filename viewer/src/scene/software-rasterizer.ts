/** A surface drawn by the processor: triangles with a colour and a depth at each corner. */

import { Color } from "three";

import { valuesAt } from "./cut.js";
import { every } from "./grid.js";
import { HEAT } from "./palette.js";
import type { Surface } from "./surface.js";

/** From the coordinates of a figure to those of the eye and of the canvas; matrices by columns. */
export interface View {
  readonly eye: ArrayLike<number>;
  readonly clip: ArrayLike<number>;
  readonly width: number;
  readonly height: number;
}

// So many samples are enough for a picture that is seen for a moment.
const MOST = 3000;

const KEY = unit(-0.42, 0.72, 0.55);
const FILL = unit(0.8, -0.1, 0.35);

// Neighbours share the pixels on their edge, so that nothing is seen between them.
const EDGE = 1e-5;

/** What is seen of a corner: x, y, depth, red, green and blue. */
const PARTS = 6;

export class SoftwareRasterizer {
  readonly image: ImageData;
  #view: View;
  readonly #depth: Float32Array;
  readonly #pixels: Uint32Array;

  constructor(width: number, height: number) {
    this.#view = { eye: [], clip: [], width, height };
    this.image = new ImageData(width, height);
    this.#pixels = new Uint32Array(this.image.data.buffer);
    this.#depth = new Float32Array(width * height).fill(Infinity);
  }

  /** Whether the surface is before a place. */
  hides(x: number, y: number, depth: number): boolean {
    const { width, height } = this.#view;
    if (!(x >= 0 && y >= 0 && x < width && y < height)) return false;
    return this.#depth[Math.floor(y) * width + Math.floor(x)]! < depth;
  }

  /** Draws a surface before what is behind it. */
  draw({ rows, columns, cut, geometry, material }: Surface, view: View): void {
    this.#view = view;
    const positions = geometry.getAttribute("position").array as Float32Array;
    const normals = geometry.getAttribute("normal").array as Float32Array;
    const heat = geometry.getAttribute("heat").array as Float32Array;
    const light = lightOf(material.uniforms);
    const step = Math.max(1, Math.ceil(Math.sqrt((rows * columns) / MOST)));
    const [down, across] = [every(step, rows), every(step, columns)];
    const left = cut?.at(step) ?? null;
    const corners = new Float32Array((down.length * across.length + (left?.places.length ?? 0) / 2) * PARTS);
    let to = 0;
    for (const i of down) for (const j of across) this.#corner(positions, normals, heat[i * columns + j]!, (i * columns + j) * 3, light, corners, PARTS * to++);
    if (left !== null) {
      const [p, n, h] = ([[positions, 3], [normals, 3], [heat, 1]] as const).map(([values, size]) => valuesAt(left.places, values, size, rows, columns)) as [Float32Array, Float32Array, Float32Array];
      for (let k = 0; k < h.length; k++) this.#corner(p, n, h[k]!, k * 3, light, corners, PARTS * to++);
      const { indices } = left;
      for (let k = 0; k < indices.length; k += 3) this.#triangle(corners, indices[k]! * PARTS, indices[k + 1]! * PARTS, indices[k + 2]! * PARTS);
      return;
    }
    for (let i = 0; i + 1 < down.length; i++) {
      for (let j = 0; j + 1 < across.length; j++) {
        const a = (i * across.length + j) * PARTS;
        const b = a + across.length * PARTS;
        this.#triangle(corners, a, b, a + PARTS);
        this.#triangle(corners, b, b + PARTS, a + PARTS);
      }
    }
  }

  #corner(p: Float32Array, n: Float32Array, heat: number, at: number, light: Light, corners: Float32Array, to: number): void {
    const { eye: e, clip: c, width, height } = this.#view;
    const [x, y, z] = [p[at]!, p[at + 1]!, p[at + 2]!];
    const w = c[3]! * x + c[7]! * y + c[11]! * z + c[15]!;
    // A corner behind the camera has no place, and no triangle with it is drawn.
    corners[to] = w > 0 ? (((c[0]! * x + c[4]! * y + c[8]! * z + c[12]!) / w + 1) / 2) * width : NaN;
    corners[to + 1] = ((1 - (c[1]! * x + c[5]! * y + c[9]! * z + c[13]!) / w) / 2) * height;
    corners[to + 2] = (c[2]! * x + c[6]! * y + c[10]! * z + c[14]!) / w;
    const normal = unit(...turned(e, n[at]!, n[at + 1]!, n[at + 2]!));
    const [ex, ey, ez] = turned(e, x, y, z);
    const [r, g, b] = light(normal, unit(-ex - e[12]!, -ey - e[13]!, -ez - e[14]!), heat);
    corners[to + 3] = r;
    corners[to + 4] = g;
    corners[to + 5] = b;
  }

  /** Each part of a corner changes by the same amount from one pixel to the next, and from row to row. */
  #triangle(p: Float32Array, a: number, b: number, c: number): void {
    // No lists here: until this is compiled each would be made anew for each triangle.
    const { width, height } = this.#view;
    const ax = p[a]!;
    const ay = p[a + 1]!;
    const bx = p[b]! - ax;
    const by = p[b + 1]! - ay;
    const cx = p[c]! - ax;
    const cy = p[c + 1]! - ay;
    const area = bx * cy - cx * by;
    if (!(Math.abs(area) > 1e-6)) return;
    // How the shares of the second and the third corner change to the right, and downwards.
    const vx = cy / area;
    const vy = -cx / area;
    const wx = -by / area;
    const wy = bx / area;
    const left = Math.max(0, Math.ceil(ax + Math.min(0, bx, cx) - 0.5));
    const right = Math.min(width - 1, Math.floor(ax + Math.max(0, bx, cx) - 0.5));
    const top = Math.max(0, Math.ceil(ay + Math.min(0, by, cy) - 0.5));
    const bottom = Math.min(height - 1, Math.floor(ay + Math.max(0, by, cy) - 0.5));
    const depth = this.#depth;
    const pixels = this.#pixels;
    const z = p[a + 2]!;
    const zv = p[b + 2]! - z;
    const zw = p[c + 2]! - z;
    const r = p[a + 3]!;
    const rv = p[b + 3]! - r;
    const rw = p[c + 3]! - r;
    const g = p[a + 4]!;
    const gv = p[b + 4]! - g;
    const gw = p[c + 4]! - g;
    const l = p[a + 5]!;
    const lv = p[b + 5]! - l;
    const lw = p[c + 5]! - l;
    for (let row = top; row <= bottom; row++) {
      const x = left + 0.5 - ax;
      const y = row + 0.5 - ay;
      let v = x * vx + y * vy;
      let w = x * wx + y * wy;
      const first = row * width;
      for (let at = first + left; at <= first + right; at++, v += vx, w += wx) {
        if (v < -EDGE || w < -EDGE || v + w > 1 + EDGE) continue;
        const deep = z + v * zv + w * zw;
        if (deep >= depth[at]!) continue;
        depth[at] = deep;
        pixels[at] = -0x1000000 | (byte(l + v * lv + w * lw) << 16) | (byte(g + v * gv + w * gw) << 8) | byte(r + v * rv + w * rw);
      }
    }
  }
}

type Three = readonly [number, number, number];
type Light = (normal: Three, eye: Three, heat: number) => Three;

/** The colour of a corner, as the shader of the surface has it, without stripes and lines. */
function lightOf(uniforms: Readonly<Record<string, { value: unknown }>>): Light {
  const [lit, shade, deep] = ["lit", "shade", "deep"].map((name) => uniforms[name]!.value as Color) as [Color, Color, Color];
  const ramp = uniforms["ramp"]!.value as Color[];
  const [hot, dark] = [uniforms["hot"]!.value as number, uniforms["dark"]!.value as number];
  const color = new Color();
  const dim = new Color();
  return (given, eye, heat) => {
    const back = dot(given, eye) < 0;
    const n: Three = back ? [-given[0], -given[1], -given[2]] : given;
    const tone = smooth(0.12, 0.96, (dot(n, KEY) * 0.5 + 0.5) * 0.86 + (dot(n, FILL) * 0.5 + 0.5) * 0.14);
    if (tone < 0.5) color.lerpColors(deep, shade, tone * 2);
    else color.lerpColors(shade, lit, tone * 2 - 1);
    if (back) color.lerp(dim.lerpColors(deep, shade, tone), 0.55);
    if (hot > 0.5) {
      const x = Math.min(Math.max(heat, 0), 1) * (HEAT - 1);
      const low = Math.min(HEAT - 2, Math.floor(x));
      color.lerpColors(ramp[low]!, ramp[low + 1]!, x - low).multiplyScalar(0.72 + 0.36 * tone);
    }
    const shine = (1 - 0.6 * hot) * (dark > 0.5 ? 0.1 : 0.16) * Math.max(dot(n, unit(KEY[0] + eye[0], KEY[1] + eye[1], KEY[2] + eye[2])), 0) ** 42;
    const dull = dark > 0.5 ? 1 : 1 - 0.16 * (1 - Math.max(dot(n, eye), 0)) ** 3;
    return [(color.r + shine) * dull, (color.g + shine) * dull, (color.b + shine) * dull];
  };
}

function turned(m: ArrayLike<number>, x: number, y: number, z: number): Three {
  return [m[0]! * x + m[4]! * y + m[8]! * z, m[1]! * x + m[5]! * y + m[9]! * z, m[2]! * x + m[6]! * y + m[10]! * z];
}

function unit(x: number, y: number, z: number): Three {
  const length = Math.hypot(x, y, z) || 1;
  return [x / length, y / length, z / length];
}

function dot(a: Three, b: Three): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

function smooth(low: number, high: number, x: number): number {
  const t = Math.min(1, Math.max(0, (x - low) / (high - low)));
  return t * t * (3 - 2 * t);
}

function byte(value: number): number {
  return value >= 1 ? 255 : value <= 0 ? 0 : (value * 255 + 0.5) | 0;
}
