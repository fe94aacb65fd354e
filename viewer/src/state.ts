/** What is on the screen, and the link that opens the same again. */

import { Store } from "./store.js";

/** What is drawn of a fit. */
export interface Layers {
  /** The data points. */
  readonly data: boolean;
  /** The control polygon, or the net of a surface. */
  readonly polygon: boolean;
  /** From data points to where the fit is at their parameters, enlarged. */
  readonly spikes: boolean;
  /** The curvature of a curve. */
  readonly comb: boolean;
  /** The distance from the data as colours. */
  readonly heat: boolean;
  /** Reflected stripes on a surface. */
  readonly zebra: boolean;
}

export type Layer = keyof Layers;

/** A data point: a number, or row and column of a surface. */
export type Place = number | readonly [number, number];

export interface View {
  /** The ids of the jobs that are shown, one to four; none before the first. */
  readonly jobs: readonly string[];
  /** "latest" goes along with a fit that runs, and is its last iteration after that. */
  readonly iteration: number | "latest";
  readonly playing: boolean;
  /** In it drags move data points; without it they turn the scene. */
  readonly editing: boolean;
  readonly layers: Layers;
  /** The data point that is looked at, of the first job. */
  readonly selection: Place | null;
}

/** How many jobs stand side by side at most. */
export const MOST_JOBS = 4;

const LAYERS: Layers = { data: true, polygon: false, spikes: false, comb: false, heat: false, zebra: false };

const BEGINNING: View = { jobs: [], iteration: "latest", playing: false, editing: false, layers: LAYERS, selection: null };

/** The view that a link names; what it does not say is as at the beginning. */
export function viewOf(hash: string): View {
  const parts = new URLSearchParams(hash.replace(/^#/, ""));
  const jobs = (parts.get("job") ?? "").split(",").filter((id) => /^[\w-]+$/.test(id));
  const k = parts.get("k") ?? "";
  const show = parts.get("show")?.split(",");
  const layers = Object.fromEntries(
    Object.entries(LAYERS).map(([name, on]) => [name, show === undefined ? on : show.includes(name)]),
  ) as unknown as Layers;
  return {
    ...BEGINNING,
    jobs: [...new Set(jobs)].slice(0, MOST_JOBS),
    iteration: /^\d{1,9}$/.test(k) ? Number(k) : "latest",
    layers,
  };
}

/** The link to a view, from "#" on. */
export function linkTo({ jobs, iteration, layers }: View): string {
  if (jobs.length === 0) return "";
  const parts = [`job=${jobs.join(",")}`];
  if (iteration !== "latest") parts.push(`k=${iteration}`);
  const names = Object.keys(LAYERS) as Layer[];
  if (names.some((name) => layers[name] !== LAYERS[name])) {
    parts.push(`show=${names.filter((name) => layers[name]).join(",")}`);
  }
  return `#${parts.join("&")}`;
}

/** The store of the view, which follows the address of the page and writes itself there. */
export function createView(): Store<View> {
  const view = new Store(viewOf(location.hash));
  // The jobs of the address as it was looked at last: it may already be another, which is told of later.
  let written = view.value.jobs.join();
  addEventListener("hashchange", () => {
    const now = viewOf(location.hash);
    written = now.jobs.join();
    if (location.hash !== linkTo(view.value)) view.set(now);
  });
  view.subscribe((value) => {
    const another = written !== value.jobs.join();
    // While iterations run by, the address would change more often than browsers allow.
    if (value.playing && !another) return;
    const link = linkTo(value.playing ? { ...value, iteration: "latest" } : value);
    if (link === location.hash || link === "") return;
    history[another && written !== "" ? "pushState" : "replaceState"](null, "", link);
    written = value.jobs.join();
  });
  return view;
}
