/** Files that are dropped: drawn at once, understood, and fitted by what the data are. */

import { strict as assert } from "node:assert";
import { after, before, describe, test } from "node:test";

import type { Browser } from "playwright-core";

import { Server } from "./server.js";
import { PATIENT, Visit, becomes, browse, says, until } from "./visit.js";

/** Numbers that look like chance and are the same each time. */
function chance(seed: number): () => number {
  let state = seed;
  return () => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32 - 0.5;
}

const numbers = (count: number) => Array.from({ length: count }, (_, i) => i);
const tremble = chance(7);
const FILES = {
  few: "0,0\n1,2\n3,3\n5,2\n6,0\n",
  many: `x,y,speed\n${numbers(900).map((i) => `${i / 90},${Math.sin(i / 90)},${i}`).join("\n")}`,
  noisy: `x,y\n${numbers(300).map((i) => `${i / 30},${Math.sin(i / 30) + 0.1 * tremble()}`).join("\n")}`,
  scan: numbers(900).map(() => [tremble() * 4, tremble() * 3]).map(([x, y]) => `${x!.toFixed(4)} ${y!.toFixed(4)} ${(Math.sin(x!) * Math.cos(y!) + 0.01 * tremble()).toFixed(4)}`).join("\n"),
  parts: numbers(3).map((k) => numbers(20 + k).map((i) => `${i / 5},${k + Math.sin(i / 5 + k)}`).join("\n")).join("\n\n"),
};

interface Request {
  readonly method?: { kind: string; control_points?: unknown; fairness?: unknown; robust?: boolean };
  readonly stop?: { tolerance?: number; relative_tolerance?: number };
  readonly curve?: { points: number[][]; closed?: boolean; order?: string; corners?: unknown; polyline?: boolean };
  readonly surface?: { scattered?: number[][]; trim?: unknown; creases?: unknown };
}

describe("a file that is dropped", () => {
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

  const open = async (): Promise<Visit> => {
    const { id } = await server.job({ name: "arch", curve: { points: [[0, 0], [1, 2], [3, 3], [5, 2], [6, 0]] } });
    const visit = await Visit.to(browser, `${server.url}#job=${id}`, { viewport: { width: 1280, height: 1000 } });
    await visit.standing(/^converged/);
    await visit.page.locator(".presets").waitFor();
    return visit;
  };
  const last = (visit: Visit): Request => JSON.parse(visit.sent.filter(({ method, path }) => method === "POST" && path === "/v1/jobs").at(-1)?.body ?? "{}") as Request;
  const dropped = async (visit: Visit, name: keyof typeof FILES): Promise<Request> => {
    const posted = visit.posted();
    await visit.drop(`${name}.csv`, FILES[name]);
    await until(async () => visit.posted() > posted, "it is fitted");
    return last(visit);
  };
  const preset = (visit: Visit) => visit.page.evaluate(() => document.querySelector<HTMLInputElement>(".presets :checked")?.value);
  /** Ends a visit in which the server was asked what it does not take. */
  const end = async (visit: Visit) => {
    visit.complaints.splice(0, Infinity, ...visit.complaints.filter((line) => !/422/.test(line)));
    await visit.end();
  };

  test("of few points is fitted through them", PATIENT, async () => {
    const visit = await open();
    const { method, curve } = await dropped(visit, "few");
    assert.deepEqual([method, curve?.points.length], [undefined, 5]);
    await becomes(() => preset(visit), "through");
    await becomes(() => visit.page.locator(".label h2").textContent(), "few");
    await visit.standing(/^converged/);
    await end(visit);
  });

  test("of many points is fitted within a tolerance, and says which columns were read", PATIENT, async () => {
    const visit = await open();
    const { method, stop } = await dropped(visit, "many");
    assert.deepEqual([method, stop], [{ kind: "least_squares", control_points: "auto" }, { relative_tolerance: 1e-3 }]);
    await becomes(() => preset(visit), "within");
    await says(visit.page.locator(".data"), /column 3 \(speed\) is not read/);
    const posted = visit.posted();
    await visit.page.getByLabel("Columns", { exact: true }).fill("x=1,y=3");
    await visit.page.getByLabel("Columns", { exact: true }).press("Tab");
    await until(async () => visit.posted() > posted, "it is fitted with other columns");
    assert.equal(last(visit).curve!.points[10]![1], 10);
    assert.deepEqual(last(visit).method, method);
    assert.deepEqual(await visit.axe(), []);
    await end(visit);
  });

  test("that is noisy is smoothed, and another preset fits it again", PATIENT, async () => {
    const visit = await open();
    const { method } = await dropped(visit, "noisy");
    assert.equal(method?.fairness, "auto");
    await becomes(() => preset(visit), "smooth");
    const posted = visit.posted();
    await visit.press(visit.page.getByText("Through the points"));
    await until(async () => visit.posted() === posted + 1, "it is fitted again");
    assert.equal(last(visit).method, undefined);
    await end(visit);
  });

  test("of a noisy measurement can have outliers, which another preset leaves out, too", PATIENT, async () => {
    const visit = await open();
    await dropped(visit, "noisy");
    const outliers = visit.page.getByLabel(/^Leave out outliers/);
    await visit.press(outliers);
    await until(async () => last(visit).method?.robust === true, "they are left out");
    assert.equal(last(visit).method?.fairness, "auto");
    await becomes(() => preset(visit), "smooth");
    await visit.press(visit.page.getByText("Within a tolerance"));
    await until(async () => last(visit).method?.control_points === "auto", "it is fitted within a tolerance");
    assert.equal(last(visit).method?.robust, true);
    await becomes(() => outliers.isChecked(), true);
    await end(visit);
  });

  test("can turn at corners, have straight edges, and creases", PATIENT, async () => {
    const visit = await open();
    await dropped(visit, "few");
    await visit.press(visit.page.getByLabel(/^Turn at corners/));
    await until(async () => last(visit).curve?.corners === "auto", "it turns");
    await visit.press(visit.page.getByText("Within a tolerance"));
    await visit.press(visit.page.getByLabel(/^Straight edges/));
    await until(async () => last(visit).curve?.polyline === true, "its edges are fitted");
    await visit.standing(/^converged/);
    await visit.press(visit.page.getByText("Smooth a noisy"));
    await until(async () => last(visit).method?.fairness === "auto", "it is smoothed");
    assert.deepEqual([last(visit).curve?.corners, last(visit).curve?.polyline], [undefined, undefined]);
    await visit.drop("roof.json", JSON.stringify({ surface: { points: numbers(9).map((i) => numbers(5).map((j) => [i, j, Math.abs(i - 4) + j / 9])) } }));
    await visit.page.getByLabel("Creases along rows").fill("5");
    await visit.page.getByLabel("Creases along rows").press("Tab");
    await until(async () => last(visit).surface?.creases !== undefined, "it has a crease");
    assert.deepEqual(last(visit).surface!.creases, { u: [4] });
    await visit.standing(/^converged/);
    assert.deepEqual(await visit.axe(), []);
    await end(visit);
  });

  test("of a scan becomes a trimmed surface, and can be a curve", PATIENT, async () => {
    const visit = await open();
    const { surface } = await dropped(visit, "scan");
    assert.deepEqual([surface?.scattered?.length, surface?.trim], [900, true]);
    await becomes(() => preset(visit), "scan");
    await says(visit.page.locator(".data"), /no order along a curve/);
    await becomes(() => visit.page.locator("input[value=through]").isDisabled(), true);
    await visit.standing(/^(converged|stalled|not yet)/);
    await says(visit.page.locator(".label"), /trimmed to the data: 1 piece/);
    const posted = visit.posted();
    await visit.page.getByLabel("Fit as").selectOption({ label: "Curve, in given order" });
    await until(async () => visit.posted() > posted, "it is fitted as a curve");
    assert.equal(last(visit).curve?.points.length, 900);
    await end(visit);
  });

  test("with several curves shows the first, any other, and all in one scene", PATIENT, async () => {
    const visit = await open();
    assert.equal((await dropped(visit, "parts")).curve?.points.length, 20);
    const part = visit.page.getByLabel("Part", { exact: true });
    await part.selectOption("2");
    await until(async () => last(visit).curve?.points.length === 21, "the second one is fitted");
    await part.selectOption({ label: "All 3" });
    await until(async () => (await visit.page.locator(".label").count()) === 3, "all are there");
    await becomes(() => visit.page.getByRole("button", { name: "Overlay" }).getAttribute("aria-pressed"), "true");
    await until(async () => (await visit.drawn()).share > 0.01, "they are drawn");
    assert.match(visit.page.url(), /overlaid/);
    await end(visit);
  });

  test("is drawn before it is fitted, and when it cannot be fitted", PATIENT, async () => {
    const visit = await open();
    let release = () => {};
    const held = new Promise<void>((resolve) => (release = resolve));
    await visit.page.route("**/v1/jobs", async (route) => {
      await held;
      await route.continue();
    });
    await visit.drop("few.csv", FILES.few);
    await says(visit.page.locator(".label .state"), /^5 points, not fitted yet$/);
    await until(async () => (await visit.drawn()).share > 0.0005, "its points are drawn");
    release();
    await visit.standing(/^converged/);
    await end(visit);
  });

  test("can be closed, has a unit, and a tolerance in either unit", PATIENT, async () => {
    const visit = await open();
    await dropped(visit, "few");
    await visit.page.getByLabel("Closed").first().setChecked(true);
    await until(async () => last(visit).curve?.closed === true, "it is fitted closed");
    await visit.page.getByLabel("Unit", { exact: true }).selectOption("mm");
    const unit = visit.page.getByLabel("Unit of the tolerance");
    await becomes(() => unit.locator("option").allTextContents(), ["× size", "mm"]);
    const tolerance = visit.page.getByLabel("Tolerance", { exact: true });
    await tolerance.fill("0.01");
    await tolerance.press("Tab");
    await unit.selectOption("mm");
    // A hundredth of the diagonal, of 6 and 3.
    await becomes(() => tolerance.inputValue(), "0.06708");
    const posted = visit.posted();
    await visit.press(visit.page.getByRole("button", { name: "Fit", exact: true }));
    await until(async () => visit.posted() > posted, "it is fitted");
    assert.deepEqual(last(visit).stop, { tolerance: 0.06708 });
    await end(visit);
  });

  test("with a mistake of the form says it at its field, in the words of the form", PATIENT, async () => {
    const visit = await open();
    await dropped(visit, "few");
    await visit.advanced();
    await visit.page.locator("[data-field='/method/kind'] select").selectOption("least_squares");
    await visit.press(visit.page.getByRole("button", { name: "Fit", exact: true }));
    const said = visit.page.locator("[data-field='/method/control_points'] .said");
    await says(said, /needs Control points/);
    assert.doesNotMatch((await said.textContent()) ?? "", /control_points|least_squares/);
    await visit.drop("twice.json", JSON.stringify({ curve: { points: [[0, 0], [1, 1], [1, 1], [2, 0]] } }));
    await says(visit.page.locator("form .wrong"), /^Point 3 equals point 2/);
    await end(visit);
  });
});
