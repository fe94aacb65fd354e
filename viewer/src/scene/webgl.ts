/** Drawing with WebGL. It is a script of its own: until it is here and its shaders are made, fits are drawn plainly. */

import { LinearSRGBColorSpace, type PerspectiveCamera, WebGLRenderer } from "three";

import type { Figure } from "./figure.js";
import type { Cell } from "./cell.js";

// A picture that takes longer is no frame of a movement; in milliseconds.
const SLOW = 26;

export class WebGL {
  readonly #renderer: WebGLRenderer;
  readonly #pixel = new Uint8Array(4);
  #height = 1;
  #took: [number, number] = [0, 0];

  /** Throws where there is no WebGL. */
  constructor(canvas: HTMLCanvasElement) {
    const renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true, powerPreference: "high-performance" });
    renderer.outputColorSpace = LinearSRGBColorSpace;
    renderer.autoClear = false;
    // Asking for errors waits for shaders; those here are tested.
    renderer.debug.checkShaderErrors = false;
    // Figures are drawn in the order of their parts.
    renderer.sortObjects = false;
    renderer.setScissorTest(true);
    renderer.setClearColor(0x000000, 0);
    this.#renderer = renderer;
  }

  /** Whether the last pictures that were timed took long: the first of a kind also makes buffers. */
  get isSlow(): boolean {
    return Math.min(...this.#took) > SLOW;
  }

  /** Whether one of them did and the other did not: the next one tells. */
  get isUndecided(): boolean {
    return !this.isSlow && Math.max(...this.#took) > SLOW;
  }

  /** Makes the shaders, beside everything else where the browser can. */
  async prepare(figures: readonly Figure[], camera: PerspectiveCamera): Promise<void> {
    const renderer = this.#renderer;
    const inThreads = renderer.extensions.has("KHR_parallel_shader_compile");
    for (const { scene } of figures) await renderer[inThreads ? "compileAsync" : "compile"](scene, camera);
  }

  setSize(width: number, height: number, ratio: number): void {
    this.#height = height;
    this.#renderer.setPixelRatio(ratio);
    this.#renderer.setSize(width, height, false);
  }

  clear(width: number, height: number): void {
    this.#renderer.setViewport(0, 0, width, height);
    this.#renderer.setScissor(0, 0, width, height);
    this.#renderer.clear();
  }

  /** What is drawn from now on lies before what there is. */
  clearDepth(): void {
    this.#renderer.clearDepth();
  }

  draw({ scene }: Figure, camera: PerspectiveCamera, { x, y, width, height }: Cell): void {
    const bottom = this.#height - y - height;
    this.#renderer.setViewport(x, bottom, width, height);
    this.#renderer.setScissor(x, bottom, width, height);
    this.#renderer.render(scene, camera);
  }

  /** Waits until what was asked for since then is drawn, and keeps how long that took. */
  time(since: number): void {
    const context = this.#renderer.getContext();
    context.readPixels(0, 0, 1, 1, context.RGBA, context.UNSIGNED_BYTE, this.#pixel);
    this.#took = [this.#took[1], performance.now() - since];
  }
}
