/** What is in a file, before it is saved. */

import { el } from "../html.js";
import { count } from "../text/numbers.js";

// How much of a text is shown.
const LINES = 14;
const WIDEST = 120;

/** A picture, the first lines, or what a binary file says of itself. */
export async function previewOf(format: string, file: Blob, name: string): Promise<Node[]> {
  const size = file.size < 10_000 ? `${count(file.size)} bytes` : `${count(Math.round(file.size / 1000))} kB`;
  const head = el("p", {}, el("b", {}, name), `, ${size}`);
  if (format === "svg") return [head, picture(file)];
  const facts = await factsOf(format, file);
  if (facts !== null) return [head, el("p", { class: "hint" }, facts)];
  const lines = (await file.slice(0, LINES * 2000).text()).split("\n");
  const text = lines.slice(0, LINES).map((line) => (line.length > WIDEST ? `${line.slice(0, WIDEST)}…` : line));
  const more = lines.length > LINES || file.size > LINES * 2000 ? ["…"] : [];
  return [head, el("pre", { tabindex: 0, "aria-label": `The beginning of ${name}` }, [...text, ...more].join("\n"))];
}

/** A drawing; the browser lets nothing act in a picture. */
function picture(file: Blob): Node {
  const address = URL.createObjectURL(file);
  const image = el("img", { src: address, alt: "The drawing in the file" });
  image.addEventListener("load", () => URL.revokeObjectURL(address));
  return image;
}

async function factsOf(format: string, file: Blob): Promise<string | null> {
  if (format === "stl") return `${count(new DataView(await file.slice(80, 84).arrayBuffer()).getUint32(0, true))} triangles`;
  if (format === "ply") {
    const header = (await file.slice(0, 2000).text()).split("end_header")[0] ?? "";
    return [...header.matchAll(/element (\w+) (\d+)/g)].map(([, what, number]) => `${count(Number(number))} ${what === "face" ? "triangles" : "vertices"}`).join(", ");
  }
  if (format !== "gltf") return null;
  const view = new DataView(await file.slice(12, 20).arrayBuffer());
  const content = JSON.parse(await file.slice(20, 20 + view.getUint32(0, true)).text()) as { accessors?: { count: number; type: string }[]; meshes?: { name?: string; primitives: { attributes: { POSITION: number }; indices?: number; mode?: number }[] }[] };
  return (content.meshes ?? [])
    .flatMap(({ primitives }) => primitives)
    .map(({ attributes, indices, mode }) => {
      const vertices = content.accessors?.[attributes.POSITION]?.count ?? 0;
      const corners = indices === undefined ? vertices : (content.accessors?.[indices]?.count ?? 0);
      return `${count(vertices)} vertices${mode === undefined || mode === 4 ? `, ${count(Math.round(corners / 3))} triangles` : ", a line"}`;
    })
    .join("; ");
}
