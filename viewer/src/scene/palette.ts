/** The colours of the style sheet, for shaders and charts. */

import { Color } from "three";

const NAMES = ["paper", "ink", "soft", "line", "accent", "light", "shade", "deep", "net", "series-1", "series-2", "series-3", "series-4"] as const;

/** How many colours the scale of distances has. */
export const HEAT = 5;

export interface Palette {
  readonly css: Readonly<Record<(typeof NAMES)[number], string>>;
  readonly color: Readonly<Record<(typeof NAMES)[number], Color>>;
  /** From near to far. */
  readonly heat: readonly Color[];
  readonly isDark: boolean;
}

/** Reads the colours as they are now. */
export function palette(): Palette {
  const style = getComputedStyle(document.documentElement);
  const value = (name: string) => style.getPropertyValue(`--${name}`).trim();
  const css = Object.fromEntries(NAMES.map((name) => [name, value(name)])) as Palette["css"];
  const color = Object.fromEntries(NAMES.map((name) => [name, new Color(css[name])])) as Palette["color"];
  const heat = Array.from({ length: HEAT }, (_, i) => new Color(value(`heat-${i}`)));
  return { css, color, heat, isDark: matchMedia("(prefers-color-scheme: dark)").matches };
}

/** The colour of a job among those side by side. */
export function seriesColor<T>(colors: Readonly<Record<string, T>>, index: number): T {
  return colors[`series-${(index % 4) + 1}`] as T;
}

/** Calls when the colours have changed. */
export function onPalette(listener: () => void): void {
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", listener);
}
