/** Files that are dropped or pasted anywhere on the page. */

import { el } from "../html.js";

/** A file, or a text that was pasted or typed. */
export interface InputFile {
  /** The name of the file; null for what was pasted. */
  readonly name: string | null;
  readonly text: string;
  /** The bytes of the file, which need not be text. */
  readonly bytes?: Blob;
}

// A file larger than this is no file of points.
const LARGEST = 300_000_000;

/** Calls with each text that is dropped or pasted, and with an error if one cannot be read. */
export function listen(onText: (input: InputFile) => void, onError: (sentence: string) => void): void {
  const veil = el("div", { class: "veil", hidden: true }, el("p", {}, "Drop to read the points"));
  document.body.append(veil);
  const show = (on: boolean) => void (veil.hidden = !on);
  const has = (event: DragEvent, type: string) => event.dataTransfer?.types.includes(type) ?? false;
  const comes = (event: DragEvent) => has(event, "Files") || (has(event, "text/plain") && !isField(event.target));

  addEventListener("dragover", (event) => {
    if (!comes(event)) return;
    event.preventDefault();
    if (event.dataTransfer !== null) event.dataTransfer.dropEffect = "copy";
    show(true);
  });
  addEventListener("dragleave", (event) => {
    // Only when it leaves the window, not one element for another.
    if (event.relatedTarget === null) show(false);
  });
  addEventListener("drop", (event) => {
    show(false);
    if (!comes(event)) return;
    event.preventDefault();
    receive(event.dataTransfer);
  });
  addEventListener("paste", (event) => {
    const files = (event.clipboardData?.files.length ?? 0) > 0;
    if (!files && isField(event.target)) return;
    event.preventDefault();
    receive(event.clipboardData);
  });

  function receive(data: DataTransfer | null): void {
    const [file] = data?.files ?? [];
    const text = data?.getData("text/plain") ?? "";
    if (file !== undefined) void open(file).then(onText, (error: Error) => onError(error.message));
    else if (text.trim() !== "") onText({ name: null, text });
    else onError("There was no text in it.");
  }
}

/** The text of a file. */
export async function open(file: File): Promise<InputFile> {
  if (file.size > LARGEST) throw new Error(`${file.name} is larger than files of points are.`);
  if (file.size === 0) throw new Error(`${file.name} is empty.`);
  return { name: file.name, text: await file.text(), bytes: file };
}

function isField(target: EventTarget | null): boolean {
  return target instanceof Element && target.closest("input, textarea, select, [contenteditable]") !== null;
}
