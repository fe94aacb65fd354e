/** Small drawings for buttons. */

const PATHS = {
  play: "M5 3.5v9l7.5-4.5z",
  pause: "M4.5 3.5h2.5v9h-2.5zM9 3.5h2.5v9h-2.5z",
  first: "M4 3.5h1.6v9h-1.6zM12.5 3.5v9l-6.2-4.5z",
  last: "M10.4 3.5h1.6v9h-1.6zM3.5 3.5v9l6.2-4.5z",
  undo: "M6.2 2.8 2.6 6.2l3.6 3.4V7.3h2.6a2.5 2.5 0 0 1 0 5H5v1.4h3.8a3.9 3.9 0 0 0 0-7.8H6.2z",
  redo: "M9.8 2.8l3.6 3.4-3.6 3.4V7.3H7.2a2.5 2.5 0 0 0 0 5H11v1.4H7.2a3.9 3.9 0 0 1 0-7.8h2.6z",
  whole: "M2.5 2.5h4v1.4H3.9v2.6H2.5zM9.5 2.5h4v4h-1.4V3.9H9.5zM2.5 9.5h1.4v2.6h2.6v1.4h-4zM12.1 9.5h1.4v4h-4v-1.4h2.6z",
  close: "m4.3 3.3 3.7 3.7 3.7-3.7 1 1L9 8l3.7 3.7-1 1L8 9l-3.7 3.7-1-1L7 8 3.3 4.3z",
} as const;

export type IconName = keyof typeof PATHS;

export function icon(name: IconName): SVGSVGElement {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", "0 0 16 16");
  svg.setAttribute("aria-hidden", "true");
  const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
  path.setAttribute("d", PATHS[name]);
  svg.append(path);
  return svg;
}
