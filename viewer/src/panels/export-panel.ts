/** The iteration on the screen as files, and the link to it. */

import { ApiError } from "piad";

import type { App, Panel } from "../app.js";
import { authorized } from "../http.js";
import type { Fit } from "../fit/fit.js";
import { el } from "../html.js";
import { linkTo } from "../state.js";
import { count } from "../text/numbers.js";
import { copy, save } from "./copy.js";
import { Description, spoken } from "./description.js";
import { Field, type Slot, fieldOf } from "./field.js";
import { previewOf } from "./file-preview.js";
import type { Json } from "./pointer.js";

const FILE = "/v1/jobs/{id}/iterations/{k}/{format}";
/** Formats that have nothing for curves, or nothing for surfaces. */
const OF_SURFACES: ReadonlySet<string> = new Set(["stl", "ply"]);
const OF_CURVES: ReadonlySet<string> = new Set(["geojson", "gpx"]);

/** Formats that declare a unit. */
const WITH_UNITS: ReadonlySet<string> = new Set(["step", "iges"]);

/** Names that are not written in capitals. */
const TITLES: Readonly<Record<string, string>> = { gltf: "glTF", geojson: "GeoJSON" };

export const exportPanel: Panel = (root, app) => {
  const which = el("select", { id: "take-job" });
  const job = el("p", { class: "field", hidden: true }, el("label", { class: "name", for: "take-job" }, "Of"), which);
  const what = el("p", { class: "lead" });
  const files = el("div", {}, el("p", { class: "hint" }, "Asking the server what it can write …"));
  const link = el("input", { type: "text", id: "link", readonly: true });
  const share = el("section", { class: "share", "aria-labelledby": "share-head" }, el("h2", { id: "share-head" }, "Link"), el("p", { class: "hint" }, "Opens the same jobs at the same iteration."), el("div", { class: "row" }, el("label", { for: "link", class: "aside" }, "Link to what is on the screen"), link, el("button", { type: "button", class: "plain", onclick: () => void share_() }, "Copy link")));
  root.replaceChildren(job, what, files, share);

  const chosen = (): Fit | undefined => app.fits.of(which.value) ?? app.fits.shown[0];
  const share_ = async (): Promise<void> => {
    const done = await copy(link.value);
    app.say(done ? "The link is on the clipboard." : "The link could not be copied.", done ? "info" : "error");
  };
  let names = "";
  const update = (): void => {
    const { shown } = app.fits;
    const now = shown.map(({ id, title }) => `${id} ${title}`).join();
    if (now !== names) {
      const { value } = which;
      which.replaceChildren(...shown.map(({ id, title }) => el("option", { value: id }, title)));
      which.value = shown.some(({ id }) => id === value) ? value : (shown[0]?.id ?? "");
      names = now;
    }
    job.hidden = shown.length < 2;
    const fit = chosen();
    const k = fit === undefined ? -1 : numberOf(app, fit);
    const text = fit === undefined || k < 0 ? "There is nothing on the screen yet." : `Iteration ${count(k)} of ${fit.title}`;
    if (what.textContent !== text) what.textContent = text;
    files.toggleAttribute("inert", fit === undefined || k < 0);
    const isCurve = (fit?.head?.kind ?? fit?.job?.status.kind) === "curve";
    for (const button of files.querySelectorAll<HTMLElement>("[data-format]")) button.parentElement!.hidden = (isCurve ? OF_SURFACES : OF_CURVES).has(button.dataset["format"] ?? "");
    link.value = new URL(linkTo(app.view.value), location.href).href;
  };
  which.addEventListener("change", update);
  app.view.subscribe(update);
  app.fits.subscribe(update);
  update();

  const begin = (): void => {
    Description.of(app.client).then(
      (description) => {
        files.replaceChildren(...formats(app, description, chosen));
        update();
      },
      (error: Error) => files.replaceChildren(el("p", { class: "hint" }, `The server does not say what it can write. ${error.message}`), el("button", { type: "button", class: "plain", onclick: begin }, "Try again")),
    );
  };
  begin();
};

/** The iteration of a job that is on the screen. */
function numberOf({ view }: App, fit: Fit): number {
  const { iteration } = view.value;
  return iteration === "latest" ? fit.latest : Math.min(iteration, fit.latest);
}

/** A button for each format, and what files may be asked for. */
function formats(app: App, description: Description, chosen: () => Fit | undefined): HTMLElement[] {
  const names = description.parts("format");
  const about = new Map(description.media(FILE));
  const able: readonly string[] = description.capabilities.formats.result;
  const rows = able.flatMap((type) => {
    const name = names.find((part) => type.split("/")[1]?.replace("+", "").includes(part));
    return name === undefined ? [] : [button(name, about.get(type) ?? type, () => void get(name), () => void look(name))];
  });
  const asked: Record<string, Json | undefined> = {};
  const preview = el("div", { class: "preview", "aria-live": "polite" });
  const fields = description.parameters(FILE).map((parameter) => option(description, parameter, asked));
  const json = button("json", "Control points, knots and errors, as the API has them.", () => void result(), () => void look("json"));
  const options = fields.length === 0 ? [] : [el("details", { class: "options" }, el("summary", {}, "Options"), ...fields.map(({ element }) => element))];
  return [el("ul", { class: "files" }, ...rows, json), ...options, preview];

  async function get(name: string): Promise<void> {
    const found = await fetched(name);
    if (found !== null) save(found.file, found.name);
  }

  /** The last iteration with all that belongs to it; others as the stream has them. */
  async function result(): Promise<void> {
    await get("json");
  }

  /** Shows what is in a file before it is saved. */
  async function look(format: string): Promise<void> {
    preview.replaceChildren(el("p", { class: "hint" }, "Asking for the file …"));
    const found = await fetched(format);
    preview.replaceChildren(...(found === null ? [] : await previewOf(format, found.file, found.name)));
    preview.scrollIntoView({ block: "nearest" });
  }

  /** Where a file of the iteration on the screen is. */
  function pathOf(fit: Fit, format: string): string {
    const k = numberOf(app, fit);
    if (format === "json") return fit.end !== null && k === fit.latest ? "result" : `iterations/${k}`;
    const { unit } = app.view.value;
    const given = unit !== "" && asked["units"] === undefined && WITH_UNITS.has(format) ? { ...asked, units: unit } : asked;
    const query = new URLSearchParams(Object.entries(given).flatMap(([key, value]) => (value === undefined ? [] : [[key, String(value)]])));
    return `iterations/${k}/${format}${query.size > 0 ? `?${query}` : ""}`;
  }

  async function fetched(format: string): Promise<{ file: Blob; name: string } | null> {
    const fit = chosen();
    if (fit === undefined) return null;
    for (const field of fields) field.clear();
    try {
      const { file, name } = await fileAt(`v1/jobs/${fit.id}/${pathOf(fit, format)}`);
      return { file, name: name ?? `${fit.title.replace(/[^\w.-]+/g, "_")}.${format}` };
    } catch (error) {
      const told = error instanceof ApiError && error.errors.some(({ parameter, detail }) => fields.some((field) => field.tell(`/${parameter}`, detail)));
      if (told) fields[0]?.element.closest("details")?.setAttribute("open", "");
      app.say(error instanceof ApiError ? error.detail : `The file could not be read. ${error instanceof Error ? error.message : ""}`, "error");
      return null;
    }
  }
}

function button(name: string, about: string, onclick: () => void, look: () => void): HTMLElement {
  const preview = el("button", { type: "button", class: "quiet look", "aria-label": `Preview ${title(name)}`, onclick: look }, "Preview");
  return el("li", {}, el("button", { type: "button", "data-format": name, onclick }, el("b", {}, title(name)), el("span", {}, about)), preview);
}

function option(description: Description, { name, schema, description: help = "" }: { name: string; schema: object; description?: string }, asked: Record<string, Json | undefined>): Field {
  const slot: Slot = { side: null, claims: [`/${name}`], get: () => asked[name], set: (value) => void (asked[name] = value) };
  return fieldOf(description, schema, spoken(name), [slot], { help, ...(name === "units" && { names: (unit: string) => unit }) });
}

function title(name: string): string {
  return TITLES[name] ?? name.toUpperCase();
}

/** A file of the server, with its name; what it refuses is thrown. */
async function fileAt(path: string): Promise<{ file: Blob; name: string | undefined }> {
  const response = await authorized(new URL(path, document.baseURI), { headers: { Accept: "*/*" } });
  if (!response.ok) {
    const problem = (await response.json().catch(() => null)) as ConstructorParameters<typeof ApiError>[0] | null;
    throw new ApiError(problem ?? { type: "about:blank", title: response.statusText, status: response.status, detail: `The server answered ${response.status}.`, request_id: "" });
  }
  const name = /filename="([^"]*)"/.exec(response.headers.get("Content-Disposition") ?? "")?.[1];
  return { file: await response.blob(), name };
}
