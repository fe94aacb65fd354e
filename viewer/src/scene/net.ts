/** The control net of a surface, in thin lines. */

import { BufferAttribute, BufferGeometry, Color, LineSegments, ShaderMaterial } from "three";

import { netOf } from "./grid.js";

const VERTEX = /* glsl */ `
  void main() {
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
    gl_Position.z -= 1e-5 * gl_Position.w;
  }
`;

const FRAGMENT = /* glsl */ `
  uniform vec3 color;
  uniform float opacity;
  void main() { gl_FragColor = vec4(color, opacity); }
`;

export class Net extends LineSegments<BufferGeometry, ShaderMaterial> {
  #shape = "";

  constructor() {
    const uniforms = { color: { value: new Color() }, opacity: { value: 1 } };
    super(new BufferGeometry(), new ShaderMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms, transparent: true, depthWrite: false }));
    this.frustumCulled = false;
  }

  /** The array is the vertex buffer. */
  setPoints(positions: Float32Array, rows: number, columns: number): void {
    const shape = `${rows} ${columns}`;
    if (shape !== this.#shape) {
      this.#shape = shape;
      this.geometry.dispose();
      this.geometry.setIndex(new BufferAttribute(netOf(rows, columns), 1));
    }
    this.geometry.setAttribute("position", new BufferAttribute(positions, 3));
  }

  setColor(color: Color, opacity: number): void {
    (this.material.uniforms["color"]!.value as Color).copy(color);
    this.material.uniforms["opacity"]!.value = opacity;
  }
}
