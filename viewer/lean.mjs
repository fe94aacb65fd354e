// What the page does not need of three. It has shaders of its own, and neither environment maps nor headsets;
// taken from its sources, so that these can be left out, three weighs two thirds.

import { fileURLToPath } from "node:url";

const SOURCES = fileURLToPath(new URL("node_modules/three/src/", import.meta.url));

// A part of all fragment shaders, whatever the material.
const KEPT = /colorspace_pars_fragment/;

const NO_HEADSET = `export class WebXRManager {
  enabled = false;
  isPresenting = false;
  getEnvironmentBlendMode() {}
  addEventListener() {}
  removeEventListener() {}
  setAnimationLoop() {}
  dispose() {}
}`;

const NO_ENVIRONMENT = "export class PMREMGenerator {}";

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
    build.onLoad({ filter: /three\/src\/renderers\/webxr\/WebXRManager\.js$/ }, () => ({ contents: NO_HEADSET }));
    build.onLoad({ filter: /three\/src\/extras\/PMREMGenerator\.js$/ }, () => ({ contents: NO_ENVIRONMENT }));
  },
};
