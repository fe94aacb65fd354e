/** The page: a client of the server it came from. */

import "./app.css";

import type { App } from "./app.js";
import { card } from "./edit/card.js";
import { Drag } from "./edit/drag.js";
import { History } from "./edit/history.js";
import { mode } from "./edit/mode.js";
import { byId, el } from "./html.js";
import { SceneController } from "./scene/scene-controller.js";
import { Viewport } from "./scene/viewport.js";
import { client, fits, open, view } from "./session.js";
import { examples } from "./ui/examples.js";
import { labels } from "./ui/labels.js";
import { player } from "./ui/player.js";
import { pointer } from "./ui/pointer.js";
import { scrub } from "./ui/scrub.js";
import { tabs } from "./ui/tabs.js";
import { tools } from "./ui/tools.js";
import { connectionStatus } from "./ui/connection-status.js";
import { createAnnouncer } from "./ui/announcer.js";

const app: App = {
  client,
  view,
  fits,
  open,
  ...createAnnouncer(byId("announcer")),
  preview: (title, request) => scene.preview(title, request),
  close(id) {
    view.set({ jobs: view.value.jobs.filter((job) => job !== id), selection: null });
  },
  async fit(request, how) {
    app.forget();
    const job = await client.create(request);
    open(job, how);
    return job.id;
  },
};

// What was wrong with the jobs before.
view.subscribe((now, before) => now.jobs !== before.jobs && app.forget());
examples(app);
connectionStatus(app);
scrub(app);
tabs(byId("panels"));
const root = byId("viewport");
const scene = new SceneController(app, new Viewport(root));
mode(app);
const history = new History(app);
tools(app, scene);
labels(app, scene, root);
const drag = new Drag(app, scene, history);
card(app, scene, drag, root);
pointer(app, scene, root, () => drag.isBusy);
player(app, scene);

// What is beside the first picture comes after it, unless there is none for a while.
let isWhole = false;
scene.onFirst = () => void whole();
setTimeout(() => void whole(), 1000);

/** Makes the rest of the page, piece by piece, so that nobody waits for it. */
async function whole(): Promise<void> {
  if (isWhole) return;
  isWhole = true;
  try {
    const { sidebar } = await import("./sidebar.js");
    await sidebar(app, scene);
  } catch (error) {
    app.say("A part of the page could not be loaded. Load the page again.", "error");
    console.error(error);
  }
  // Without the script, as without WebGL, fits are drawn plainly.
  const script = await import("./scene/webgl.js").catch(() => null);
  if (script === null) return;
  try {
    await scene.viewport.begin(script.WebGL);
  } catch (error) {
    const sentence = "This browser has no WebGL, or it is turned off: fits are drawn plainly.";
    root.append(el("p", { class: "plainly" }, sentence));
    console.warn(error);
  }
}
