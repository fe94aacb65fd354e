/** What there is to see at once. */

import type { Job, api } from "piad";

import type { App } from "../app.js";
import { byId, el } from "../html.js";
import { client, open, view } from "../session.js";
import { sentence } from "../text/errors.js";

export interface Example {
  readonly name: string;
  readonly request: () => api.JobRequest;
}

/** Numbers that are short in the request, and the same on all machines. */
const round = (value: number): number => Number(value.toFixed(5));
const steps = (count: number, of: number): number[] => Array.from({ length: count }, (_, i) => (i / of) * 2 * Math.PI);

/** A ring with five folds that wind around it. */
function ring(): number[][][] {
  return steps(25, 25).map((u) =>
    steps(9, 9).map((v) => {
      const thick = 0.78 + 0.17 * Math.cos(5 * u + 2 * v);
      const out = 2.1 + thick * Math.cos(v);
      return [out * Math.cos(u), out * Math.sin(u), 0.95 * thick * Math.sin(v) + 0.22 * Math.sin(2 * u)].map(round);
    }),
  );
}

/** A wave that runs out from the middle. */
function wave(): number[][][] {
  const side = Array.from({ length: 21 }, (_, i) => (i - 10) / 10);
  return side.map((x) => side.map((y) => [2 * x, 2 * y, (0.9 * Math.cos(5.6 * Math.hypot(x, y))) / (1 + 2.6 * (x * x + y * y))].map(round)));
}

/** A rose with five petals. */
function rose(): number[][] {
  return steps(60, 60).map((t) => {
    const r = 1 + 0.42 * Math.cos(5 * t);
    return [r * Math.cos(t), r * Math.sin(t)].map(round);
  });
}

/** NACA 2412 from its trailing edge around the nose. */
function wing(): number[][] {
  const [m, p, t] = [0.02, 0.4, 0.12];
  return Array.from({ length: 41 }, (_, i) => {
    const turn = (i / 40) * 2 * Math.PI;
    const x = (1 + Math.cos(turn)) / 2;
    const half = 5 * t * (0.2969 * Math.sqrt(x) - 0.126 * x - 0.3516 * x ** 2 + 0.2843 * x ** 3 - 0.1036 * x ** 4);
    const camber = x < p ? (m / p ** 2) * (2 * p * x - x * x) : (m / (1 - p) ** 2) * (1 - 2 * p + 2 * p * x - x * x);
    return [x, camber + (turn <= Math.PI ? half : -half)].map(round);
  });
}

export const EXAMPLES: readonly Example[] = [
  { name: "Ring", request: () => ({ name: "Ring", surface: { points: ring(), closed: true }, stop: { relative_tolerance: 1e-9 } }) },
  { name: "Wave", request: () => ({ name: "Wave", surface: { points: wave() }, stop: { relative_tolerance: 1e-9 } }) },
  { name: "Rose", request: () => ({ name: "Rose", curve: { points: rose(), closed: true }, stop: { relative_tolerance: 1e-8 } }) },
  { name: "Wing section", request: () => ({ name: "Wing section", curve: { points: wing() }, stop: { relative_tolerance: 1e-8 } }) },
] as unknown as readonly Example[];

/** The example as a job; the same one is the same job, as long as the server has it. */
function jobOf({ name, request }: Example): Promise<Job> {
  return client.create(request(), { idempotencyKey: `page-example-3-${name.toLowerCase().replace(" ", "-")}` });
}

let first: Promise<Job> | null = null;

/** Fits the first example, unless the link names jobs. */
export function begin(): void {
  if (view.value.jobs.length > 0) return;
  first = jobOf(EXAMPLES[0]!);
  first.then((job) => open(job), () => {});
}

export function examples(app: App): void {
  const failed = (error: unknown) => app.say(`The example could not be fitted: ${sentence(error)}`, "error");
  const buttons = EXAMPLES.map((example) =>
    el("button", { type: "button", class: "quiet", onclick: () => void jobOf(example).then((job) => app.open(job), failed) }, example.name),
  );
  byId("examples").append(...buttons);
  app.fits.subscribe(() => {
    const title = app.fits.shown.length === 1 ? app.fits.shown[0]?.title : null;
    for (const button of buttons) button.setAttribute("aria-current", String(button.textContent === title));
  });
  first?.catch(failed);
}
