/** A data point that is dragged in the Edit mode, and the fit that follows; a click chooses one in either mode. */

import { Plane, Raycaster, Vector2, Vector3 } from "three";

import type { App } from "../app.js";
import { placeOf } from "../fit/data.js";
import { type Samples, glancing } from "../fit/geometry.js";
import type { FitView, Held } from "../scene/fit-view.js";
import type { SceneController } from "../scene/scene-controller.js";
import type { Place } from "../state.js";
import { type Found, NEAR, find } from "../ui/pointer.js";
import { sentence } from "../text/errors.js";
import type { History } from "./history.js";
import { type Move, Preview, editOf } from "./preview.js";

// The pointer has to go so many pixels before a point is moved; less is a click, which chooses it.
const STILL = 3;

/** A press on a data point. */
interface Press {
  readonly fitView: FitView;
  readonly place: Place;
  readonly start: readonly [number, number];
}

interface Grip extends Press {
  readonly index: number;
  readonly preview: Preview;
  /** Where the point was, and what is between it and the pointer. */
  readonly plane: Plane;
  readonly offset: Vector3;
  moved: Move | null;
}

export class Drag {
  readonly #app: App;
  readonly #scene: SceneController;
  readonly #history: History;
  #grip: Grip | null = null;
  #press: Press | null = null;

  constructor(app: App, scene: SceneController, history: History) {
    this.#app = app;
    this.#scene = scene;
    this.#history = history;
    const { canvas } = scene.viewport;
    // Before the camera hears of it.
    canvas.parentElement!.addEventListener("pointerdown", (event) => event.target === canvas && this.#take(event), { capture: true });
    canvas.addEventListener("pointermove", (event) => this.#drag(event));
    canvas.addEventListener("pointerup", (event) => this.#drop(event));
    canvas.addEventListener("pointercancel", () => this.#giveUp());
    addEventListener("keydown", ({ key }) => key === "Escape" && this.#giveUp());
  }

  get isBusy(): boolean {
    return this.#grip !== null;
  }

  /** A preview of changes to one point of a fit. */
  preview(fitView: FitView): Preview {
    const { fit, data } = fitView;
    const { view, say } = this.#app;
    if (data === null) throw new Error("the data are not here");
    const samples = glancing(data.isSurface);
    const shown = (samples: Samples, held: Held) => fitView.hold(samples, held, view.value.layers);
    return new Preview(fit, data, samples, shown, (error) => say(sentence(error), "error"));
  }

  /** Makes a move last. */
  async keep(fitView: FitView, move: Move): Promise<void> {
    const { fit, data } = fitView;
    if (data === null) return;
    try {
      const parent = await fit.known();
      const job = await parent.edit(editOf(fit, data, move), { wait: 5 });
      this.#history.made(fit.id, job.id);
    } catch (error) {
      this.#app.say(sentence(error), "error");
      this.#restore(fitView);
    }
  }

  #take(event: PointerEvent): void {
    if (event.button !== 0 || !event.isPrimary || event.shiftKey) return;
    const found = this.#app.view.value.layers.data ? find(this.#scene, event.offsetX, event.offsetY, "data", event.pointerType === "touch" ? 22 : NEAR) : null;
    this.#app.view.set({ selection: null });
    if (found === null || found.fitView.data === null || found.fitView.fit.latest < 0) return;
    const { fitView, index } = found;
    this.#press = { fitView, place: placeOf(found.fitView.data, index), start: [event.offsetX, event.offsetY] };
    if (!this.#app.view.value.measuring && (this.#app.view.value.editing || event.altKey)) this.#grab(event, this.#press, found);
  }

  #grab(event: PointerEvent, press: Press, { index, position }: Found): void {
    const { fitView } = press;
    const { perspective: camera } = this.#scene.viewport.camera;
    const at = new Vector3(...position).applyMatrix4(fitView.figure.group.matrixWorld);
    const plane = new Plane().setFromNormalAndCoplanarPoint(camera.getWorldDirection(new Vector3()), at);
    const under = this.#under(event, fitView, plane);
    if (under === null) return;
    this.#scene.viewport.camera.enabled = false;
    this.#scene.viewport.canvas.setPointerCapture(event.pointerId);
    this.#grip = { ...press, index, plane, offset: at.sub(under), preview: this.preview(fitView), moved: null };
    this.#app.view.set({ playing: false });
    fitView.figure.mark(position);
    this.#scene.viewport.invalidate();
  }

  #drag(event: PointerEvent): void {
    const grip = this.#grip;
    if (grip === null || grip.fitView.data === null) return;
    if (grip.moved === null && isStill(grip, event)) return;
    const under = this.#under(event, grip.fitView, grip.plane);
    if (under === null) return;
    const { axes, positions } = grip.fitView.data;
    const { group } = grip.fitView.figure;
    const at = under.add(grip.offset).applyMatrix4(group.matrixWorld.clone().invert());
    const { exact, dimension } = grip.fitView.data;
    const notDrawn = exact.subarray(grip.index * dimension + 3, (grip.index + 1) * dimension);
    const point = [...axes.coordinates(at.x, at.y, at.z), ...(dimension > 3 ? notDrawn : [])];
    const before = new Vector3().fromArray(positions, grip.index * 3);
    if (axes.dimension === 1) at.set(before.x, ...(axes.half[2] > 0 ? [before.y, at.z] : [at.y, before.z]) as [number, number]);
    if (axes.dimension === 2) at.z = before.z;
    grip.moved = { place: grip.place, point };
    grip.preview.move(grip.moved);
    grip.fitView.figure.movePoint(grip.index, [at.x, at.y, at.z]);
    this.#scene.viewport.invalidate();
  }

  #drop(event: PointerEvent): void {
    const [grip, press] = [this.#grip, this.#press];
    this.#press = null;
    if (grip !== null) {
      this.#drag(event);
      this.#letGo(grip);
    }
    const { overlaid, jobs, measuring } = this.#app.view.value;
    const isClick = press !== null && isStill(press, event) && !measuring;
    if (grip !== null && grip.moved !== null) void this.keep(grip.fitView, grip.moved);
    else if (isClick && overlaid) {
      // Of several fits in one scene the chosen one comes first: what is beside the scene is about it.
      const { id } = press.fitView.fit;
      this.#app.view.set({ jobs: [id, ...jobs.filter((job) => job !== id)], selection: press.place });
    } else if (isClick) this.#app.view.set({ selection: this.#app.fits.shown[0] === press.fitView.fit ? press.place : null });
  }

  #giveUp(): void {
    this.#press = null;
    const grip = this.#grip;
    if (grip === null) return;
    this.#letGo(grip);
    this.#restore(grip.fitView);
  }

  #letGo(grip: Grip): void {
    this.#grip = null;
    grip.preview.end();
    grip.fitView.figure.mark(null);
    this.#scene.viewport.camera.enabled = true;
  }

  /** As if nothing had been. */
  #restore(fitView: FitView): void {
    if (fitView.data !== null) fitView.figure.setData(fitView.data);
    fitView.release();
    this.#scene.viewport.invalidate();
  }

  /** The place on a plane under the pointer. */
  #under({ offsetX, offsetY }: PointerEvent, fitView: FitView, plane: Plane): Vector3 | null {
    const cell = this.#scene.viewport.cells()[this.#scene.fitViews.indexOf(fitView)];
    if (cell === undefined) return null;
    const place = new Vector2(((offsetX - cell.x) / cell.width) * 2 - 1, 1 - ((offsetY - cell.y) / cell.height) * 2);
    const caster = new Raycaster();
    caster.setFromCamera(place, this.#scene.viewport.camera.perspective);
    return caster.ray.intersectPlane(plane, new Vector3());
  }
}

/** Returns true if the pointer is where it was pressed, but for a tremble. */
function isStill({ start: [x, y] }: Press, { offsetX, offsetY }: PointerEvent): boolean {
  return Math.hypot(offsetX - x, offsetY - y) < STILL;
}
