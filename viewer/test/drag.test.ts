/** Data points and weights that are changed by hand, and the fit that follows. */

import { strict as assert } from "node:assert";
import { after, before, describe, test } from "node:test";

import type { Browser } from "playwright-core";

import { Server } from "./server.js";
import { PATIENT, Visit, browse, says, until } from "./visit.js";

const CURVE = { name: "arch", curve: { points: [[0, 0], [1, 2], [3, 3], [5, 2], [6, 0]] } };

interface Job {
  readonly id: string;
  readonly name: string | null;
  readonly parent?: { id: string };
}

interface Input {
  readonly points?: { index: number; point?: number[]; weight?: number }[];
  readonly ephemeral?: boolean;
  readonly session?: string;
}

describe("a data point", () => {
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

  const open = async (): Promise<[Visit, string]> => {
    const { id } = await server.job(CURVE);
    const visit = await Visit.to(browser, `${server.url}#job=${id}`);
    await visit.standing(/^converged/);
    await visit.still();
    await until(async () => Number.isFinite((await visit.leftmost())[0]), "the data points are drawn");
    return [visit, id];
  };
  const shown = (visit: Visit) => /#job=([\w-]+)/.exec(visit.page.url())?.[1] ?? "";
  const jobs = async () => (await server.get<{ jobs: Job[] }>("v1/jobs")).jobs;
  const edits = (visit: Visit) => visit.sent.flatMap(({ path, body }) => (/\/edits/.test(path) && body !== null ? [JSON.parse(body) as Input] : []));

  test("is dragged: the fit follows, and one edit is kept", PATIENT, async () => {
    const [visit, id] = await open();
    const were = (await jobs()).length;
    const before = await visit.edit();
    const [x, y] = await visit.leftmost();
    const { mouse } = visit.page;
    await mouse.move(x, y);
    await mouse.down();
    let way = 0;
    const further = () => mouse.move(x + 4 * ++way, y - 6 * Math.min(way, 12));
    await until(async () => (await further(), way > 12 && edits(visit).length > 1), "it is asked for while it goes on");
    await until(async () => (await visit.difference(before)) > 0.003, "the curve follows");
    const frames = edits(visit);
    assert.ok(frames.every(({ ephemeral }) => ephemeral === true));
    assert.match(frames[0]!.session ?? "", /^[0-9a-f]{32}$/);
    assert.equal((await jobs()).length, were);
    assert.equal(shown(visit), id);
    await mouse.up();
    await until(async () => shown(visit) !== id, "the edit is shown");
    await visit.standing(/^converged/);
    assert.equal((await jobs()).length, were + 1);
    assert.notEqual(edits(visit).at(-1)!.ephemeral, true);
    const all = await jobs();
    assert.equal(all[0]!.parent?.id, id);
    assert.equal(all[0]!.name, "arch");
    const { curve } = await server.get<{ curve: { points: number[][] } }>(`v1/jobs/${all[0]!.id}/input`);
    assert.notDeepEqual(curve.points[0], CURVE.curve.points[0]);
    assert.deepEqual(curve.points.slice(1), CURVE.curve.points.slice(1));
    await visit.page.keyboard.press("Control+z");
    await until(async () => shown(visit) === id, "it is undone");
    await visit.page.keyboard.press("Control+Shift+Z");
    await until(async () => shown(visit) === all[0]!.id, "it is done again");
    await visit.page.locator("#undo").click();
    await until(async () => shown(visit) === id, "it is undone once more");
    await visit.end();
  });

  test("goes back where it was with Escape", PATIENT, async () => {
    const [visit, id] = await open();
    const before = await visit.edit();
    const [x, y] = await visit.leftmost();
    await visit.page.mouse.move(x, y);
    await visit.page.mouse.down();
    await visit.page.mouse.move(x + 30, y - 60, { steps: 6 });
    await until(async () => (await visit.difference(before, 240)) > 0.001, "the curve follows");
    await visit.page.keyboard.press("Escape");
    await visit.page.mouse.up();
    await visit.page.mouse.move(5, 5);
    // Edges are softer or sharper with WebGL than without, and it may have become the other since.
    await until(async () => (await visit.difference(before, 240)) < 0.0005, "all is as before");
    assert.equal(shown(visit), id);
    await visit.end();
  });

  test("is chosen, and moved and weighted with keys", PATIENT, async () => {
    const [visit, id] = await open();
    const [x, y] = await visit.leftmost();
    await visit.page.mouse.click(x, y);
    const card = visit.page.locator(".card");
    await card.waitFor();
    await says(card, /Point 1/);
    assert.deepEqual(await visit.axe(), []);
    await card.getByLabel("y", { exact: true }).fill("0.5");
    await visit.page.keyboard.press("Enter");
    await until(async () => shown(visit) !== id, "the edit is shown");
    const moved = shown(visit);
    assert.deepEqual(edits(visit).at(-1)?.points, [{ index: 0, point: [0, 0.5] }]);
    await visit.standing(/^converged/);
    await visit.page.locator("canvas").first().focus().catch(() => {});
    await until(async () => Number.isFinite((await visit.leftmost())[0]), "the data points are drawn");
    await visit.page.waitForTimeout(300);
    if (!(await card.isVisible())) await visit.page.mouse.click(...(await visit.leftmost()));
    await card.getByLabel("Weight").focus();
    for (let i = 0; i < 5; i++) await visit.page.keyboard.press("ArrowRight");
    await until(async () => shown(visit) !== moved, "the weight is changed");
    const { curve } = await server.get<{ curve: { weights: number[] } }>(`v1/jobs/${shown(visit)}/input`);
    assert.ok(curve.weights[0]! > 1 && curve.weights[1] === 1);
    await visit.end();
  });
});
