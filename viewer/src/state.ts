/** What is on the screen, and the link that opens the same again. */

import { Store } from "./store.js";

/** What is drawn of a fit. */
export interface Layers {
  /** The data points. */
  readonly data: boolean;
  /** The control polygon, or the net of a surface. */
  readonly polygon: boolean;
  /** Error vectors: from data points to where the fit is at their parameters, enlarged. */
  readonly spikes: boolean;
  /** The curvature: of a curve as a comb, of a surface as colours. */
  readonly comb: boolean;
  /** The distance from the data as colours. */
  readonly heat: boolean;
  /** Reflected stripes on a surface. */
  readonly zebra: boolean;
  /** Where the fit leaves its data between neighbours. */
  readonly between: boolean;
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
  /** How fast iterations are played: 1 is about four seconds for all of them. */
  readonly speed: number;
  /** True if they begin again after the last one. */
  readonly looping: boolean;
  /** In it drags move data points; without it they turn the scene. */
  readonly editing: boolean;
  /** The unit of the data, such as "mm"; "" where it is not known. */
  readonly unit: string;
  /** True while clicks choose the two ends of a measured distance. */
  readonly measuring: boolean;
  /** True if several jobs are drawn in one scene, not side by side. */
  readonly overlaid: boolean;
  /** The job that is drawn before the others in one scene; null as long as none is chosen. */
  readonly front: string | null;
  readonly layers: Layers;
  /** The data point that is looked at, of the first job. */
  readonly selection: Place | null;
}

/** The most jobs on the screen. */
export const MOST_JOBS = 12;

/** The units that files can have. */
export const UNITS = ["mm", "m", "in"] as const;

const LAYERS: Layers = { data: true, polygon: false, spikes: false, comb: false, heat: false, zebra: false, between: false };

const BEGINNING: View = { jobs: [], iteration: "latest", playing: false, speed: 1, looping: false, editing: false, unit: "", measuring: false, overlaid: false, front: null, layers: LAYERS, selection: null };

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
    overlaid: parts.has("overlaid"),
    unit: UNITS.find((unit) => unit === parts.get("unit")) ?? "",
    layers,
  };
}

/** The link to a view, from "#" on. */
export function linkTo({ jobs, iteration, layers, overlaid, unit }: View): string {
  if (jobs.length === 0) return "";
  const parts = [`job=${jobs.join(",")}`];
  if (iteration !== "latest") parts.push(`k=${iteration}`);
  const names = Object.keys(LAYERS) as Layer[];
  if (names.some((name) => layers[name] !== LAYERS[name])) {
    parts.push(`show=${names.filter((name) => layers[name]).join(",")}`);
  }
  if (overlaid && jobs.length > 1) parts.push("overlaid");
  if (unit !== "") parts.push(`unit=${unit}`);
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
