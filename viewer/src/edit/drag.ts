/** A data point that is dragged in the Edit mode, and the fit that follows; a click chooses one in either mode. */

import { Plane, Raycaster, Vector2, Vector3 } from "three";

import type { App } from "../app.js";
import { placeOf } from "../fit/data.js";
import { type Samples, glancing } from "../fit/geometry.js";
import type { Exhibit, Held } from "../scene/exhibit.js";
import type { Hall } from "../scene/hall.js";
import type { Place } from "../state.js";
import { type Found, NEAR, find } from "../ui/pointer.js";
import { sentence } from "../text/errors.js";
import type { History } from "./history.js";
import { type Move, Preview, editOf } from "./preview.js";

// The pointer has to go so many pixels before a point is moved; less is a click, which chooses it.
const STILL = 3;

/** A press on a data point. */
interface Press {
  readonly exhibit: Exhibit;
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
  readonly #hall: Hall;
  readonly #history: History;
  #grip: Grip | null = null;
  #press: Press | null = null;

  constructor(app: App, hall: Hall, history: History) {
    this.#app = app;
    this.#hall = hall;
    this.#history = history;
    const { canvas } = hall.stage;
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

  /** A preview of changes to one point of an exhibit. */
  preview(exhibit: Exhibit): Preview {
    const { fit, data } = exhibit;
    const { view, say } = this.#app;
    if (data === null) throw new Error("the data are not here");
    const samples = glancing(data.isSurface);
    const shown = (samples: Samples, held: Held) => exhibit.hold(samples, held, view.value.layers);
    return new Preview(fit, data, samples, shown, (error) => say(sentence(error), "error"));
  }

  /** Makes a move last. */
  async keep(exhibit: Exhibit, move: Move): Promise<void> {
    const { fit, data } = exhibit;
    if (data === null) return;
    try {
      const parent = await fit.known();
      const job = await parent.edit(editOf(fit, data, move), { wait: 5 });
      this.#history.made(fit.id, job.id);
    } catch (error) {
      this.#app.say(sentence(error), "error");
      this.#restore(exhibit);
    }
  }

  #take(event: PointerEvent): void {
    if (event.button !== 0 || !event.isPrimary || event.shiftKey) return;
    const found = this.#app.view.value.layers.data ? find(this.#hall, event.offsetX, event.offsetY, "data", event.pointerType === "touch" ? 22 : NEAR) : null;
    this.#app.view.set({ selection: null });
    if (found === null || found.exhibit.data === null || found.exhibit.fit.latest < 0) return;
    const { exhibit, index } = found;
    this.#press = { exhibit, place: placeOf(found.exhibit.data, index), start: [event.offsetX, event.offsetY] };
    if (this.#app.view.value.editing || event.altKey) this.#grab(event, this.#press, found);
  }

  #grab(event: PointerEvent, press: Press, { index, position }: Found): void {
    const { exhibit } = press;
    const { camera } = this.#hall.stage.rig;
    const at = new Vector3(...position).applyMatrix4(exhibit.figure.group.matrixWorld);
    const plane = new Plane().setFromNormalAndCoplanarPoint(camera.getWorldDirection(new Vector3()), at);
    const under = this.#under(event, exhibit, plane);
    if (under === null) return;
    this.#hall.stage.rig.enabled = false;
    this.#hall.stage.canvas.setPointerCapture(event.pointerId);
    this.#grip = { ...press, index, plane, offset: at.sub(under), preview: this.preview(exhibit), moved: null };
    this.#app.view.set({ playing: false });
    exhibit.figure.mark(position);
    this.#hall.stage.invalidate();
  }

  #drag(event: PointerEvent): void {
    const grip = this.#grip;
    if (grip === null || grip.exhibit.data === null) return;
    if (grip.moved === null && isStill(grip, event)) return;
    const under = this.#under(event, grip.exhibit, grip.plane);
    if (under === null) return;
    const { axes, positions } = grip.exhibit.data;
    const { group } = grip.exhibit.figure;
    const at = under.add(grip.offset).applyMatrix4(group.matrixWorld.clone().invert());
    const { exact, dimension } = grip.exhibit.data;
    const notDrawn = exact.subarray(grip.index * dimension + 3, (grip.index + 1) * dimension);
    const point = [...axes.coordinates(at.x, at.y, at.z), ...(dimension > 3 ? notDrawn : [])];
    const before = new Vector3().fromArray(positions, grip.index * 3);
    if (axes.dimension === 1) at.set(before.x, ...(axes.half[2] > 0 ? [before.y, at.z] : [at.y, before.z]) as [number, number]);
    if (axes.dimension === 2) at.z = before.z;
    grip.moved = { place: grip.place, point };
    grip.preview.move(grip.moved);
    grip.exhibit.figure.movePoint(grip.index, [at.x, at.y, at.z]);
    this.#hall.stage.invalidate();
  }

  #drop(event: PointerEvent): void {
    const [grip, press] = [this.#grip, this.#press];
    this.#press = null;
    if (grip !== null) {
      this.#drag(event);
      this.#letGo(grip);
    }
    if (grip !== null && grip.moved !== null) void this.keep(grip.exhibit, grip.moved);
    else if (press !== null && isStill(press, event)) this.#app.view.set({ selection: this.#app.fits.shown[0] === press.exhibit.fit ? press.place : null });
  }

  #giveUp(): void {
    this.#press = null;
    const grip = this.#grip;
    if (grip === null) return;
    this.#letGo(grip);
    this.#restore(grip.exhibit);
  }

  #letGo(grip: Grip): void {
    this.#grip = null;
    grip.preview.end();
    grip.exhibit.figure.mark(null);
    this.#hall.stage.rig.enabled = true;
  }

  /** As if nothing had been. */
  #restore(exhibit: Exhibit): void {
    if (exhibit.data !== null) exhibit.figure.setData(exhibit.data);
    exhibit.release();
    this.#hall.stage.invalidate();
  }

  /** The place on a plane under the pointer. */
  #under({ offsetX, offsetY }: PointerEvent, exhibit: Exhibit, plane: Plane): Vector3 | null {
    const cell = this.#hall.stage.cells()[this.#hall.exhibits.indexOf(exhibit)];
    if (cell === undefined) return null;
    const place = new Vector2(((offsetX - cell.x) / cell.width) * 2 - 1, 1 - ((offsetY - cell.y) / cell.height) * 2);
    const caster = new Raycaster();
    caster.setFromCamera(place, this.#hall.stage.rig.camera);
    return caster.ray.intersectPlane(plane, new Vector3());
  }
}

/** Returns true if the pointer is where it was pressed, but for a tremble. */
function isStill({ start: [x, y] }: Press, { offsetX, offsetY }: PointerEvent): boolean {
  return Math.hypot(offsetX - x, offsetY - y) < STILL;
}
