/** The canvas: one camera, up to four figures side by side, drawn when something has changed. */

import { ColorManagement } from "three";

import type { Cell } from "./cell.js";
import type { Figure } from "./figure.js";
import { Canvas2d } from "./canvas2d.js";
import { type Palette, palette } from "./palette.js";
import { Camera } from "./camera.js";
import type { WebGL } from "./webgl.js";

// Finer screens are not worth their pixels.
const FINEST = 2;

// Pictures that follow each other within so many milliseconds, from the end of one on, are a movement.
const REST = 160;

ColorManagement.enabled = false;

/**
 * Draws plainly at first, and with WebGL as soon as that is ready. Where WebGL is slow, because the processor does
 * its work, moving surfaces are still drawn plainly, and so are curves, which look the same.
 */
export class Viewport {
  readonly canvas = document.createElement("canvas");
  readonly camera: Camera;
  /** The colours of the moment. */
  palette: Palette = palette();
  /** True if all figures are drawn in one scene. */
  isOverlaid = false;
  /** The figure that is drawn before all others of one scene; null if they are where they are. */
  front: Figure | null = null;
  readonly #listeners: (() => void)[] = [];
  readonly #canvas2d = new Canvas2d();
  readonly #root: HTMLElement;
  #webgl: WebGL | null = null;
  #figures: readonly Figure[] = [];
  #frame = 0;
  #width = 1;
  #height = 1;
  #ratio = 0;
  #drawn = -Infinity;
  #rest = 0;

  constructor(root: HTMLElement) {
    this.#root = root;
    this.canvas.setAttribute("role", "img");
    root.prepend(this.canvas, this.#canvas2d.canvas);
    this.camera = new Camera(this.canvas, this.invalidate);
    this.canvas.addEventListener("webglcontextrestored", this.invalidate);
    new ResizeObserver(() => this.#resize()).observe(root);
    this.#resize();
  }

  /**
   * Goes over to WebGL, without waiting for anything but the context: shaders are made while the scene is drawn
   * plainly. Throws where there is no WebGL.
   */
  async begin(Drawer: typeof WebGL): Promise<void> {
    const webgl = new Drawer(this.canvas);
    await webgl.prepare(this.#figures, this.camera.perspective);
    webgl.setSize(this.#width, this.#height, this.#ratio);
    this.#webgl = webgl;
    this.#drawn = -Infinity;
    this.#draw();
    performance.mark("first picture of WebGL");
  }

  get figures(): readonly Figure[] {
    return this.#figures;
  }

  show(figures: readonly Figure[]): void {
    this.#figures = figures;
    this.#reshape();
    this.invalidate();
  }

  /** Draws with the next frame. */
  readonly invalidate = (): void => {
    this.#frame ||= requestAnimationFrame(() => {
      this.#frame = 0;
      this.#draw();
    });
  };

  /** Calls after each drawing. */
  onDraw(listener: () => void): void {
    this.#listeners.push(listener);
  }

  /** Where the figures are. */
  cells(): Cell[] {
    const count = this.isOverlaid ? 1 : this.#figures.length;
    const upright = this.#height > this.#width;
    const columns = count === 2 && upright ? 1 : Math.max(1, Math.ceil(Math.sqrt(count)));
    const rows = Math.max(1, Math.ceil(count / columns));
    const [width, height] = [this.#width / columns, this.#height / rows];
    return this.#figures.map((_, i) => (this.isOverlaid ? { x: 0, y: 0, width, height } : { x: (i % columns) * width, y: Math.floor(i / columns) * height, width, height }));
  }

  #resize(): void {
    const width = Math.max(1, this.#root.clientWidth);
    const height = Math.max(1, this.#root.clientHeight);
    const ratio = Math.min(FINEST, devicePixelRatio || 1);
    // Observers tell of the size that there was from the beginning, and each new one costs new buffers.
    if (width === this.#width && height === this.#height && ratio === this.#ratio) return;
    [this.#width, this.#height, this.#ratio] = [width, height, ratio];
    this.#webgl?.setSize(width, height, ratio);
    this.#reshape();
    // The canvas is empty now, and would be seen so until the next frame.
    this.#draw();
  }

  #reshape(): void {
    const [cell] = this.cells();
    if (cell !== undefined) this.camera.setShape(cell.width, cell.height, Math.min(cell.height * 0.3, this.#figures.length > 1 ? 60 : 44));
  }

  #draw(): void {
    const isMoving = performance.now() - this.#drawn < REST;
    const webgl = this.#webgl;
    const isPlain = webgl === null || (webgl.isSlow && this.#figures.every(({ isSurface, isStriped }) => !isSurface || (isMoving && !isStriped)));
    if (webgl === null || isPlain) this.#sketch(isMoving);
    else this.#render(webgl, isMoving);
    // Both canvases change with the same frame.
    this.#canvas2d.canvas.style.opacity = isPlain ? "1" : "0";
    this.canvas.style.opacity = isPlain ? "0" : "1";
    this.#drawn = performance.now();
    if (isPlain && isMoving) this.#wait();
    for (const listener of this.#listeners) listener();
  }

  /** Draws once more, with care, when nothing moves. */
  #wait(): void {
    clearTimeout(this.#rest);
    this.#rest = window.setTimeout(() => {
      this.#drawn = -Infinity;
      this.invalidate();
    }, REST);
  }

  #sketch(isMoving: boolean): void {
    // Each pixel of a surface costs time; lines are fine where the screen is.
    const ratio = this.#figures.some(({ isSurface }) => isSurface) ? 1 : this.#ratio;
    this.#canvas2d.clear(this.#width, this.#height, ratio);
    const { perspective } = this.camera;
    this.#each(1, (figure, cell) => this.isOverlaid || this.#canvas2d.draw([figure], perspective, cell, isMoving));
    const [cell] = this.cells();
    if (this.isOverlaid && cell !== undefined) this.#canvas2d.draw(this.#ordered, perspective, cell, isMoving);
  }

  #render(webgl: WebGL, isMoving: boolean): void {
    const begin = performance.now();
    webgl.clear(this.#width, this.#height);
    this.#each(this.#ratio, (figure, cell) => {
      if (figure === this.front) webgl.clearDepth();
      webgl.draw(figure, this.camera.perspective, cell);
    });
    if (!isMoving || webgl.isUndecided) webgl.time(begin);
  }

  /** In the order in which they are drawn. */
  get #ordered(): readonly Figure[] {
    const { front } = this;
    return front !== null && this.isOverlaid && this.#figures.includes(front) ? [...this.#figures.filter((figure) => figure !== front), front] : this.#figures;
  }

  #each(ratio: number, draw: (figure: Figure, cell: Cell) => void): void {
    const figures = this.#ordered;
    this.cells().forEach((cell, i) => {
      const figure = figures[i];
      if (figure === undefined) return;
      figure.setSize(cell.width, cell.height, ratio, this.palette);
      draw(figure, cell);
    });
  }
}
