/** What is beside the scene: the chart and the panels. It is a script of its own, which the first picture does not wait for. */

import type { App } from "./app.js";
import { byId } from "./html.js";
import { importPanel } from "./panels/import-panel.js";
import { jobs } from "./panels/jobs.js";
import { exportPanel } from "./panels/export-panel.js";
import type { SceneController } from "./scene/scene-controller.js";
import { chart } from "./ui/chart.js";
import { help } from "./ui/help.js";
import { overlay } from "./ui/overlay.js";

/** Makes it piece by piece, so that nobody waits for it. */
export async function sidebar(app: App, scene: SceneController): Promise<void> {
  chart(app);
  overlay(app, scene);
  help();
  await rest();
  importPanel(byId("import"), app);
  jobs(byId("jobs"), app);
  exportPanel(byId("export"), app);
  await rest();
}

/** Lets the browser show what there is. */
function rest(): Promise<void> {
  return new Promise((resolve) => setTimeout(resolve, 30));
}
