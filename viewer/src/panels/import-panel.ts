/** Data points, and how they are fitted. */

import { ApiError, type api } from "piad";

import type { App, How, Panel } from "../app.js";
import { byId, el } from "../html.js";
import { Store } from "../store.js";
import { whenReleased } from "../ui/press.js";
import { sentence } from "../text/errors.js";
import { Complaints } from "./complaints.js";
import { Description } from "./description.js";
import { dataOf, editable, words } from "./draft.js";
import { type InputFile, listen, open } from "./drop.js";
import { snippet } from "./snippet.js";
import { type Draft, Form } from "./form.js";
import { type Fields, at } from "./pointer.js";
import { InputError, parseInput } from "./parse-input.js";
import { RequestText } from "./request.js";
import { METHOD_EXAMPLES } from "./method-examples.js";

// Stands where the help of a field is shown.
const HINT = "Choose a field to read what it means.";

export const importPanel: Panel = (root, app) => {
  const draft = new Store<Draft>({ request: {}, touched: false });
  const data = el("div", { class: "data", "aria-live": "polite" });
  const wrong = el("div", {});
  const source = sources(app, draft, data, wrong);
  const settings = el("div", {}, el("p", { class: "hint" }, "Asking the server what it can do …"));
  const forget = () => wrong.replaceChildren();
  app.view.subscribe((now, before) => now.jobs !== before.jobs && forget());
  root.replaceChildren(source, settings);
  draft.subscribe(({ request }, before) => {
    if (dataOf(request)?.count !== dataOf(before.request)?.count || words(request) !== words(before.request)) source.dispatchEvent(new Event("points"));
  });

  const begin = (): void => {
    Description.of(app.client).then(
      (description) => settings.replaceWith(editor(app, draft, description, forget)),
      (error: Error) => {
        const again = el("button", { type: "button", class: "plain", onclick: begin }, "Try again");
        settings.replaceChildren(el("p", { class: "hint" }, `The server does not say what it can do. ${error.message}`), again);
      },
    );
  };
  begin();
  follow(app, draft);
};

/** While nobody has changed anything, the request is that of the newest job on the screen. */
function follow(app: App, draft: Store<Draft>): void {
  let followed = "";
  const update = () => {
    const fit = app.fits.shown.at(-1);
    if (fit === undefined || fit.id === followed || draft.value.touched) return;
    followed = fit.id;
    fit.input().then(
      (request) => {
        if (!draft.value.touched && followed === fit.id) draft.set({ request: editable(request) });
      },
      () => {},
    );
  };
  app.fits.subscribe(update);
  update();
}

/** Where points come from: files, the clipboard, a text, or jobs that are ready. */
function sources(app: App, draft: Store<Draft>, data: HTMLElement, wrong: HTMLElement): HTMLElement {
  let reading = new AbortController();
  let notices: readonly string[] = [];
  const show = () => {
    const { request } = draft.value;
    data.replaceChildren(...(dataOf(request) === null ? [] : [el("p", {}, el("b", {}, words(request)))]), ...notices.map((notice) => el("p", { class: "hint" }, notice)));
  };

  async function importFile(input: InputFile): Promise<void> {
    const { name, text } = input;
    byId("tab-import").click();
    reading.abort();
    const { signal } = (reading = new AbortController());
    wrong.replaceChildren();
    try {
      const result = await parseInput(input, name?.replace(/\.[^.]*$/, "") ?? null, signal);
      notices = result.notices;
      draft.set({ request: editable(result.request as api.JobRequest), touched: true });
      show();
      typed.open = false;
      app.say(`${name ?? "The text"} is read: ${words(draft.value.request)}.`);
    } catch (error) {
      if (signal.aborted) return;
      const faults = error instanceof InputError ? error.faults : [{ detail: error instanceof Error ? error.message : String(error), line: null, column: null }];
      wrong.replaceChildren(snippet(name ?? "The text", text, faults));
      wrong.scrollIntoView({ block: "nearest" });
    }
  }

  const input = el("input", { type: "file", id: "file", class: "aside", tabindex: -1, "aria-label": "A file of points", accept: ".csv,.dat,.txt,.xyz,.json,.tsv,.gpx,.kml,.geojson,.dxf,.svg,.nc,.gcode,.asc,.pts,.pcd,.las,.ply,.stl,.obj,.off,text/*,application/json" });
  input.addEventListener("change", () => {
    const [file] = input.files ?? [];
    input.value = "";
    if (file !== undefined) open(file).then(importFile, (error: Error) => app.say(error.message, "error"));
  });
  const area = el("textarea", { id: "typed", rows: 6, spellcheck: "false", placeholder: "0, 0\n1, 2\n3, 3" });
  const typed = el(
    "details",
    { class: "typed" },
    el("summary", {}, "Type or paste points"),
    el("label", { for: "typed", class: "aside" }, "Points, one a line"),
    area,
    el("button", { type: "button", class: "plain", onclick: () => void importFile({ name: null, text: area.value }) }, "Read"),
  );
  const ready = el("details", { class: "ready" }, el("summary", {}, "Take a job that is ready"), el("ul", {}, ...METHOD_EXAMPLES.map((example) => {
    const start = () => {
      notices = [];
      wrong.replaceChildren();
      draft.set({ request: editable(example.request()), touched: false });
      app.fit(example.request()).catch((error: Error) => app.say(error.message, "error"));
    };
    return el("li", {}, el("button", { type: "button", onclick: start }, el("b", {}, example.name), el("span", {}, example.about)));
  })));
  listen((input) => void importFile(input), (sentence) => app.say(sentence, "error"));
  const element = el(
    "div",
    { class: "sources" },
    el("div", { class: "row" }, el("button", { type: "button", class: "plain", onclick: () => input.click() }, "Choose a file"), el("p", { class: "hint" }, "or drop or paste it anywhere: CSV, .dat, XYZ, JSON, GPX, DXF, SVG, meshes and others"), input),
    typed,
    ready,
    wrong,
    data,
  );
  element.addEventListener("points", () => {
    if (!draft.value.touched) notices = [];
    show();
  });
  return element;
}

/** The fields, the request, and the buttons that send it. `onSend` is called when a request is sent. */
function editor(app: App, draft: Store<Draft>, description: Description, onSend: () => void): HTMLElement {
  const form = new Form(description, draft);
  const text = new RequestText(app, draft);
  const complaints = new Complaints();
  const help = el("p", { class: "help", "aria-hidden": "true" }, HINT);
  const fit = el("button", { type: "submit", class: "primary" }, "Fit");
  const beside = el("button", { type: "button", class: "plain", title: "Fit, and compare with what is on the screen", onclick: () => void send("compare") }, "Fit beside");
  const element = el("form", { novalidate: true, autocomplete: "off" }, form.element, text.element, el("div", { role: "alert" }, complaints.element), el("footer", {}, help, el("div", { class: "row" }, fit, beside)));

  element.addEventListener("submit", (event) => {
    event.preventDefault();
    void send("replace");
  });
  element.addEventListener("focusin", ({ target }) => {
    const field = target instanceof Element ? target.closest(".field") : null;
    help.textContent = field?.querySelector("[id$=-help]")?.textContent || HINT;
  });
  let points = pointsOf(draft.value.request);
  draft.subscribe(() => whenReleased(update));
  update();

  function update(): void {
    // Other data may mend anything.
    if (points !== pointsOf(draft.value.request)) clear();
    points = pointsOf(draft.value.request);
    form.refresh();
    text.refresh();
    complaints.refresh(draft.value.request);
    const none = dataOf(draft.value.request) === null && Object.keys(draft.value.request).length === 0;
    fit.disabled = beside.disabled = none;
  }

  function clear(): void {
    form.clear();
    complaints.clear();
  }

  async function send(how: How): Promise<void> {
    const { request } = draft.value;
    clear();
    onSend();
    element.setAttribute("aria-busy", "true");
    try {
      await app.fit(request as unknown as api.JobRequest, how);
      if (draft.value.request === request) draft.set({ touched: false });
    } catch (error) {
      whenReleased(() => refused(error, request));
    } finally {
      element.removeAttribute("aria-busy");
    }
  }

  /** Each thing that is wrong at its field; what has none above the buttons. */
  function refused(error: unknown, request: Fields): void {
    const errors = error instanceof ApiError && error.errors.length > 0 ? error.errors : [{ detail: sentence(error) }];
    const homeless = errors.filter(({ pointer, detail }) => pointer === undefined || !form.tell(pointer, detail));
    complaints.tell(homeless, request);
    const first = element.querySelector<HTMLElement>("[aria-invalid=true]");
    first?.closest("details")?.setAttribute("open", "");
    if (first !== null) first.focus();
    else complaints.element.scrollIntoView({ block: "nearest" });
  }

  return element;
}

/** The data points of a request. */
function pointsOf(request: Fields): unknown {
  return at(request, dataOf(request)?.pointer ?? "/-");
}
