/** One fit as it is drawn. */

import { type Object3D, Group, Scene } from "three";

import { type Data, among, drawnIndexOf, drawnOf } from "../fit/data.js";
import type { Points, Samples } from "../fit/geometry.js";
import type { Outline } from "../fit/outline.js";
import type { Layers } from "../state.js";
import { type Cuts, cutAt } from "./cut.js";
import { Dots } from "./dots.js";
import { FatLine } from "./fatline.js";
import { Transition } from "./transition.js";
import { Net } from "./net.js";
import { HEAT, type Palette, seriesColor } from "./palette.js";
import { Surface } from "./surface.js";

/** Everything that is drawn of an iteration. */
export interface Frame {
  readonly samples: Samples;
  /** Where a trimmed surface ends; null if all of it is drawn. */
  readonly outline: Outline | null;
  /** Too far from the data to be seen: a surface is not drawn then. */
  readonly isAway: boolean;
  readonly control: Points | null;
  /** Pairs of points: from the fit at the parameter of a data point to that, enlarged. */
  readonly spikes: Float32Array | null;
  /** Pairs of points: parts of the curve that leave the data between neighbours. */
  readonly astray: Float32Array | null;
  /** Pairs of points, from the curve outwards, and the line through their ends. */
  readonly comb: { readonly teeth: Float32Array; readonly edge: Float32Array } | null;
  /** Colours of the samples, from 0 to 1. */
  readonly heat: Float32Array | null;
  /** Where the fit is at the points that a grid has not. */
  readonly gaps: Float32Array | null;
}

export class Figure {
  readonly scene = new Scene();
  frame: Frame | null = null;
  /** What is drawn of the samples of a trimmed surface; null for all. */
  cut: Cuts | null = null;
  readonly #group = new Group();
  readonly #curve = new FatLine(3, 2e-5);
  readonly #heat = Array.from({ length: HEAT }, () => new FatLine(4, 2.2e-5));
  readonly #astray = new FatLine(5, 2.5e-5);
  readonly #surface = new Surface();
  readonly #boundary = new FatLine(1.5, 2e-5);
  readonly #data = new Dots(6e-5);
  readonly #gaps = new Dots(6e-5);
  readonly #outliers = new Dots(7e-5);
  readonly #polygon = new FatLine(1.25, 1e-5);
  readonly #net = new Net();
  readonly #control = new Dots(4e-5);
  readonly #spikes = new FatLine(1.75, 3e-5);
  readonly #teeth = new FatLine(1, 0);
  readonly #edge = new FatLine(1.25, 0);
  readonly #marker = new Dots(9e-5);
  readonly #transition = new Transition();
  readonly #controlTransition = new Transition();
  #crowd = 0;
  #lined: readonly unknown[] = [];
  #source: Data | null = null;
  #ownData: Float32Array | null = null;

  constructor() {
    // What comes later lies over what came before, where both are at the same depth.
    const order: Object3D[] = [this.#surface, this.#boundary, this.#teeth, this.#edge, this.#net, this.#polygon, this.#spikes, this.#curve, ...this.#heat, this.#astray, this.#control, this.#gaps, this.#data, this.#outliers, this.#marker];
    order.forEach((object, i) => {
      object.renderOrder = i;
      object.visible = false;
      this.#group.add(object);
    });
    this.#marker.material.depthTest = false;
    this.scene.add(this.#group);
  }

  /** Where scene coordinates are: the data in a box of radius one. */
  get group(): Group {
    return this.#group;
  }

  /** Whether a surface is drawn. */
  get isSurface(): boolean {
    return this.#surface.visible;
  }

  /** Whether it has stripes, which only a shader draws. */
  get isStriped(): boolean {
    return this.#surface.isStriped;
  }

  setData(data: Data): void {
    const { axes } = data;
    this.#source = data;
    this.setPlace(axes);
    this.#crowd = data.positions.length / 3;
    this.#outliers.setPoints(Float32Array.from(data.outliers.flatMap((i) => Array.from(data.positions.subarray(i * 3, i * 3 + 3)))));
    this.#ownData = drawnOf(data);
    this.#data.setPoints(this.#ownData);
    this.#lined = [];
  }

  /** Makes the box around some data the one of radius one: its own, or that around all data in the scene. */
  setPlace({ centre, radius }: Pick<Data["axes"], "centre" | "radius">): void {
    const origin = this.#source?.axes.origin ?? [0, 0, 0];
    this.#group.scale.setScalar(1 / radius);
    const [x, y, z] = centre.map((c, i) => -(c - (origin[i] ?? 0)) / radius) as [number, number, number];
    this.#group.position.set(x, y, z);
  }

  /** Shows a data point elsewhere, as long as the data are not set again. */
  movePoint(index: number, point: readonly [number, number, number]): void {
    // Where not all are drawn, the mark stands for those that are not.
    const at = this.#source === null ? -1 : drawnIndexOf(this.#source, index);
    if (this.#ownData !== null && at >= 0) {
      this.#ownData.set(point, at * 3);
      this.#data.setPoints(this.#ownData);
    }
    this.mark(point);
  }

  /** Shows an iteration, and takes so many milliseconds to get there from the one before. */
  setFrame(frame: Frame, lasts: number, now: number): void {
    this.frame = frame;
    const { samples, control, outline } = frame;
    this.cut = outline === null ? null : cutAt(outline, samples);
    this.#transition.go(samples.positions, lasts, now);
    if (control !== null) this.#controlTransition.go(control.positions, lasts, now);
    if (frame.spikes !== null) this.#spikes.setSegments(frame.spikes);
    if (frame.astray !== null) this.#astray.setSegments(frame.astray);
    if (frame.comb !== null) {
      this.#teeth.setSegments(frame.comb.teeth);
      this.#edge.setPoints(frame.comb.edge);
    }
    if (frame.gaps !== null) this.#gaps.setPoints(frame.gaps);
    if (samples.rows === 1) this.setHeat(frame.heat);
    this.#place();
    if (samples.rows > 1) {
      this.#surface.setHeat(frame.heat);
      this.#lines(samples);
    }
  }

  /** Colours the samples, from 0 (near) to 1; null for none. */
  setHeat(heat: Float32Array | null): void {
    const { frame } = this;
    if (frame === null) return;
    this.frame = { ...frame, heat };
    if (frame.samples.rows > 1) return this.#surface.setHeat(heat);
    if (heat === null) return;
    const { positions } = frame.samples;
    const parts = this.#heat.map(() => [] as number[]);
    for (let i = 0; i + 1 < heat.length; i++) parts[Math.min(HEAT - 1, Math.round(((heat[i]! + heat[i + 1]!) / 2) * (HEAT - 1)))]!.push(i);
    this.#heat.forEach((line, level) => {
      const segments = new Float32Array(parts[level]!.length * 6);
      parts[level]!.forEach((i, at) => segments.set(positions.subarray(i * 3, i * 3 + 6), at * 6));
      line.setSegments(segments);
    });
  }

  /** Goes on to the newest frame; true while there is a way to go. */
  step(now: number): boolean {
    if (!this.#transition.moves && !this.#controlTransition.moves) return false;
    this.#transition.step(now);
    this.#controlTransition.step(now);
    this.#place();
    return true;
  }

  /** A point that is looked at, in scene coordinates. */
  mark(point: readonly [number, number, number] | null): void {
    this.#marker.visible = point !== null;
    if (point !== null) this.#marker.setPoints(Float32Array.from(point));
  }

  setLayers(layers: Layers): void {
    const { frame } = this;
    const isSurface = (frame?.samples.rows ?? 1) > 1;
    this.#curve.visible = frame !== null && !isSurface && frame.heat === null;
    for (const line of this.#heat) line.visible = frame !== null && !isSurface && frame.heat !== null;
    this.#outliers.visible = layers.data && (this.#source?.outliers.length ?? 0) > 0;
    this.#gaps.visible = layers.data && frame?.gaps != null;
    this.#astray.visible = frame?.astray != null;
    this.#surface.visible = frame !== null && isSurface && !frame.isAway;
    this.#boundary.visible = this.#surface.visible && this.cut !== null;
    this.#surface.setZebra(layers.zebra);
    this.#data.visible = layers.data;
    const controlled = layers.polygon && frame?.control != null;
    this.#polygon.visible = controlled && !isSurface;
    this.#net.visible = controlled && isSurface;
    this.#control.visible = controlled;
    this.#spikes.visible = layers.spikes && frame?.spikes != null;
    this.#teeth.visible = this.#edge.visible = layers.comb && frame?.comb != null;
  }

  setColors(palette: Palette, index: number, crowd: number): void {
    const { color } = palette;
    const own = seriesColor(color, crowd > 1 ? index : 0);
    this.#surface.setColors(palette);
    this.#curve.setColor(own);
    this.#boundary.setColor(palette.color.soft);
    this.#polygon.setColor(color.net, 0.75);
    this.#net.setColor(color.net, 0.65);
    this.#spikes.setColor(palette.heat[3] ?? color.accent);
    this.#astray.setColor(palette.heat[4] ?? color.accent);
    this.#heat.forEach((line, i) => line.setColor(palette.heat[i] ?? color.accent));
    this.#teeth.setColor(own, 0.28);
    this.#edge.setColor(own, 0.55);
  }

  setSize(width: number, height: number, ratio: number, palette: Palette): void {
    const slim = Math.min(width, height) < 420 ? 0.85 : 1;
    this.#curve.setSize(width, height, ratio, 3.25 * slim);
    this.#astray.setSize(width, height, ratio, 4.5 * slim);
    for (const line of this.#heat) line.setSize(width, height, ratio, 4 * slim);
    this.#polygon.setSize(width, height, ratio, 1.25);
    this.#boundary.setSize(width, height, ratio, 1.5);
    this.#spikes.setSize(width, height, ratio, 1.75);
    this.#teeth.setSize(width, height, ratio, 1);
    this.#edge.setSize(width, height, ratio, 1.25);
    const { color } = palette;
    const dot = (this.#crowd > 20_000 ? 1.5 : this.#crowd > 2000 ? 2.5 : this.#crowd > 500 ? 4 : 6.5) * slim;
    this.#data.setLook(color.ink, color.paper, dot * ratio, dot > 4 ? 1.1 * ratio : 0, dot < 4 ? 0.7 : 1);
    this.#gaps.setLook(color.paper, color.soft, 4.5 * ratio, 1 * ratio);
    this.#outliers.setLook(color.paper, palette.heat[4] ?? color.accent, 10 * ratio, 2.5 * ratio);
    this.#control.setLook(color.paper, color.net, 5.5 * ratio, 1.25 * ratio);
    this.#marker.setLook(color.paper, color.accent, 15 * ratio, 4 * ratio);
  }

  dispose(): void {
    this.#group.traverse((object) => {
      const { geometry, material } = object as Partial<FatLine>;
      geometry?.dispose();
      material?.dispose();
    });
  }

  /** The rows and columns of the data on the surface. */
  #lines({ parameters, rows, columns }: Samples): void {
    const key = [rows, columns, this.cut];
    if (key.every((part, i) => part === this.#lined[i])) return;
    this.#lined = key;
    const data = this.#source;
    const [us, vs] = parameters;
    if (data === null || data.isScattered || vs === undefined) return this.#surface.setLines(null);
    const line = (samples: Float64Array, own: Float64Array) => Float32Array.from(samples, (t) => among(own, t, samples.at(-1)!));
    this.#surface.setLines([line(us, data.parameters[0]!), line(vs, data.parameters[1]!)]);
  }

  /** Puts the shown numbers into the buffers. */
  #place(): void {
    const { frame } = this;
    if (frame === null) return;
    const { samples, control } = frame;
    if (samples.rows > 1) {
      this.#surface.setSamples(this.#transition.shown, samples.rows, samples.columns, this.cut);
      if (this.cut !== null) this.#boundary.setSegments(this.#surface.boundary());
    } else this.#curve.setPoints(this.#transition.shown);
    if (control === null) return;
    const { shown } = this.#controlTransition;
    this.#control.setPoints(shown);
    if (control.rows === 1) return this.#polygon.setPoints(shown);
    this.#net.setPoints(shown, control.rows, control.columns);
  }
}
