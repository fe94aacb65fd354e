/** The camera, and how it is moved. */

import { MOUSE, PerspectiveCamera, TOUCH, Vector3 } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

import type { Box } from "../fit/axes.js";
import type { Data } from "../fit/data.js";

// Degrees; a long lens keeps shapes as they are.
const LENS = 26;
// How much room is left around the data.
const MARGIN = 1.07;
// How many points tell where the data are.
const ENOUGH = 1500;
const FROM = new Vector3(-0.62, -1.0, 0.62).normalize();

/** Everything is in units of the radius of the data, around its centre. */
export class Camera {
  readonly perspective = new PerspectiveCamera(LENS, 1, 0.01, 100);
  readonly #controls: OrbitControls;
  readonly #changed: () => void;
  #half: Box["half"] = [1, 1, 1];
  #seen: Vector3[] = [];
  #shape = "";
  #room = 1;
  #isFlat = false;
  #whole = 1;

  constructor(canvas: HTMLElement, changed: () => void) {
    this.#changed = changed;
    this.perspective.up.set(0, 0, 1);
    this.#controls = new OrbitControls(this.perspective, canvas);
    this.#controls.enableDamping = false;
    this.#controls.zoomToCursor = true;
    this.#controls.minDistance = 1e-3;
    this.#controls.maxDistance = 60;
    this.#controls.addEventListener("change", changed);
    // A swipe that scrolls the page leaves the camera as it was before.
    canvas.addEventListener("pointerdown", ({ isPrimary }) => isPrimary && this.#controls.saveState());
    canvas.addEventListener("pointercancel", () => this.#controls.reset());
  }

  /** How long a pixel is at the point that is looked at, in radii of the data, on a viewport of this height. */
  pixel(height: number): number {
    return (2 * Math.tan((LENS * Math.PI) / 360) * this.#controls.getDistance()) / height;
  }

  /** True if everything lies in a plane, which is looked at from the front. */
  get isFlat(): boolean {
    return this.#isFlat;
  }

  /** How much nearer than at the beginning; 1 is the whole. */
  get zoom(): number {
    return this.#whole / this.#controls.getDistance();
  }

  set enabled(on: boolean) {
    this.#controls.enabled = on;
  }

  /** Looks at all of the data. */
  look(all: readonly Data[], { half, radius, centre }: Box): void {
    this.#half = half.map((length) => length / radius) as unknown as Box["half"];
    this.#seen = [];
    for (const { positions, axes: { origin } } of all) {
      const every = Math.max(1, Math.floor((positions.length / 3 / ENOUGH) * all.length)) * 3;
      for (let i = 0; i < positions.length; i += every) {
        const place = [0, 1, 2].map((axis) => (positions[i + axis]! + origin[axis]! - centre[axis]!) / radius) as [number, number, number];
        if (place.every(Number.isFinite)) this.#seen.push(new Vector3(...place));
      }
    }
    this.#isFlat = half[2] === 0;
    this.reset();
  }

  reset(): void {
    const { perspective: camera } = this;
    const controls = this.#controls;
    controls.enableRotate = !this.#isFlat;
    controls.mouseButtons.LEFT = this.#isFlat ? MOUSE.PAN : MOUSE.ROTATE;
    controls.touches.ONE = this.#isFlat ? TOUCH.PAN : TOUCH.ROTATE;
    camera.up.set(0, this.#isFlat ? 1 : 0, this.#isFlat ? 0 : 1);
    this.#whole = this.#distance();
    controls.target.set(0, 0, 0);
    camera.position.copy(this.#isFlat ? new Vector3(0, 0, 1) : FROM).multiplyScalar(this.#whole);
    controls.update();
    this.#changed();
  }

  /** Turns or shifts by parts of the screen, and comes nearer by a factor: for keys. */
  move(right: number, up: number, nearer: number): void {
    const { perspective: camera } = this;
    const { target } = this.#controls;
    const arm = camera.position.clone().sub(target);
    if (this.#isFlat) {
      const step = new Vector3(right, up, 0).multiplyScalar(arm.length() * 0.3);
      target.add(step);
    } else {
      arm.applyAxisAngle(camera.up, right);
      const side = new Vector3().crossVectors(camera.up, arm).normalize();
      const tilt = arm.clone().applyAxisAngle(side, -up);
      if (Math.abs(tilt.clone().normalize().dot(camera.up)) < 0.995) arm.copy(tilt);
    }
    camera.position.copy(target).add(arm.divideScalar(nearer));
    this.#controls.update();
    this.#changed();
  }

  /** So many pixels from above are for what is written. */
  setShape(width: number, height: number, above: number): void {
    const key = `${width} ${height} ${above}`;
    if (key === this.#shape) return;
    this.#shape = key;
    const aspect = width / height;
    this.#room = Math.max(0.4, 1 - above / height);
    this.perspective.aspect = aspect;
    this.perspective.setViewOffset(width, height, 0, -above / 2, width, height);
    const old = this.#whole;
    this.#whole = this.#distance();
    const { target } = this.#controls;
    this.perspective.position.sub(target).multiplyScalar(this.#whole / old).add(target);
    this.#controls.update();
  }

  /** From where everything is seen. */
  #distance(): number {
    const slope = Math.tan((LENS * Math.PI) / 360);
    const [x, y, z] = this.#half;
    if (this.#isFlat) return (Math.max(y / this.#room, x / this.perspective.aspect, 1e-3) / slope) * MARGIN * 1.09;
    // Each point is to be seen, or each corner of the box.
    const side = new Vector3().crossVectors(new Vector3(0, 0, 1), FROM).normalize();
    const up = new Vector3().crossVectors(FROM, side);
    const corners = [-1, 1].flatMap((i) => [-1, 1].flatMap((j) => [-1, 1].map((k) => new Vector3(i * x, j * y, k * z))));
    const seen = this.#seen.length > 0 ? this.#seen : corners;
    const needed = seen.map((corner) => Math.max(Math.abs(corner.dot(up)) / this.#room, Math.abs(corner.dot(side)) / this.perspective.aspect) / slope + corner.dot(FROM));
    return Math.max(...needed) * MARGIN;
  }
}
