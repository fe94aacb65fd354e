/** Points as round dots. */

import { BufferAttribute, BufferGeometry, Color, Points, ShaderMaterial } from "three";

const VERTEX = /* glsl */ `
  uniform float diameter;
  uniform float lift;
  varying float radius;
  void main() {
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
    gl_Position.z -= lift * gl_Position.w;
    gl_PointSize = diameter + 2.0;
    radius = diameter * 0.5;
  }
`;

const FRAGMENT = /* glsl */ `
  uniform vec3 color;
  uniform vec3 rim;
  uniform float rimWidth;
  uniform float opacity;
  varying float radius;
  void main() {
    float d = length((gl_PointCoord - 0.5) * (radius * 2.0 + 2.0));
    float cover = clamp(radius - d + 0.5, 0.0, 1.0);
    if (cover <= 0.0) discard;
    float inside = clamp(radius - rimWidth - d + 0.5, 0.0, 1.0);
    gl_FragColor = vec4(rimWidth > 0.0 ? mix(rim, color, inside) : color, cover * opacity);
  }
`;

export class Dots extends Points<BufferGeometry, ShaderMaterial> {
  constructor(lift: number) {
    const uniforms = {
      diameter: { value: 8 },
      lift: { value: lift },
      color: { value: new Color() },
      rim: { value: new Color() },
      rimWidth: { value: 0 },
      opacity: { value: 1 },
    };
    super(new BufferGeometry(), new ShaderMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms, transparent: true, depthWrite: false }));
    this.frustumCulled = false;
  }

  /** The array is the vertex buffer. */
  setPoints(positions: Float32Array): void {
    this.geometry.dispose();
    this.geometry.setAttribute("position", new BufferAttribute(positions, 3));
  }

  setLook(color: Color, rim: Color, diameter: number, rimWidth: number, opacity = 1): void {
    const { uniforms } = this.material;
    (uniforms["color"]!.value as Color).copy(color);
    (uniforms["rim"]!.value as Color).copy(rim);
    uniforms["diameter"]!.value = diameter;
    uniforms["rimWidth"]!.value = rimWidth;
    uniforms["opacity"]!.value = opacity;
  }
}
