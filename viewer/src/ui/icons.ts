/** Small drawings for buttons. */

const PATHS = {
  play: "M5 3.5v9l7.5-4.5z",
  pause: "M4.5 3.5h2.5v9h-2.5zM9 3.5h2.5v9h-2.5z",
  undo: "M6.2 2.8 2.6 6.2l3.6 3.4V7.3h2.6a2.5 2.5 0 0 1 0 5H5v1.4h3.8a3.9 3.9 0 0 0 0-7.8H6.2z",
  redo: "M9.8 2.8l3.6 3.4-3.6 3.4V7.3H7.2a2.5 2.5 0 0 0 0 5H11v1.4H7.2a3.9 3.9 0 0 1 0-7.8h2.6z",
  whole: "M2.5 2.5h4v1.4H3.9v2.6H2.5zM9.5 2.5h4v4h-1.4V3.9H9.5zM2.5 9.5h1.4v2.6h2.6v1.4h-4zM12.1 9.5h1.4v4h-4v-1.4h2.6z",
  back: "M4 3.5h1.6v9H4zM12.5 3.5v9L6.3 8z",
  forward: "M10.4 3.5H12v9h-1.6zM3.5 3.5v9L9.7 8z",
  loop: "M5 3h4.5A3.5 3.5 0 0 1 13 6.5V8h-1.4V6.5a2.1 2.1 0 0 0-2.1-2.1H5v2L2.2 3.7 5 1zm6 10H6.5A3.5 3.5 0 0 1 3 9.5V8h1.4v1.5a2.1 2.1 0 0 0 2.1 2.1H11v-2l2.8 2.7L11 15z",
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
