/** What the page is about: the server, the view, and the jobs on the screen. Nothing here draws. */

import { Client, type Job } from "piad";

import type { How } from "./app.js";
import { authorized } from "./http.js";
import { OpenFits } from "./fit/fits.js";
import { MOST_JOBS, createView } from "./state.js";

/** The server that the page came from. */
export const client = new Client(new URL(".", document.baseURI), { attempts: 4, fetch: authorized });

export const view = createView();

export const fits = new OpenFits(client, view);

/** Shows a job from its beginning: by its id, or as the server has just told of it. */
export function open(job: string | Job, how: How = "replace"): void {
  const id = typeof job === "string" ? job : job.id;
  if (typeof job !== "string") fits.know(job);
  const beside = how === "compare" ? view.value.jobs.filter((job) => job !== id).slice(0, MOST_JOBS - 1) : [];
  const playing = !matchMedia("(prefers-reduced-motion: reduce)").matches;
  view.set({ jobs: [...beside, id], iteration: playing ? 0 : "latest", playing, selection: null });
}
