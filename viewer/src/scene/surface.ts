/** A surface: porcelain, distances as colours, or zebra stripes. */

import { BufferAttribute, BufferGeometry, Color, Mesh, ShaderMaterial } from "three";

import { type Cuts, edgesOf, valuesAt } from "./cut.js";
import { HEAT, type Palette } from "./palette.js";
import { closedOf, indicesOf, normalsOf } from "./grid.js";

const VERTEX = /* glsl */ `
  attribute float heat;
  attribute vec2 grid;
  varying vec3 vNormal;
  varying vec3 vEye;
  varying float vHeat;
  varying vec2 vGrid;
  void main() {
    vec4 eye = modelViewMatrix * vec4(position, 1.0);
    vNormal = normalMatrix * normal;
    vEye = -eye.xyz;
    vHeat = heat;
    vGrid = grid;
    gl_Position = projectionMatrix * eye;
  }
`;

const FRAGMENT = /* glsl */ `
  uniform vec3 lit;
  uniform vec3 shade;
  uniform vec3 deep;
  uniform vec3 ink;
  uniform vec3 ramp[${HEAT}];
  uniform float hot;
  uniform float zebra;
  uniform float dark;
  uniform float lined;
  varying vec3 vNormal;
  varying vec3 vEye;
  varying float vHeat;
  varying vec2 vGrid;

  vec3 scale(float t) {
    float x = clamp(t, 0.0, 1.0) * ${(HEAT - 1).toFixed(1)};
    vec3 color = ramp[0];
    for (int i = 1; i < ${HEAT}; i++) color = mix(color, ramp[i], clamp(x - float(i - 1), 0.0, 1.0));
    return color;
  }

  void main() {
    vec3 eye = normalize(vEye);
    vec3 n = normalize(vNormal);
    // Where the surface turns away, single pixels are of triangles behind it.
    float back = gl_FrontFacing || dot(n, eye) > -0.15 ? 0.0 : 1.0;
    if (back > 0.5) n = -n;
    float key = dot(n, normalize(vec3(-0.42, 0.72, 0.55))) * 0.5 + 0.5;
    float fill = dot(n, normalize(vec3(0.8, -0.1, 0.35))) * 0.5 + 0.5;
    float facing = max(dot(n, eye), 0.0);
    float tone = smoothstep(0.12, 0.96, key * 0.86 + fill * 0.14);
    vec3 body = tone < 0.5 ? mix(deep, shade, tone * 2.0) : mix(shade, lit, tone * 2.0 - 1.0);
    body = mix(body, mix(deep, shade, tone), back * 0.55);
    if (hot > 0.5) body = scale(vHeat) * mix(0.72, 1.08, tone);
    if (zebra > 0.5) {
      vec3 r = reflect(-eye, n);
      float s = sin(atan(r.y, length(r.xz) * sign(r.z + 1e-4)) * 15.0);
      float w = fwidth(s) * 0.9 + 1e-4;
      body = mix(body * 0.16, mix(lit, vec3(1.0), 0.4), smoothstep(-w, w, s));
    }
    vec3 h = normalize(normalize(vec3(-0.42, 0.72, 0.55)) + eye);
    body += (1.0 - 0.6 * hot) * (1.0 - zebra) * mix(0.16, 0.10, dark) * pow(max(dot(n, h), 0.0), 42.0);
    float rim = pow(1.0 - facing, 3.0);
    body = mix(body, mix(vec3(1.0), lit, 0.5), rim * mix(0.0, 0.28, dark) * (1.0 - hot));
    body *= 1.0 - rim * mix(0.16, 0.0, dark);
    vec2 w = fwidth(vGrid);
    vec2 d = abs(fract(vGrid - 0.5) - 0.5) / max(w, vec2(1e-5));
    vec2 lines = (1.0 - smoothstep(vec2(0.2), vec2(1.3), d)) * (1.0 - smoothstep(vec2(0.12), vec2(0.4), w));
    float line = max(lines.x, lines.y) * lined;
    body = mix(body, ink, line * 0.13 * (1.0 - 0.7 * zebra));
    gl_FragColor = vec4(body, 1.0);
  }
`;

/** A surface in samples. The array of the positions is the vertex buffer, unless the surface is cut. */
export class Surface extends Mesh<BufferGeometry, ShaderMaterial> {
  #rows = 0;
  #columns = 0;
  #cut: Cuts | null = null;

  get rows(): number {
    return this.#rows;
  }

  get columns(): number {
    return this.#columns;
  }

  /** What is drawn of it; null for all. */
  get cut(): Cuts | null {
    return this.#cut;
  }

  constructor() {
    const uniforms = {
      lit: { value: new Color() },
      shade: { value: new Color() },
      deep: { value: new Color() },
      ink: { value: new Color() },
      ramp: { value: Array.from({ length: HEAT }, () => new Color()) },
      hot: { value: 0 },
      zebra: { value: 0 },
      dark: { value: 0 },
      lined: { value: 0 },
    };
    const material = new ShaderMaterial({
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      uniforms,
      side: 2,
      polygonOffset: true,
      polygonOffsetFactor: 1,
      polygonOffsetUnits: 1,
    });
    super(new BufferGeometry(), material);
    this.frustumCulled = false;
  }

  setSamples(samples: Float32Array, rows: number, columns: number, cut: Cuts | null): void {
    const { geometry } = this;
    const same = rows === this.#rows && columns === this.#columns && cut === this.#cut;
    const count = rows * columns + (cut?.places.length ?? 0) / 2;
    if (!same) {
      [this.#rows, this.#columns, this.#cut] = [rows, columns, cut];
      geometry.dispose();
      geometry.setIndex(new BufferAttribute(cut?.indices ?? indicesOf(rows, columns), 1));
      geometry.setAttribute("heat", new BufferAttribute(new Float32Array(count), 1));
      geometry.setAttribute("normal", new BufferAttribute(new Float32Array(count * 3), 3));
      geometry.setAttribute("grid", new BufferAttribute(new Float32Array(count * 2), 2));
    }
    const old = geometry.getAttribute("position") as BufferAttribute | undefined;
    // Of a surface that is cut the buffer also has the vertices of the outline.
    const positions = cut === null ? samples : same && old !== undefined ? (old.array as Float32Array) : new Float32Array(count * 3);
    if (positions !== samples) positions.set(samples);
    this.#spread(positions, 3);
    if (old?.array === positions) old.needsUpdate = true;
    else geometry.setAttribute("position", new BufferAttribute(positions, 3));
    const normal = geometry.getAttribute("normal") as BufferAttribute;
    normalsOf(samples, rows, columns, normal.array as Float32Array);
    this.#spread(normal.array as Float32Array, 3);
    normal.needsUpdate = true;
  }

  /** Pairs of points: the edges of the outline along which it is cut, which are not those of a seam. */
  boundary(): Float32Array {
    const array = this.geometry.getAttribute("position").array as Float32Array;
    const vertices = this.#cut === null ? [] : edgesOf(this.#cut, closedOf(array.subarray(0, this.#rows * this.#columns * 3), this.#rows, this.#columns), this.#rows, this.#columns);
    const segments = new Float32Array(vertices.length * 3);
    vertices.forEach((vertex, at) => segments.set(array.subarray(vertex * 3, vertex * 3 + 3), at * 3));
    return segments;
  }

  /** Where each row and column of samples is among the rows and columns of data, which are seen as lines; null for none. */
  setLines(lines: readonly [Float32Array, Float32Array] | null): void {
    this.material.uniforms["lined"]!.value = lines === null ? 0 : 1;
    const [rows, columns] = [this.#rows, this.#columns];
    if (lines === null || lines[0].length !== rows || lines[1].length !== columns) return;
    const grid = new Float32Array(this.geometry.getAttribute("grid").array.length);
    for (let i = 0, at = 0; i < rows; i++) {
      for (let j = 0; j < columns; j++, at += 2) {
        grid[at] = lines[0][i]!;
        grid[at + 1] = lines[1][j]!;
      }
    }
    this.#spread(grid, 2);
    this.geometry.setAttribute("grid", new BufferAttribute(grid, 2));
  }

  /** From 0 (near) to 1 for each sample; null for none. */
  setHeat(heat: Float32Array | null): void {
    this.material.uniforms["hot"]!.value = heat === null ? 0 : 1;
    if (heat === null) return;
    const attribute = this.geometry.getAttribute("heat") as BufferAttribute;
    if (this.#rows * this.#columns !== heat.length) return;
    attribute.array.set(heat);
    this.#spread(attribute.array as Float32Array, 1);
    attribute.needsUpdate = true;
  }

  get isStriped(): boolean {
    return this.material.uniforms["zebra"]!.value === 1;
  }

  setZebra(on: boolean): void {
    this.material.uniforms["zebra"]!.value = on ? 1 : 0;
  }

  setColors({ color, heat, isDark }: Palette): void {
    const { uniforms } = this.material;
    (uniforms["lit"]!.value as Color).copy(color.light);
    (uniforms["shade"]!.value as Color).copy(color.shade);
    (uniforms["deep"]!.value as Color).copy(color.deep);
    (uniforms["ink"]!.value as Color).copy(color.ink);
    heat.forEach((one, i) => (uniforms["ramp"]!.value as Color[])[i]?.copy(one));
    uniforms["dark"]!.value = isDark ? 1 : 0;
  }

  /** Continues values of the samples at the outline. */
  #spread(values: Float32Array, size: number): void {
    if (this.#cut !== null) values.set(valuesAt(this.#cut.places, values, size, this.#rows, this.#columns), this.#rows * this.#columns * size);
  }
}
