/** A browser that looks at the page, and what it sees. */

import { strict as assert } from "node:assert";
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { join } from "node:path";
import { isDeepStrictEqual } from "node:util";

import { type Browser, type BrowserContext, type BrowserContextOptions, type Locator, type Page, chromium } from "playwright-core";

const CHROMIUM = process.env["CHROMIUM"] ?? "/usr/bin/chromium";
/** With it the page is the one in this directory, not that of the program. */
const VIEWER = process.env["PIAD_VIEWER"];
const AXE = createRequire(import.meta.url).resolve("axe-core/axe.min.js");

/** For each test: busy machines take their time. */
export const PATIENT = { timeout: 180_000 };

/** Without a graphics card: WebGL is drawn by the processor. */
export function browse(flags: readonly string[] = []): Promise<Browser> {
  const args = ["--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu", "--enable-unsafe-swiftshader", ...flags];
  return chromium.launch({ executablePath: CHROMIUM, args });
}

/** What is seen of the viewport. */
export interface Drawn {
  readonly share: number;
  readonly colors: number;
  readonly picture: number;
}

/** A page that is looked at. */
export class Visit {
  readonly page: Page;
  /** What the console said and should not have. */
  readonly complaints: string[] = [];
  /** The requests that went out: method, path, and body. */
  readonly sent: { method: string; path: string; body: string | null }[] = [];

  private constructor(page: Page) {
    this.page = page;
    page.setDefaultTimeout(PATIENT.timeout / 3);
    page.on("console", (message) => {
      // Its own screenshots of WebGL read pixels, which the browser remarks on.
      if (/GL Driver Message \(OpenGL, Performance/.test(message.text())) return;
      if (message.type() === "error" || message.type() === "warning") this.complaints.push(message.text());
    });
    page.on("pageerror", (error) => this.complaints.push(String(error)));
    page.on("request", (request) => {
      const { pathname, search } = new URL(request.url());
      this.sent.push({ method: request.method(), path: `${pathname}${search}`, body: request.postData() });
    });
  }

  static async to(browser: Browser, url: string, options: BrowserContextOptions = {}): Promise<Visit> {
    const context = await browser.newContext({ viewport: { width: 1280, height: 720 }, ...options });
    if (VIEWER !== undefined) await serve(context, VIEWER);
    const visit = new Visit(await context.newPage());
    await visit.page.addInitScript(() => {
      const numbers: string[] = ((globalThis as { numbers?: string[] }).numbers = []);
      new MutationObserver(() => {
        const now = /^(\d+) of/.exec(document.querySelector("#number")?.textContent?.replace(/\u202f/g, "") ?? "")?.[1];
        if (now !== undefined && now !== numbers.at(-1)) numbers.push(now);
      }).observe(document, { subtree: true, childList: true, characterData: true });
    });
    await visit.page.goto(url);
    return visit;
  }

  /** Closes the page, about which the console had nothing to say. */
  async end(): Promise<void> {
    await this.page.context().close();
    assert.deepEqual(this.complaints, []);
  }

  /** Waits until the first fit stands like this: /converged/. */
  async standing(pattern: RegExp): Promise<string> {
    const state = this.page.locator(".label .state").first();
    await until(async () => pattern.test((await state.textContent()) ?? ""), `the state is ${pattern}`);
    return (await state.textContent()) ?? "";
  }

  /** Waits until the panels and WebGL are there, after which the page asks for no more of itself. */
  async whole(): Promise<void> {
    await until(() => this.page.evaluate(() => performance.getEntriesByName("first picture of WebGL").length > 0), "WebGL is there");
  }

  /** Waits until the page is whole, and nothing moves any more. */
  async still(): Promise<Drawn> {
    await this.whole();
    let drawn = await this.drawn();
    await until(async () => {
      await this.page.waitForTimeout(300);
      const before = drawn;
      drawn = await this.drawn();
      return (await this.difference(before)) === 0;
    }, "nothing moves");
    return drawn;
  }

  /** Begins the Edit mode, and waits until it is seen; the picture. By the button: after a key the focus would be drawn, until the next click. */
  async edit(): Promise<Drawn> {
    const button = this.page.getByRole("button", { name: "Edit", exact: true });
    await button.click();
    await becomes(() => button.getAttribute("aria-pressed"), "true");
    return this.still();
  }

  /** Presses an element for a tenth of a second, as hands do: with the mouse, or with a finger. */
  async press(element: Locator, isTouch = false): Promise<void> {
    await element.scrollIntoViewIfNeeded();
    const { x, y, width, height } = (await element.boundingBox())!;
    await this.pressAt(x + width / 2, y + height / 2, isTouch);
  }

  /** The same at a place of the page. */
  async pressAt(x: number, y: number, isTouch = false): Promise<void> {
    const { page } = this;
    if (!isTouch) {
      await page.mouse.move(x, y);
      await page.mouse.down();
      await page.waitForTimeout(100);
      return page.mouse.up();
    }
    const session = await page.context().newCDPSession(page);
    await session.send("Input.dispatchTouchEvent", { type: "touchStart", touchPoints: [{ x, y }] });
    await page.waitForTimeout(100);
    await session.send("Input.dispatchTouchEvent", { type: "touchEnd", touchPoints: [] });
    await session.detach();
  }

  /** Drops a file on the scene. */
  async drop(name: string, text: string): Promise<void> {
    await this.page.evaluate(
      ([title, content]) => {
        const data = new DataTransfer();
        data.items.add(new File([content!], title!));
        for (const type of ["dragover", "drop"]) document.querySelector("#viewport")!.dispatchEvent(new DragEvent(type, { dataTransfer: data, bubbles: true, cancelable: true }));
      },
      [name, text],
    );
  }

  /** Opens all fields of the form. */
  async advanced(): Promise<void> {
    await this.page.locator("details.advanced").evaluate((details: HTMLDetailsElement) => void (details.open = true));
  }

  /** How many jobs were asked for. */
  posted(): number {
    return this.sent.filter(({ method, path }) => method === "POST" && path.endsWith("/v1/jobs")).length;
  }

  /** The numbers of the iterations that were shown, since the page was opened. */
  numbers(): Promise<string[]> {
    return this.page.evaluate(() => (globalThis as { numbers?: string[] }).numbers ?? []);
  }

  /** The number of the iteration that is shown, and of the last. */
  async iteration(): Promise<[number, number]> {
    const text = ((await this.page.locator("#number").textContent()) ?? "").replace(/\u202f/g, "");
    const [, shown, last] = /^(\d+) of (\d+)$/.exec(text) ?? [];
    return [Number(shown), Number(last)];
  }

  /** How many pixels of the viewport are not as paper, as a part of all, in how many colours; the page keeps the picture. */
  async drawn(): Promise<Drawn> {
    const shot = await this.page.locator("#viewport").screenshot();
    return this.page.evaluate(async (base64) => {
      const image = await createImageBitmap(new Blob([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))], { type: "image/png" }));
      const context = new OffscreenCanvas(image.width, image.height).getContext("2d")!;
      context.drawImage(image, 0, 0);
      const { data } = context.getImageData(0, 0, image.width, image.height);
      const colors = new Set<number>();
      const end = data.length - 4;
      let other = 0;
      for (let i = 0; i < data.length; i += 4) {
        if (Math.abs(data[i]! - data[end]!) + Math.abs(data[i + 1]! - data[end + 1]!) + Math.abs(data[i + 2]! - data[end + 2]!) <= 12) continue;
        other++;
        colors.add((data[i]! >> 4) * 256 + (data[i + 1]! >> 4) * 16 + (data[i + 2]! >> 4));
      }
      const pictures = ((globalThis as { pictures?: Uint8ClampedArray[] }).pictures ??= []);
      return { share: other / (data.length / 4), colors: colors.size, picture: pictures.push(data) - 1 };
    }, shot.toString("base64"));
  }

  /** How many pixels are others than in a picture before, as a part of all; how far apart, as a sum of red, green and blue. */
  async difference(before: Drawn, apart = 12): Promise<number> {
    await this.drawn();
    return this.page.evaluate(([a, apart]) => {
      const { pictures } = globalThis as unknown as { pictures: Uint8ClampedArray[] };
      const [x, y] = [pictures[a]!, pictures.pop()!];
      let other = 0;
      for (let i = 0; i < x.length; i += 4) {
        if (Math.abs(x[i]! - y[i]!) + Math.abs(x[i + 1]! - y[i + 1]!) + Math.abs(x[i + 2]! - y[i + 2]!) > apart) other++;
      }
      return other / (x.length / 4);
    }, [before.picture, apart] as const);
  }

  /** The middle of the first data point from the left, below what is written, in pixels of the page; those of surfaces are paler. */
  async leftmost(pale = 14): Promise<[number, number]> {
    const box = (await this.page.locator("#viewport").boundingBox())!;
    const shot = await this.page.locator("#viewport").screenshot();
    const [x, y] = await this.page.evaluate(async ([base64, pale]) => {
      const image = await createImageBitmap(new Blob([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))], { type: "image/png" }));
      const context = new OffscreenCanvas(image.width, image.height).getContext("2d")!;
      context.drawImage(image, 0, 0);
      const top = 110;
      const { data, width, height } = context.getImageData(0, top, image.width, image.height - top);
      const ink = (getComputedStyle(document.body).color.match(/\d+/g) ?? []).map(Number);
      const isInk = (x: number, y: number) => ink.every((value, i) => Math.abs(data[(y * width + x) * 4 + i]! - value) < pale);
      // Within the frame of the Edit mode.
      const frame = 4;
      for (let x = frame; x < width; x++) {
        for (let y = 0; y < height - frame; y++) if (isInk(x, y)) return [x + 2, y + top];
      }
      return [NaN, NaN];
    }, [shot.toString("base64"), pale] as const);
    return [box.x + x!, box.y + y!];
  }

  /** What axe-core finds wrong, each with an element. */
  async axe(): Promise<string[]> {
    await this.page.evaluate(`(() => { ${await readFile(AXE, "utf8")} })()`);
    return this.page.evaluate(async () => {
      const { axe } = globalThis as unknown as { axe: { run(): Promise<{ violations: { id: string; nodes: { html: string }[] }[] }> } };
      const { violations } = await axe.run();
      return violations.map(({ id, nodes }) => `${id}: ${nodes[0]?.html}`);
    });
  }
}

/** Serves the page from a directory, with the headers of the server. */
async function serve(context: BrowserContext, directory: string): Promise<void> {
  await context.route(/\/viewer\/[\w.-]+$/, async (route) => {
    const name = route.request().url().split("/").at(-1)!;
    const contentType = name.endsWith(".css") ? "text/css" : "text/javascript";
    await route.fulfill({ contentType, body: await readFile(join(directory, name)) });
  });
  await context.route(({ pathname }) => pathname.endsWith("/"), async (route) => {
    if (route.request().resourceType() !== "document") return route.fallback();
    const response = await route.fetch();
    await route.fulfill({ response, body: await readFile(join(directory, "index.html")) });
  });
}

/** Waits until an element says it; some say what they have to say in the frame after. */
export async function says(element: Locator, pattern: RegExp): Promise<void> {
  let said = "";
  const matches = async () => pattern.test((said = (await element.first().textContent({ timeout: 1000 }).catch(() => null)) ?? ""));
  await until(matches, `${element} says ${pattern}`).catch((error: unknown) => assert.fail(`${String(error)}: it says "${said}"`));
}

/** Waits until a value is as expected. */
export async function becomes<T>(value: () => Promise<T>, expected: T): Promise<void> {
  let now: T | undefined;
  const holds = async () => isDeepStrictEqual((now = await value()), expected);
  await until(holds, "it is as expected").catch(() => assert.deepEqual(now, expected));
}

/** Waits until something holds; so long that busy machines get there, too. */
export async function until(holds: () => Promise<boolean>, what: string, seconds = 40): Promise<void> {
  const end = Date.now() + seconds * 1000;
  while (!(await holds())) {
    if (Date.now() > end) throw new Error(`it has not come to be that ${what}`);
    await new Promise((resolve) => setTimeout(resolve, 25));
  }
}
