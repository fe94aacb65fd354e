/** Fits that are watched: iterations that follow each other come as differences. */

import { strict as assert } from "node:assert";
import { after, before, describe, test } from "node:test";

import type { Browser } from "playwright-core";

import { Server } from "./server.js";
import { PATIENT, Visit, becomes, browse, until } from "./visit.js";

const COUNT = 10_000;
const POINTS = Array.from({ length: COUNT }, (_, i) => [i, 200 * Math.sin(i / 40) + 90 * Math.sin(i / 7), 150 * Math.cos(i / 90)]);
const CURVE = { name: "many", curve: { points: POINTS }, stop: { tolerance: 0, max_iterations: 30 } };

describe("iterations that follow each other", () => {
  const server = new Server();
  let browser: Browser;
  let id = "";

  before(async () => {
    await server.start();
    browser = await browse();
    id = (await server.job(CURVE)).id;
    await until(async () => (await server.get<{ iteration: number }>(`v1/jobs/${id}`)).iteration === 30, "it is fitted", 120);
  });
  after(async () => {
    await browser?.close();
    await server.stop();
  });

  const streams = ({ sent }: Visit) => sent.filter(({ path }) => /\/events\?.*encoding=delta/.test(path));
  const single = ({ sent }: Visit) => sent.flatMap(({ path }) => /\/iterations\/(\d+)\?.*view=samples/.exec(path)?.[1] ?? []).map(Number);
  const plays = async (visit: Visit) => {
    await visit.whole();
    await visit.page.locator("#play").click();
  };
  const arrives = async (visit: Visit) => {
    await becomes(() => visit.iteration(), [30, 30]);
    // In this time it would be asked for exactly.
    await visit.page.waitForTimeout(1500);
  };

  test("are one stream, of a tenth of the bytes, and its last one is exact", PATIENT, async () => {
    const visit = await Visit.to(browser, `${server.url}#job=${id}&k=0`);
    await plays(visit);
    await arrives(visit);
    const numbers = (await visit.numbers()).map(Number);
    assert.ok(numbers.length > 25, `each is shown: ${numbers}`);
    assert.deepEqual(streams(visit).length, 1);
    // The last one is not asked for once more: that of the stream is exact.
    assert.deepEqual([...new Set(single(visit))], [0]);
    const bytes = async (path: string) => (await (await fetch(`${server.url.slice(0, -1)}${path}`)).arrayBuffer()).byteLength;
    const alone = visit.sent.find(({ path }) => /\/iterations\/0\?.*view=samples/.test(path))!.path;
    const [stream, one] = [await bytes(streams(visit)[0]!.path), await bytes(alone)];
    assert.ok(stream < 5 * one, `${stream} bytes for 30 iterations, ${one} for each alone`);
    await visit.end();
  });

  test("have their control polygon from another one", PATIENT, async () => {
    const visit = await Visit.to(browser, `${server.url}#job=${id}&k=0&show=data,polygon`);
    await plays(visit);
    await arrives(visit);
    assert.deepEqual(streams(visit).map(({ path }) => /view=(\w+)/.exec(path)?.[1]).sort(), ["control_points", "samples"]);
    const nets = visit.sent.flatMap(({ path }) => /\/iterations\/(\d+)\?.*view=control_points/.exec(path)?.[1] ?? []);
    assert.deepEqual([...new Set(nets)], ["0"]);
    await visit.end();
  });

  test("are gone on with when the connection breaks", PATIENT, async () => {
    const visit = await Visit.to(browser, `${server.url}#job=${id}&k=0`);
    // The first stream ends within an event.
    let broken = 0;
    await visit.page.route(/\/events\?.*encoding=delta/, async (route) => {
      if (broken++ > 0) return route.continue();
      const response = await route.fetch();
      const body = await response.body();
      await route.fulfill({ response, body: body.subarray(0, Math.floor(body.length / 3)) });
    });
    await plays(visit);
    await arrives(visit);
    assert.ok(broken >= 2, "it is opened again");
    assert.ok((await visit.numbers()).length > 25, "each is shown");
    assert.deepEqual([...new Set(single(visit))], [0]);
    await visit.end();
  });

  test("are asked for exactly where one stays", PATIENT, async () => {
    const visit = await Visit.to(browser, `${server.url}#job=${id}&k=0`);
    await plays(visit);
    await until(async () => (await visit.iteration())[0] > 5, "it goes on by itself");
    // Which stops it.
    await visit.page.locator("#slider").fill("25");
    await becomes(async () => (await visit.iteration())[0], 25);
    await until(async () => single(visit).includes(25), "it is asked for");
    await visit.page.locator("#slider").fill("3");
    await becomes(async () => (await visit.iteration())[0], 3);
    await until(async () => single(visit).includes(3), "and one that was shown during playback");
    await visit.end();
  });
});
