/** The pictures of the README: the page as it is, light and dark. `make pictures` writes them. */

import { mkdir, writeFile } from "node:fs/promises";
import { fileURLToPath } from "node:url";

import type { Browser } from "playwright-core";
import sharp from "sharp";

import { Server } from "./server.js";
import { Visit, browse, until } from "./visit.js";

const TO = fileURLToPath(new URL("../../docs/pictures/", import.meta.url));
const VIEWPORT = { width: 1280, height: 720 };
const SCHEMES = ["light", "dark"] as const;

type Scene = (visit: Visit, server: Server) => Promise<void>;

const numbers = (count: number) => Array.from({ length: count }, (_, i) => i);

/** A square with ripples, whose corners methods reach at different speeds. */
const POINTS = numbers(40).map((i) => {
  const t = (i / 40) * 2 * Math.PI;
  const r = 1 + 0.32 * Math.cos(4 * t) + 0.08 * Math.cos(12 * t);
  return [1.5 * r * Math.cos(t), r * Math.sin(t)];
});

/** What programs for matrices show first. */
const HILLS = numbers(25).map((i) => numbers(25).map((j) => [(i - 12) / 4, (j - 12) / 4, height((i - 12) / 4, (j - 12) / 4)]));

function height(x: number, y: number): number {
  const [a, b, c] = [x * x + (y + 1) ** 2, x * x + y * y, (x + 1) ** 2 + y * y].map((q) => Math.exp(-q)) as [number, number, number];
  return (1 - x) ** 2 * a - (10 / 3) * (x / 5 - x ** 3 - y ** 5) * b - c / 9;
}

const SCENES: Readonly<Record<string, Scene>> = {
  /** What one sees who has opened the page. */
  opening: async (visit, server) => {
    await visit.page.goto(server.url);
    await settled(visit);
  },
  /** How far a surface is from its data after as many iterations. */
  errors: async (visit, server) => {
    const { id } = await server.job({ name: "Hills", surface: { points: HILLS }, stop: { tolerance: 5e-4 } });
    await visit.page.goto(`${server.url}#job=${id}&k=2&show=heat`);
    await settled(visit);
  },
  /** Four methods after as many iterations. */
  compare: async (visit, server) => {
    const kinds = ["global", "weighted", "chebyshev", "least_squares"];
    const method = (kind: string) => (kind === "least_squares" ? { kind, control_points: 14 } : { kind });
    const jobs = await Promise.all(kinds.map((kind) => server.job({ name: kind.replace("_", " "), curve: { points: POINTS, closed: true }, method: method(kind) })));
    await visit.page.goto(`${server.url}#job=${jobs.map(({ id }) => id).join()}&k=2&show=data,spikes`);
    await settled(visit);
  },
  /** A data point in somebody's hand, with the curvature of what follows it. */
  drag: async (visit, server) => {
    const { id } = await server.job({ name: "Under the pointer", curve: { points: POINTS, closed: true } });
    await visit.page.goto(`${server.url}#job=${id}&show=data,comb`);
    await settled(visit);
    await visit.page.keyboard.press("e");
    const before = await visit.drawn();
    const [x, y] = await visit.leftmost();
    await visit.page.mouse.move(x, y);
    await visit.page.mouse.down();
    await visit.page.mouse.move(x - 60, y - 70, { steps: 8 });
    await until(async () => (await visit.difference(before)) > 0.01, "the curve follows");
    await visit.page.waitForTimeout(600);
  },
};

/** Waits until all has been drawn and nothing moves. */
async function settled(visit: Visit): Promise<void> {
  await visit.standing(/converged/);
  await visit.still();
}

/** Takes a picture of a scene, and gives its size in bytes. */
async function take(browser: Browser, server: Server, name: string, colorScheme: (typeof SCHEMES)[number]): Promise<number> {
  const visit = await Visit.to(browser, "about:blank", { viewport: VIEWPORT, colorScheme });
  await SCENES[name]!(visit, server);
  // Few colours are enough for what is paper, ink and one shaded surface.
  const png = await sharp(await visit.page.screenshot()).png({ palette: true, colours: 160, dither: 0.6, effort: 10, compressionLevel: 9 }).toBuffer();
  await writeFile(`${TO}${name}-${colorScheme}.png`, png);
  await visit.page.context().close();
  return png.length;
}

await mkdir(TO, { recursive: true });
const server = await new Server().start();
const browser = await browse();
try {
  for (const name of Object.keys(SCENES)) {
    for (const scheme of SCHEMES) console.log(`docs/pictures/${name}-${scheme}.png: ${Math.round((await take(browser, server, name, scheme)) / 1000)} kB`);
  }
} finally {
  await browser.close();
  await server.stop();
}
