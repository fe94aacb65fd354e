/** What the parts of the page share. */

import type { Client, Job, api } from "piad";

import type { Fits } from "./fit/fits.js";
import type { View } from "./state.js";
import type { Store } from "./store.js";

/** Whether a job takes the place of those on the screen, or stands beside them. */
export type How = "replace" | "compare";

export interface App {
  /** The server that the page came from. */
  readonly client: Client;
  readonly view: Store<View>;
  /** The jobs on the screen, in their order. */
  readonly fits: Fits;
  /** Shows a job from its beginning: by its id, or as the server has just told of it. */
  open(job: string | Job, how?: How): void;
  /** Takes a job off the screen. */
  close(id: string): void;
  /** Shows the points of a request alone, until another job is shown. */
  preview(title: string, request: api.JobRequest): void;
  /** Makes a job and shows it; gives its id. What the server refuses is thrown. */
  fit(request: api.JobRequest, how?: How): Promise<string>;
  /** Says a sentence, on the screen and to screen readers. */
  say(sentence: string, kind?: "info" | "error"): void;
  /** Takes the error off the screen that was said last: its cause is gone. */
  forget(): void;
}

/** A part of the page. It takes the element over that it is given. */
export type Panel = (root: HTMLElement, app: App) => void;
