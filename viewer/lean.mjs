// What the page does not need of three. It has shaders of its own, no textures, lights or shadows, and nothing but the
// canvas to draw to; taken from its sources, so that the rest can be left out, three weighs half.

import { fileURLToPath } from "node:url";

const SOURCES = fileURLToPath(new URL("node_modules/three/src/", import.meta.url));

// A part of all fragment shaders, whatever the material.
const KEPT = /colorspace_pars_fragment/;

/** What stands for parts of the renderer: they are made, and called with nothing to do. */
const EMPTY = {
  "renderers/webxr/WebXRManager": `export class WebXRManager {
    enabled = false;
    isPresenting = false;
    getEnvironmentBlendMode() {}
    addEventListener() {}
    removeEventListener() {}
    setAnimationLoop() {}
    dispose() {}
  }`,
  "extras/PMREMGenerator": "export class PMREMGenerator {}",
  "geometries/PlaneGeometry": "export class PlaneGeometry {}",
  "renderers/shaders/DFGLUTData": "export const getDFGLUT = () => null;",
  "renderers/shaders/ShaderLib": "export const ShaderLib = {};",
  "renderers/webgl/WebGLOutput": "export class WebGLOutput {}",
  "renderers/webgl/WebGLUtils": "export class WebGLUtils { convert() { return 0; } }",
  "renderers/webgl/WebGLMorphtargets": "export class WebGLMorphtargets { update() {} }",
  "renderers/webgl/WebGLEnvironments": "export class WebGLEnvironments { get() { return null; } dispose() {} }",
  "renderers/webgl/WebGLUniformsGroups": "export class WebGLUniformsGroups { bind() {} update() {} dispose() {} }",
  // All lists of lights are empty, and all counts zero.
  "renderers/webgl/WebGLLights": `export class WebGLLights {
    state = new Proxy({ version: 0 }, { get: (own, name) => own[name] ?? (String(name).startsWith("num") ? 0 : []) });
    setup() {}
    setupView() {}
  }`,
  "renderers/webgl/WebGLShadowMap": `export class WebGLShadowMap {
    enabled = false;
    autoUpdate = true;
    needsUpdate = false;
    type = 1;
    render() {}
  }`,
  // The canvas is cleared with nothing.
  "renderers/webgl/WebGLBackground": `export class WebGLBackground {
    constructor(renderer, environments, state) { state.buffers.color.setClear(0, 0, 0, 0); }
    getClearColor() {}
    setClearColor() {}
    getClearAlpha() { return 0; }
    setClearAlpha() {}
    render() {}
    addToRenderList() {}
    dispose() {}
  }`,
  "renderers/webgl/WebGLClipping": `export class WebGLClipping {
    uniform = { value: null, needsUpdate: false };
    numPlanes = 0;
    numIntersection = 0;
    init() { return false; }
    beginShadows() {}
    endShadows() {}
    setGlobalState() {}
    setState() {}
  }`,
  "renderers/webgl/WebGLMaterials": `export class WebGLMaterials {
    refreshFogUniforms() {}
    refreshMaterialUniforms(uniforms, material) { material.uniformsNeedUpdate = false; }
  }`,
  "renderers/webgl/WebGLTextures": `export class WebGLTextures {
    getTextureUnits() { return 0; }
    setTextureUnits() {}
    resetTextureUnits() {}
    updateMultisampleRenderTarget() {}
    updateRenderTargetMipmap() {}
    dispose() {}
  }`,
};

/** A plugin of esbuild. */
export const lean = {
  name: "lean",
  setup(build) {
    // The renderer is a script of its own, and only what draws with it has it.
    build.onResolve({ filter: /^three$/ }, ({ importer }) => {
      const whole = importer.endsWith("/scene/webgl.ts");
      return { path: `${SOURCES}${whole ? "Three.js" : "Three.Core.js"}`, sideEffects: false };
    });
    build.onLoad({ filter: /three\/src\/renderers\/shaders\/.*\.glsl\.js$/ }, ({ path }) => {
      if (KEPT.test(path)) return undefined;
      return { contents: 'export const vertex = "", fragment = ""; export default "";' };
    });
    build.onLoad({ filter: /three\/src\/.*\.js$/ }, ({ path }) => {
      const contents = EMPTY[path.slice(SOURCES.length, -".js".length)];
      return contents === undefined ? undefined : { contents };
    });
  },
};
