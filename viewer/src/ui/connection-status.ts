/** Says when jobs are not there or the server is not. */

import { ConnectionLost } from "piad";

import type { App } from "../app.js";
import { isGone } from "../fit/fit.js";
import { sentence } from "../text/errors.js";

export function connectionStatus(app: App): void {
  let said = "";
  let isLost = false;
  // An error that other jobs have, too, is said of them again.
  app.view.subscribe((now, before) => now.jobs !== before.jobs && (said = ""));
  app.fits.subscribe(() => {
    const now = app.fits.shown.flatMap(({ id, problem }) => {
      if (problem === null) return [];
      if (isGone(problem)) return [`There is no job ${id}: it may have been deleted.`];
      if (problem instanceof ConnectionLost) return ["The server cannot be reached. The page tries again until it can."];
      return [sentence(problem)];
    });
    const sentences = [...new Set(now)].join(" ");
    if (sentences === said) return;
    said = sentences;
    const wasLost = isLost;
    isLost = app.fits.shown.some(({ problem }) => problem instanceof ConnectionLost);
    if (sentences !== "") app.say(sentences, "error");
    else if (wasLost) app.say("The server is there again.");
    else app.forget();
  });
}
