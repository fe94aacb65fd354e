/** Lines of a given width: WebGL has none. */

import {
  BufferAttribute,
  Color,
  DynamicDrawUsage,
  InstancedBufferGeometry,
  InstancedInterleavedBuffer,
  InterleavedBufferAttribute,
  Mesh,
  ShaderMaterial,
  Vector2,
} from "three";

const VERTEX = /* glsl */ `
  attribute vec3 from;
  attribute vec3 to;
  uniform vec2 size;
  uniform float width;
  uniform float lift;
  varying float side;
  void main() {
    vec4 a = projectionMatrix * modelViewMatrix * vec4(from, 1.0);
    vec4 b = projectionMatrix * modelViewMatrix * vec4(to, 1.0);
    vec2 pa = a.xy / a.w * size * 0.5;
    vec2 pb = b.xy / b.w * size * 0.5;
    vec2 along = pb - pa;
    float length = max(length(along), 1e-6);
    along /= length;
    vec2 across = vec2(-along.y, along.x);
    float half_width = width * 0.5 + 1.0;
    float end = position.x * 2.0 - 1.0;
    vec4 at = position.x < 0.5 ? a : b;
    vec2 shift = across * position.y * half_width + along * end * min(width * 0.35, 1.0);
    side = position.y * half_width;
    gl_Position = at + vec4(shift / size * 2.0 * at.w, -lift * at.w, 0.0);
  }
`;

const FRAGMENT = /* glsl */ `
  uniform vec3 color;
  uniform float opacity;
  uniform float width;
  varying float side;
  void main() {
    float cover = clamp(width * 0.5 + 0.5 - abs(side), 0.0, 1.0);
    gl_FragColor = vec4(color, opacity * cover);
  }
`;

/** One line through points. The array of the points is the vertex buffer. */
export class FatLine extends Mesh<InstancedBufferGeometry, ShaderMaterial> {
  constructor(width: number, lift = 0) {
    const geometry = new InstancedBufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array([0, -1, 0, 1, -1, 0, 1, 1, 0, 0, 1, 0]), 3));
    geometry.setIndex([0, 1, 2, 0, 2, 3]);
    geometry.instanceCount = 0;
    const uniforms = {
      size: { value: new Vector2(1, 1) },
      width: { value: width },
      lift: { value: lift },
      color: { value: new Color() },
      opacity: { value: 1 },
    };
    super(geometry, new ShaderMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms, transparent: true, depthWrite: false, side: 2 }));
    this.frustumCulled = false;
  }

  /** Draws a line through points that have three coordinates each. */
  setPoints(positions: Float32Array): void {
    this.#segments(positions, 3, positions.length / 3 - 1);
  }

  /** Draws a line between each two points. */
  setSegments(positions: Float32Array): void {
    this.#segments(positions, 6, positions.length / 6);
  }

  #segments(positions: Float32Array, stride: number, count: number): void {
    const { geometry } = this;
    // A geometry whose buffers are others needs to be made ready again.
    const buffer = new InstancedInterleavedBuffer(positions, stride, 1);
    buffer.setUsage(DynamicDrawUsage);
    geometry.dispose();
    geometry.setAttribute("from", new InterleavedBufferAttribute(buffer, 3, 0));
    geometry.setAttribute("to", new InterleavedBufferAttribute(buffer, 3, 3));
    geometry.instanceCount = Math.max(0, count);
  }

  /** Of a canvas with so many pixels, `ratio` for each of the page. */
  setSize(width: number, height: number, ratio: number, thickness: number): void {
    (this.material.uniforms["size"]!.value as Vector2).set(width * ratio, height * ratio);
    this.material.uniforms["width"]!.value = thickness * ratio;
  }

  setColor(color: Color, opacity = 1): void {
    (this.material.uniforms["color"]!.value as Color).copy(color);
    this.material.uniforms["opacity"]!.value = opacity;
  }
}
