/** What is seen at once, and every iteration of it. */

import { strict as assert } from "node:assert";
import { once } from "node:events";
import { createServer } from "node:http";
import type { AddressInfo } from "node:net";
import { after, before, describe, test } from "node:test";

import type { Browser, Route } from "playwright-core";

import { Server } from "./server.js";
import { PATIENT, type Drawn, Visit, becomes, browse, says, until } from "./visit.js";

const CURVE = { name: "arch", curve: { points: [[0, 0], [1, 2], [3, 3], [5, 2], [6, 0]] } };

describe("the page", () => {
  const server = new Server();
  let browser: Browser;

  before(async () => {
    await server.start();
    browser = await browse();
  });
  after(async () => {
    await browser?.close();
    await server.stop();
  });

  test("shows an example that is fitted while one looks", PATIENT, async () => {
    const visit = await Visit.to(browser, server.url);
    await visit.standing(/^(running|converged)/);
    await until(async () => (await visit.drawn()).share > 0.05, "something is drawn");
    await visit.standing(/^converged in \d+ iterations/);
    await until(async () => (await visit.numbers()).length > 2, "the iterations go by");
    await until(async () => (await visit.drawn()).colors > 20, "a surface has shades");
    assert.match(visit.page.url(), /#job=[0-9a-f-]{36}/);
    assert.equal(visit.sent.filter(({ method, path }) => method === "POST" && path === "/v1/jobs").length, 1);
    await visit.end();
  });

  test("links to documents that the server has", PATIENT, async () => {
    const visit = await Visit.to(browser, server.url);
    const links = await visit.page.locator("#about a").evaluateAll((all) => all.map((link) => (link as HTMLAnchorElement).href));
    assert.deepEqual(links, [`${server.url}docs`, `${server.url}openapi.json`]);
    for (const link of links) assert.equal((await fetch(link)).status, 200, link);
    await visit.end();
  });

  test("the same example is the same job", PATIENT, async () => {
    const { jobs: was } = await server.get<{ jobs: unknown[] }>("v1/jobs");
    const visit = await Visit.to(browser, server.url);
    await visit.standing(/^converged/);
    const { jobs: now } = await server.get<{ jobs: unknown[] }>("v1/jobs");
    assert.equal(now.length, was.length);
    await visit.end();
  });

  test("opens the job and the iteration of a link, and writes them there", PATIENT, async () => {
    const { id } = await server.job(CURVE);
    const visit = await Visit.to(browser, `${server.url}#job=${id}&k=2`);
    await visit.standing(/^converged/);
    await becomes(() => visit.page.locator(".label h2").textContent(), "arch");
    await becomes(async () => (await visit.iteration())[0], 2);
    await visit.page.keyboard.press("ArrowRight");
    await until(async () => visit.page.url().endsWith("&k=3"), "the link has the iteration");
    await visit.end();
  });

  test("goes through the iterations by keys, by the slider and by itself", PATIENT, async () => {
    const { id } = await server.job({ ...CURVE, method: "transpose", stop: { tolerance: 1e-12, max_iterations: 150 } });
    const visit = await Visit.to(browser, `${server.url}#job=${id}&k=0`);
    await visit.standing(/in 150 iterations/);
    await until(async () => (await visit.iteration())[1] > 5, "the iterations have come");
    const [, last] = await visit.iteration();
    const first = await visit.drawn();
    await visit.page.keyboard.press("End");
    await becomes(() => visit.iteration(), [last, last]);
    await until(async () => (await visit.difference(first)) > 0.002, "the curve is another");
    await visit.page.keyboard.press("ArrowLeft");
    await until(async () => (await visit.iteration())[0] === last - 1, "one less is shown");
    await visit.page.keyboard.press("Home");
    await until(async () => (await visit.iteration())[0] === 0, "the first is shown");
    await visit.page.locator("#slider").fill("4");
    await becomes(async () => (await visit.iteration())[0], 4);
    await visit.page.locator("#play").click();
    await until(async () => (await visit.iteration())[0] > 5, "it goes on by itself");
    await visit.page.locator("#play").click();
    const [stopped] = await visit.iteration();
    await visit.page.waitForTimeout(800);
    await becomes(async () => (await visit.iteration())[0], stopped);
    await visit.end();
  });

  test("names the errors of each iteration", PATIENT, async () => {
    const { id } = await server.job(CURVE);
    const level = await server.get<{ error: { max: number } }>(`v1/jobs/${id}/iterations/0?view=errors`);
    const visit = await Visit.to(browser, `${server.url}#job=${id}&k=0`);
    await visit.standing(/^converged/);
    const said = async () => Number(await visit.page.locator("#facts dd").first().textContent());
    await until(async () => Math.abs((await said()) - level.error.max) < 0.01 * level.error.max, `the error is ${level.error.max}`);
    await until(async () => /tolerance is/.test((await visit.page.locator(".plot").getAttribute("aria-label")) ?? ""), "the chart is told");
    const dark = () =>
      visit.page.locator(".plot canvas").evaluate((canvas: HTMLCanvasElement) => {
        const { data } = canvas.getContext("2d")!.getImageData(0, 0, canvas.width, canvas.height);
        return data.filter((value, i) => i % 4 === 3 && value > 128).length;
      });
    await until(async () => (await dark()) > 500, "the chart has lines");
    await visit.end();
  });

  test("works behind a prefix", PATIENT, async () => {
    const proxy = createServer(async (request, response) => {
      const chunks: Uint8Array[] = [];
      for await (const chunk of request) chunks.push(chunk as Uint8Array);
      const path = request.url!.replace(/^\/tools\/fits\//, "");
      if (path === request.url) return void response.writeHead(404).end();
      const headers = { accept: request.headers.accept ?? "*/*", ...(chunks.length > 0 && { "content-type": "application/json" }) };
      const answer = await fetch(`${server.url}${path}`, { method: request.method!, headers, ...(chunks.length > 0 && { body: Buffer.concat(chunks) }) });
      response.writeHead(answer.status, { "content-type": answer.headers.get("content-type") ?? "" });
      response.end(Buffer.from(await answer.arrayBuffer()));
    }).listen(0, "127.0.0.1");
    await once(proxy, "listening");
    try {
      const visit = await Visit.to(browser, `http://127.0.0.1:${(proxy.address() as AddressInfo).port}/tools/fits/`);
      await visit.standing(/^converged/);
      await until(async () => (await visit.drawn()).share > 0.02, "it is drawn");
      assert.ok(visit.sent.every(({ path }) => path.startsWith("/tools/fits/") || path === ""));
      await visit.end();
    } finally {
      proxy.close();
    }
  });

  test("follows a link while iterations run by", PATIENT, async () => {
    const { id } = await server.job({ ...CURVE, name: "other" });
    const visit = await Visit.to(browser, server.url);
    await until(async () => (await visit.iteration())[0] > 0, "the iterations go by");
    await visit.page.evaluate((hash) => (location.hash = hash), `#job=${id}&k=1`);
    const title = visit.page.locator(".label h2");
    await until(async () => (await title.textContent()) === "other", "the other is shown");
    await until(async () => (await visit.iteration())[0] === 1, "it is shown at the iteration of the link");
    await visit.end();
  });

  test("goes back to the job before", PATIENT, async () => {
    const [one, other] = [await server.job(CURVE), await server.job({ ...CURVE, name: "other" })];
    const visit = await Visit.to(browser, `${server.url}#job=${one.id}`);
    await visit.standing(/^converged/);
    await visit.page.evaluate((hash) => (location.hash = hash), `#job=${other.id}`);
    const title = visit.page.locator(".label h2");
    await until(async () => (await title.textContent()) === "other", "the other is shown");
    await visit.page.goBack();
    await until(async () => (await title.textContent()) === "arch", "the first is shown again");
    await visit.end();
  });

  test("says when there is no such job", PATIENT, async () => {
    const visit = await Visit.to(browser, `${server.url}#job=01a20965-d4dd-75e8-902b-45b708e30e33`);
    const announcer = visit.page.locator("#announcer[data-said]");
    await announcer.waitFor();
    await says(announcer, /^There is no job 01a20965/);
    // The browser itself writes there what was not found.
    assert.ok(visit.complaints.every((line) => /404/.test(line)));
    visit.complaints.length = 0;
    await visit.end();
  });

  test("goes on when the server can be reached again", PATIENT, async () => {
    const [one, other] = [await server.job(CURVE), await server.job({ ...CURVE, name: "other" })];
    const visit = await Visit.to(browser, `${server.url}#job=${one.id}`);
    await visit.standing(/^converged/);
    await visit.still();
    await visit.page.context().setOffline(true);
    await visit.page.evaluate((hash) => (location.hash = hash), `#job=${other.id}`);
    const announcer = visit.page.locator("#announcer[data-kind=error]");
    await announcer.waitFor();
    await says(announcer, /cannot be reached/);
    await visit.page.context().setOffline(false);
    await visit.standing(/^converged/);
    await becomes(() => visit.page.locator(".label h2").textContent(), "other");
    await until(async () => (await visit.drawn()).share > 0.005, "it is drawn");
    assert.ok(visit.complaints.every((line) => /ERR_INTERNET_DISCONNECTED/.test(line)));
    visit.complaints.length = 0;
    await visit.end();
  });

  test("samples more finely where one comes nearer", PATIENT, async () => {
    const points = Array.from({ length: 8 }, (_, i) => Array.from({ length: 8 }, (_, j) => [i, j, Math.sin(i) * Math.cos(j)]));
    const { id } = await server.job({ name: "near", surface: { points } });
    const visit = await Visit.to(browser, `${server.url}#job=${id}`);
    await visit.standing(/^converged/);
    const counts = () => visit.sent.flatMap(({ path }) => /samples=(\d+)x\d+/.exec(path)?.[1] ?? []).map(Number);
    await until(async () => counts().length > 0, "the surface is sampled");
    const [whole] = counts();
    for (let i = 0; i < 8; i++) await visit.page.keyboard.press("+");
    await until(async () => Math.max(...counts()) > whole!, "there are more samples");
    await visit.end();
  });

  test("does nothing while nobody does anything", PATIENT, async () => {
    const { id } = await server.job(CURVE);
    const visit = await Visit.to(browser, `${server.url}#job=${id}`);
    await visit.standing(/^converged/);
    await visit.page.evaluate(() => {
      const real = globalThis.requestAnimationFrame;
      const counted = globalThis as unknown as { asked: number };
      counted.asked = 0;
      globalThis.requestAnimationFrame = (callback) => (counted.asked++, real(callback));
    });
    // What is still on its way is drawn once it is there.
    await until(async () => {
      const asked = (): Promise<number> => visit.page.evaluate(() => (globalThis as unknown as { asked: number }).asked);
      const before = await asked();
      await visit.page.waitForTimeout(500);
      return (await asked()) === before;
    }, "no frame is asked for within half a second");
    const atRest = await visit.page.evaluate(() => (globalThis as unknown as { asked: number }).asked);
    await visit.page.waitForTimeout(1000);
    assert.equal(await visit.page.evaluate(() => (globalThis as unknown as { asked: number }).asked), atRest);
    await visit.end();
  });

  test("has a picture before panels and WebGL are there", PATIENT, async () => {
    const { id } = await server.job(CURVE);
    const visit = await Visit.to(browser, "about:blank");
    const held: Route[] = [];
    const later = /\/(sidebar|webgl)\.js$/;
    let isHeld = true;
    await visit.page.route(later, (route) => (isHeld ? void held.push(route) : route.fallback()));
    await visit.page.goto(`${server.url}#job=${id}`, { waitUntil: "commit" });
    await until(async () => (await visit.page.evaluate(() => performance.getEntriesByName("first picture").length)) > 0, "there is a picture");
    assert.ok((await visit.drawn()).share > 0.005, "it is drawn");
    await until(async () => held.length > 0, "the rest is asked for");
    assert.equal(await visit.page.locator(".field").count(), 0);
    isHeld = false;
    for (const route of held) await route.fallback();
    await visit.page.locator(".field").first().waitFor();
    await visit.end();
  });
});

test("without WebGL the page says so, and the rest of it works", PATIENT, async () => {
  const server = await new Server().start();
  const browser = await browse(["--disable-gpu", "--disable-3d-apis", "--disable-webgl"]);
  try {
    const visit = await Visit.to(browser, server.url);
    await visit.page.locator(".plainly").waitFor();
    await says(visit.page.locator(".plainly"), /no WebGL/);
    const isShaded = ({ share, colors }: Drawn) => share > 0.05 && colors > 20;
    await until(async () => isShaded(await visit.drawn()), "a surface is drawn all the same");
    await until(async () => (await visit.iteration())[1] > 5, "the iterations are counted");
    await visit.standing(/^converged/);
    await until(async () => (await visit.numbers()).at(-1) === String((await visit.iteration())[1]), "the last is shown");
    const before = await visit.drawn();
    const { x, y, height } = (await visit.page.locator("#viewport").boundingBox())!;
    await visit.page.mouse.move(x + 20, y + height / 2);
    await visit.page.mouse.down();
    await visit.page.mouse.move(x + 120, y + height / 2 + 40, { steps: 5 });
    await visit.page.mouse.up();
    await until(async () => (await visit.difference(before)) > 0.02, "it is turned");
  } finally {
    await browser.close();
    await server.stop();
  }
});
