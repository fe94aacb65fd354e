/**
 * Drawing without WebGL. A context of WebGL and its shaders take longer than a fit; until they are there the same
 * scene is drawn into a canvas of two dimensions. Where there is no WebGL it stays so, and where the processor has to
 * do the work of WebGL this is quicker.
 */

import { Matrix4, type PerspectiveCamera } from "three";

import { Dots } from "./dots.js";
import { FatLine } from "./fatline.js";
import type { Figure } from "./figure.js";
import { Net } from "./net.js";
import { SoftwareRasterizer, type View } from "./software-rasterizer.js";
import type { Cell } from "./cell.js";
import { Surface } from "./surface.js";

// What lies on a surface is this much nearer than it; of the depth that a canvas has.
const LIFT = 2e-4;
// So many dots are enough while they move.
const MOVING = 3000;
const MANY = 1000;

type Uniforms = Readonly<Record<string, { value: unknown }>>;

/** A canvas over that of WebGL. */
export class Canvas2d {
  readonly canvas = document.createElement("canvas");
  readonly #context = this.canvas.getContext("2d");

  constructor() {
    this.canvas.className = "canvas2d";
    this.canvas.setAttribute("aria-hidden", "true");
  }

  /** Begins a picture of this size in pixels of the page, each of which has so many of the screen on a side. */
  clear(width: number, height: number, ratio: number): void {
    const { canvas } = this;
    const [across, down] = [Math.round(width * ratio), Math.round(height * ratio)];
    if (canvas.width !== across || canvas.height !== down) [canvas.width, canvas.height] = [across, down];
    this.#context?.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.#context?.clearRect(0, 0, width, height);
  }

  /** Draws figures into a part of the canvas; surfaces hide what is behind them. */
  draw(figures: readonly Figure[], camera: PerspectiveCamera, cell: Cell, isMoving: boolean): void {
    const context = this.#context;
    const [width, height] = [Math.round(cell.width), Math.round(cell.height)];
    if (context === null || width < 1 || height < 1) return;
    camera.updateMatrixWorld();
    const all = figures.map(({ scene, group }) => {
      scene.updateMatrixWorld();
      const eye = new Matrix4().multiplyMatrices(camera.matrixWorldInverse, group.matrixWorld);
      const clip = new Matrix4().multiplyMatrices(camera.projectionMatrix, eye);
      const view: View = { eye: eye.elements, clip: clip.elements, width, height };
      return { view, parts: group.children.filter(({ visible }) => visible) };
    });
    const surfaces = all.flatMap(({ view, parts }) => parts.flatMap((part) => (part instanceof Surface ? { surface: part, view } : [])));
    const rasterizer = surfaces.length === 0 ? null : new SoftwareRasterizer(width, height);
    for (const { surface, view } of surfaces) rasterizer!.draw(surface, view);
    if (rasterizer !== null) context.putImageData(rasterizer.image, Math.round(cell.x), Math.round(cell.y));
    context.save();
    context.beginPath();
    context.rect(cell.x, cell.y, cell.width, cell.height);
    context.clip();
    context.translate(cell.x, cell.y);
    for (const { view, parts } of all) {
      for (const part of parts) {
        if (part instanceof FatLine) lines(context, part, view, rasterizer);
        else if (part instanceof Net) net(context, part, view, rasterizer);
        else if (part instanceof Dots) dots(context, part, view, rasterizer, isMoving);
      }
    }
    context.restore();
  }
}

/** Where a point is on the canvas, and how far away; null behind the camera. */
function placed(positions: ArrayLike<number>, at: number, { clip: m, width, height }: View): readonly [number, number, number] | null {
  const [x, y, z] = [positions[at]!, positions[at + 1]!, positions[at + 2]!];
  const w = m[3]! * x + m[7]! * y + m[11]! * z + m[15]!;
  if (!(w > 0)) return null;
  const right = (m[0]! * x + m[4]! * y + m[8]! * z + m[12]!) / w;
  const up = (m[1]! * x + m[5]! * y + m[9]! * z + m[13]!) / w;
  return [((right + 1) / 2) * width, ((1 - up) / 2) * height, (m[2]! * x + m[6]! * y + m[10]! * z + m[14]!) / w];
}

/** What has many corners has blunt ones, which nobody sees. */
function pen(context: CanvasRenderingContext2D, uniforms: Uniforms, width: number, corners: number): void {
  context.strokeStyle = `#${(uniforms["color"]!.value as { getHexString(): string }).getHexString()}`;
  context.globalAlpha = uniforms["opacity"]!.value as number;
  context.lineWidth = width;
  context.lineJoin = corners > MANY ? "bevel" : "round";
  context.lineCap = corners > MANY ? "butt" : "round";
}

/** One line, or many between two points each. */
function lines(context: CanvasRenderingContext2D, { geometry, material }: FatLine, view: View, rasterizer: SoftwareRasterizer | null): void {
  const from = geometry.getAttribute("from") as unknown as { data: { array: Float32Array; stride: number } } | undefined;
  if (from === undefined) return;
  const { array, stride } = from.data;
  pen(context, material.uniforms, material.uniforms["width"]!.value as number, geometry.instanceCount);
  context.beginPath();
  for (let i = 0; i < geometry.instanceCount; i++) segment(context, array, i * stride, i * stride + 3, view, rasterizer, stride > 3 || i === 0 || rasterizer !== null);
  context.stroke();
}

function net(context: CanvasRenderingContext2D, { geometry, material }: Net, view: View, rasterizer: SoftwareRasterizer | null): void {
  const positions = geometry.getAttribute("position")?.array;
  const index = geometry.index?.array;
  if (positions === undefined || index === undefined) return;
  pen(context, material.uniforms, 1, index.length);
  context.beginPath();
  for (let i = 0; i + 1 < index.length; i += 2) segment(context, positions, index[i]! * 3, index[i + 1]! * 3, view, rasterizer, true);
  context.stroke();
}

/** Goes along a line, unless it is behind the surface. */
function segment(context: CanvasRenderingContext2D, positions: ArrayLike<number>, a: number, b: number, view: View, rasterizer: SoftwareRasterizer | null, begins: boolean): void {
  const [from, to] = [placed(positions, a, view), placed(positions, b, view)];
  if (from === null || to === null) return;
  if (rasterizer !== null && rasterizer.hides((from[0] + to[0]) / 2, (from[1] + to[1]) / 2, (from[2] + to[2]) / 2 - LIFT)) return;
  if (begins) context.moveTo(from[0], from[1]);
  context.lineTo(to[0], to[1]);
}

function dots(context: CanvasRenderingContext2D, { geometry, material }: Dots, view: View, rasterizer: SoftwareRasterizer | null, isMoving: boolean): void {
  const positions = geometry.getAttribute("position")?.array;
  if (positions === undefined) return;
  const { uniforms } = material;
  const hex = (name: string) => `#${(uniforms[name]!.value as { getHexString(): string }).getHexString()}`;
  const [radius, rim] = [(uniforms["diameter"]!.value as number) / 2, uniforms["rimWidth"]!.value as number];
  const paths: [string, number][] = rim > 0 ? [[hex("rim"), radius], [hex("color"), radius - rim]] : [[hex("color"), radius]];
  context.globalAlpha = uniforms["opacity"]!.value as number;
  const seen: (readonly [number, number, number])[] = [];
  const step = isMoving ? Math.ceil(positions.length / 3 / MOVING) : 1;
  for (let i = 0; i < positions.length; i += 3 * step) {
    const at = placed(positions, i, view);
    if (at !== null && !(rasterizer?.hides(at[0], at[1], at[2] - LIFT) ?? false)) seen.push(at);
  }
  for (const [color, r] of paths) {
    context.fillStyle = color;
    context.beginPath();
    for (const [x, y] of seen) {
      context.moveTo(x + r, y);
      if (r > 1) context.arc(x, y, r, 0, 2 * Math.PI);
      else context.rect(x - r, y - r, 2 * r, 2 * r);
    }
    context.fill();
  }
}
