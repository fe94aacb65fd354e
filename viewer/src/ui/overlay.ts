/** What is drawn over the scene: the directions of the axes, a scale bar, and measured distances. */

import { Vector3 } from "three";

import type { App } from "../app.js";
import { round125 } from "../fit/comb.js";
import { byId, el } from "../html.js";
import type { SceneController } from "../scene/scene-controller.js";
import { axisName, short } from "../text/numbers.js";
import { find } from "./pointer.js";

// The longest scale bar and the axes, in pixels.
const LONGEST_BAR = 140;
const AXIS = 22;
// The pointer goes less far in a click than this, in pixels.
const STILL = 4;

type Child = readonly [name: string, attributes: Readonly<Record<string, string | number>>, text?: string];

/** One end of a measured distance. */
interface End {
  /** In the coordinates of the data. */
  readonly exact: readonly number[];
  /** In the scene. */
  readonly world: Vector3;
}

export function overlay(app: App, scene: SceneController): void {
  const root = byId("viewport");
  const picture = svg("svg", { class: "overlay", "aria-hidden": "true" });
  const said = el("output", { class: "measured", hidden: true });
  root.append(picture, said);
  let ends: readonly End[] = [];
  let drawn = "";

  const draw = () => {
    const parts = [...axes(scene), ...bar(scene, app.view.value.unit), ...line(scene, ends)];
    const now = JSON.stringify(parts);
    if (now === drawn) return;
    drawn = now;
    picture.replaceChildren(...parts.map(([name, attributes, text]) => svg(name, attributes, text)));
  };
  const show = (now: readonly End[]) => {
    ends = now;
    const text = measured(ends, app.view.value.unit);
    said.hidden = text === "";
    said.textContent = text;
    draw();
  };
  const { canvas } = scene.viewport;
  let start: readonly [number, number] | null = null;
  canvas.addEventListener("pointerdown", ({ offsetX, offsetY }) => (start = [offsetX, offsetY]));
  canvas.addEventListener("pointerup", ({ offsetX, offsetY, pointerType }) => {
    if (!app.view.value.measuring || start === null || Math.hypot(offsetX - start[0], offsetY - start[1]) > STILL) return;
    const found = find(scene, offsetX, offsetY, undefined, pointerType === "touch" ? 24 : undefined);
    if (found === null) return app.say("There is no point here: click a data point or the fit.");
    const { fitView, what, index, position } = found;
    const { exact, dimension } = what === "data" ? fitView.data! : fitView.shown!.samples;
    const end = { exact: Array.from(exact.subarray(index * dimension, (index + 1) * dimension)), world: new Vector3(...position).applyMatrix4(fitView.figure.group.matrixWorld) };
    show(ends.length === 1 ? [...ends, end] : [end]);
  });
  app.view.subscribe((now, before) => {
    if (now.jobs !== before.jobs || now.measuring !== before.measuring) show([]);
    if (now.unit !== before.unit) show(ends);
    root.classList.toggle("measures", now.measuring);
    if (now.measuring && !before.measuring) app.say("Click two points, of the data or of the fit.");
  });
  addEventListener("keydown", ({ key }) => key === "Escape" && app.view.set({ measuring: false }));
  scene.viewport.onDraw(draw);
  draw();
}

/** The distance between two ends, and its parts. */
function measured([a, b]: readonly End[], unit: string): string {
  if (a === undefined) return "";
  const dimension = a.exact.length;
  if (b === undefined) return `From ${a.exact.map((value, axis) => `${axisName(axis, dimension)} ${short(value, 5)}`).join(", ")}: click the other end`;
  const parts = a.exact.map((value, axis) => (b.exact[axis] ?? NaN) - value);
  const each = parts.map((value, axis) => `Δ${axisName(axis, dimension)} ${short(value, 4)}`).join(", ");
  return `Distance ${`${short(Math.hypot(...parts), 5)} ${unit}`.trim()} (${each})`;
}

/** The directions of the axes, in the lower right corner. */
function axes({ viewport, box, fitViews }: SceneController): Child[] {
  const dimension = fitViews[0]?.data?.dimension ?? 3;
  if (box === null || dimension === 1) return [];
  const { width, height } = size(viewport);
  const [x, y] = [width - 46, height - 52];
  const { perspective, isFlat } = viewport.camera;
  perspective.updateMatrixWorld();
  return [0, 1, 2].slice(0, isFlat ? 2 : 3).flatMap((axis) => {
    const way = new Vector3().setComponent(axis, 1).transformDirection(perspective.matrixWorldInverse);
    const [dx, dy] = [way.x * AXIS, -way.y * AXIS];
    return [
      ["line", { x1: x, y1: y, x2: round(x + dx), y2: round(y + dy) }],
      ["text", { x: round(x + dx * 1.45), y: round(y + dy * 1.45 + 4), "text-anchor": "middle" }, axisName(axis, dimension)],
    ] as Child[];
  });
}

/** How long a round number is, at the point that is looked at. */
function bar({ viewport, box, fitViews }: SceneController, unit: string): Child[] {
  const cell = viewport.cells()[0];
  if (box === null || cell === undefined || (fitViews[0]?.data?.dimension ?? 2) === 1) return [];
  const pixel = viewport.camera.pixel(cell.height) * box.radius;
  const length = round125(LONGEST_BAR * pixel);
  const pixels = length / pixel;
  if (!(pixels > 10)) return [];
  const { width, height } = size(viewport);
  const [right, y] = [width - 16, height - 14];
  return [
    ["path", { d: `M${round(right - pixels)} ${y - 4}v4H${right}v-4`, class: "bar" }],
    ["text", { x: round(right - pixels - 6), y, "text-anchor": "end" }, `${short(length)} ${unit}`.trim()],
  ];
}

/** The line between two ends, as it is seen. */
function line({ viewport }: SceneController, ends: readonly End[]): Child[] {
  const cell = viewport.cells()[0];
  if (cell === undefined || ends.length === 0) return [];
  const places = ends.map(({ world }) => {
    const { x, y } = world.clone().project(viewport.camera.perspective);
    return [round(cell.x + ((x + 1) / 2) * cell.width), round(cell.y + ((1 - y) / 2) * cell.height)] as const;
  });
  const [a, b] = places;
  const dots = places.map(([cx, cy]): Child => ["circle", { cx, cy, r: 4 }]);
  return b === undefined ? dots : [["line", { x1: a![0], y1: a![1], x2: b[0], y2: b[1], class: "distance" }], ...dots];
}

function size({ canvas }: SceneController["viewport"]): { width: number; height: number } {
  return { width: canvas.clientWidth, height: canvas.clientHeight };
}

function round(value: number): number {
  return Math.round(value * 10) / 10;
}

function svg(name: string, attributes: Readonly<Record<string, string | number>>, text = ""): SVGElement {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, String(value));
  if (text !== "") element.textContent = text;
  return element;
}
