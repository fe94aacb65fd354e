/** Where points come from: files, the clipboard, a text, or examples. */

import type { App } from "../app.js";
import { el } from "../html.js";
import { type InputFile, listen, open } from "./drop.js";
import { METHOD_EXAMPLES, type MethodExample } from "./method-examples.js";

const ACCEPTED = ".csv,.dat,.txt,.xyz,.json,.tsv,.gpx,.kml,.geojson,.dxf,.svg,.nc,.gcode,.asc,.pts,.pcd,.las,.ply,.stl,.obj,.off,text/*,application/json";

/** Calls with each file or text, and with each example that is chosen. */
export function sources(app: App, onInput: (input: InputFile) => void, onExample: (example: MethodExample) => void): HTMLElement {
  const input = el("input", { type: "file", id: "file", class: "aside", tabindex: -1, "aria-label": "A file of points", accept: ACCEPTED });
  input.addEventListener("change", () => {
    const [file] = input.files ?? [];
    input.value = "";
    if (file !== undefined) open(file).then(onInput, (error: Error) => app.say(error.message, "error"));
  });
  const area = el("textarea", { id: "typed", rows: 6, spellcheck: "false", placeholder: "0, 0\n1, 2\n3, 3" });
  const read = () => {
    typed.open = false;
    onInput({ name: null, text: area.value });
  };
  const typed = el(
    "details",
    { class: "typed" },
    el("summary", {}, "Type or paste points"),
    el("label", { for: "typed", class: "aside" }, "Points, one a line"),
    area,
    el("button", { type: "button", class: "plain", onclick: read }, "Read"),
  );
  const items = METHOD_EXAMPLES.map((example) => el("li", {}, el("button", { type: "button", onclick: () => onExample(example) }, el("b", {}, example.name), el("span", {}, example.about))));
  const examples = el("details", { class: "ready" }, el("summary", {}, "Examples of methods"), el("ul", {}, ...items));
  listen(onInput, (sentence) => app.say(sentence, "error"));
  return el(
    "div",
    { class: "sources" },
    el("div", { class: "row" }, el("button", { type: "button", class: "plain", onclick: () => input.click() }, "Choose a file"), el("p", { class: "hint" }, "or drop or paste it anywhere: CSV, .dat, XYZ, JSON, GPX, DXF, SVG, meshes and others"), input),
    typed,
    examples,
  );
}
