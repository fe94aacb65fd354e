/** Data that are imported, and how they are fitted. */

import { strict as assert } from "node:assert";
import { after, before, describe, test } from "node:test";

import type { Browser, Page } from "playwright-core";

import { Server } from "./server.js";
import { PATIENT, Visit, becomes, browse, says, until } from "./visit.js";

const ARCH = { name: "arch", curve: { points: [[0, 0], [1, 2], [3, 3], [5, 2], [6, 0]] } };

describe("data", () => {
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

  /** The page with a job, whose request is in the form. */
  async function visitArch(): Promise<Visit> {
    const { id } = await server.job(ARCH);
    const visit = await Visit.to(browser, `${server.url}#job=${id}`);
    await visit.standing(/^converged/);
    await until(async () => /5 points/.test(await words(visit.page)), "the request of the job is shown");
    await field(visit.page, "/name").waitFor();
    await visit.advanced();
    return visit;
  }

  test("that are pasted as JSON become a job with the settings of the form", PATIENT, async () => {
    const visit = await visitArch();
    await paste(visit.page, "[[0,0],[1,1],[2,0],[3,1],[4,0],[5,1],[6,0]]");
    await until(async () => /^Curve, 7 points in the plane$/.test(await words(visit.page)), "the points are counted");
    await field(visit.page, "/curve/basis/degree").fill("2");
    await field(visit.page, "/method/kind").selectOption("weighted");
    await field(visit.page, "/method/omega").fill("1.2");
    await visit.page.getByLabel("Unit of the tolerance").selectOption("data units");
    await field(visit.page, "/stop/tolerance").fill("1e-4");
    const posted = visit.posted();
    await visit.page.getByRole("button", { name: "Fit", exact: true }).click();
    await until(async () => visit.posted() > posted, "it is fitted");
    await visit.standing(/^converged/);
    const request = JSON.parse(lastJob(visit));
    assert.deepEqual(request.curve.basis, { kind: "bspline", degree: 2 });
    assert.deepEqual(request.method, { kind: "weighted", omega: 1.2 });
    assert.deepEqual(request.stop, { tolerance: 1e-4 });
    assert.equal(request.curve.points.length, 7);
    await visit.end();
  });

  test("that are nested are a surface, with both directions in the form", PATIENT, async () => {
    const visit = await visitArch();
    const rows = [0, 1, 2, 3, 4].map((i) => [0, 1, 2, 3].map((j) => [i, j, i * j]));
    await visit.drop("saddle.json", JSON.stringify(rows));
    await until(async () => /^Surface, 5 × 4 points in space/.test(await words(visit.page)), "the grid is recognised");
    await visit.page.getByLabel("Degree, u").fill("2");
    await visit.page.getByLabel("Degree, v").fill("3");
    const posted = visit.posted();
    await visit.page.keyboard.press("Enter");
    await until(async () => visit.posted() > posted, "it is fitted");
    await visit.standing(/^converged/);
    const request = JSON.parse(lastJob(visit));
    assert.equal(request.name, "saddle");
    assert.deepEqual([request.surface.basis.u.degree, request.surface.basis.v.degree], [2, 3]);
    await visit.end();
  });

  test("that are in files are read by the server, which knows airfoils and grids", PATIENT, async () => {
    const visit = await visitArch();
    const text = "NACA\n1 0\n0.8 0.03\n0.5 0.06\n0 0\n0.5 -0.06\n1 0\n";
    await choose(visit.page, "naca.dat", text);
    await until(async () => /^Curve, 6 points in the plane/.test(await words(visit.page)), "the airfoil is read");
    assert.equal(visit.sent.find(({ path }) => path === "/v1/points")?.body, text);
    await until(async () => (await visit.page.locator(".label h2").textContent()) === "NACA", "the file names the job");
    const grid = [0, 1, 2, 3].map((i) => [0, 1, 2, 3, 4].map((j) => `${i} ${j} ${i * j}`).join("\n")).join("\n\n");
    await paste(visit.page, grid);
    await until(async () => /^Surface, 4 × 5 points in space/.test(await words(visit.page)), "the grid is recognised");
    await visit.end();
  });

  test("a file that is wrong is shown at its line", PATIENT, async () => {
    const visit = await visitArch();
    await choose(visit.page, "half.csv", "x,y\n1,0\n0.5,zwei\n0,0\n");
    const at = visit.page.locator(".snippet .line.at");
    await at.waitFor();
    await says(at, /^30\.5,zwei/);
    await says(visit.page.locator(".wrong[role=alert]").first(), /half\.csv, line 3.*zwei/);
    assert.deepEqual(await visit.axe(), []);
    expected(visit, /422/);
    await visit.end();
  });

  test("that come back to the first one are closed, in JSON as in a table", PATIENT, async () => {
    const visit = await visitArch();
    await paste(visit.page, "[[2,0],[3,1],[3,2],[2,3],[1,3],[0,2],[0,1],[1,0],[2,0]]");
    await says(visit.page.locator(".data"), /8 points/);
    await says(visit.page.locator(".data"), /the curve is closed/);
    await visit.end();
  });

  test("that are wrong are shown at their line", PATIENT, async () => {
    const visit = await visitArch();
    await paste(visit.page, "[[0, 0],\n [1, 1],\n [2 3],\n [4, 5]]");
    const at = visit.page.locator(".snippet .line.at");
    await at.waitFor();
    await says(at, /^3 \[2 3\],/);
    await becomes(() => visit.page.locator(".snippet mark").textContent(), "3");
    await says(visit.page.locator(".wrong[role=alert]").first(), /line 3/);
    await says(visit.page.locator(".data"), /5 points/);
    assert.deepEqual(await visit.axe(), []);
    await visit.end();
  });

  test("what the server refuses is said at its field", PATIENT, async () => {
    const visit = await visitArch();
    await field(visit.page, "/method/kind").selectOption("weighted");
    await field(visit.page, "/method/omega").fill("seven");
    await field(visit.page, "/curve/basis/degree").fill("-1");
    await visit.page.getByRole("button", { name: "Fit", exact: true }).click();
    const said = visit.page.locator(".said:visible");
    await said.first().waitFor();
    // Of values that cannot be read the first is told.
    for (const [place, right] of [["/curve/basis/degree", "3"], ["/method/omega", "auto"]] as const) {
      const wrong = field(visit.page, place);
      await becomes(() => wrong.getAttribute("aria-invalid"), "true");
      await says(visit.page.locator(`[data-field='${place}'] .said`), /expected/i);
      expected(visit, /422/);
      assert.deepEqual(await visit.axe(), []);
      await wrong.fill(right);
      if (place === "/curve/basis/degree") await visit.page.getByRole("button", { name: "Fit", exact: true }).click();
    }
    await visit.page.getByRole("button", { name: "Fit", exact: true }).click();
    await until(async () => (await said.count()) === 0, "nothing is wrong any more");
    await visit.end();
  });

  test("the request is JSON that can be written, and a line for the shell", PATIENT, async () => {
    const visit = await visitArch();
    await visit.page.getByText("The request, as JSON and for curl").click();
    const area = visit.page.locator("#request-json");
    await until(async () => (await area.inputValue()) !== "", "the request is there");
    const request = JSON.parse(await area.inputValue());
    assert.deepEqual(request.curve.points, ARCH.curve.points);
    await area.fill(JSON.stringify({ ...request, name: "it's", method: { kind: "chebyshev" } }));
    await becomes(() => field(visit.page, "/method/kind").inputValue(), "chebyshev");
    const line = visit.page.locator(".request pre");
    await says(line, /"it'\\''s"/);
    const written = (await line.textContent()) ?? "";
    assert.ok(written.startsWith(`curl ${server.url}v1/jobs -H 'Content-Type: application/json' --data-raw '{`), written);
    await area.fill("{");
    await becomes(() => area.getAttribute("aria-invalid"), "true");
    await says(visit.page.locator("#request-json-said"), /Not sent/);
    await visit.end();
  });

  test("an example shows a method at once", PATIENT, async () => {
    const visit = await visitArch();
    await visit.page.getByText("Examples of methods").click();
    await until(async () => (await visit.page.locator(".ready li b").count()) >= 5, "there are some");
    const names = await visit.page.locator(".ready li b").allTextContents();
    for (const name of names) {
      await visit.page.locator(".ready li button", { hasText: name }).first().click();
      await until(async () => (await visit.page.locator(".label h2").first().textContent()) === name, `${name} is shown`);
      await visit.standing(/^(?!queued|running|asked)\w/);
    }
    await visit.end();
  });

  test("a fit stands beside another one", PATIENT, async () => {
    const visit = await visitArch();
    await field(visit.page, "/method/kind").selectOption("chebyshev");
    await visit.page.getByRole("button", { name: "Compare", exact: true }).click();
    await until(async () => (await visit.page.locator(".label").count()) === 2, "there are two");
    await until(async () => /#job=[\w-]+,[\w-]+/.test(visit.page.url()), "the link has both");
    await becomes(() => field(visit.page, "/method/kind").inputValue(), "chebyshev");
    await visit.end();
  });

  for (const scheme of ["light", "dark"] as const) {
    test(`the form is fit for all, in ${scheme} on a phone`, PATIENT, async () => {
      const { id } = await server.job(ARCH);
      const visit = await Visit.to(browser, `${server.url}#job=${id}`, { viewport: { width: 390, height: 844 }, colorScheme: scheme });
      await field(visit.page, "/name").waitFor();
      await visit.page.evaluate(() => document.querySelectorAll("#import details").forEach((details) => details.setAttribute("open", "")));
      assert.deepEqual(await visit.axe(), []);
      assert.equal(await visit.page.evaluate(() => document.documentElement.scrollWidth), 390);
      await visit.end();
    });
  }
});

function field(page: Page, pointer: string) {
  return page.locator(`[data-field='${pointer}'] :is(input, select)`).first();
}

async function words(page: Page): Promise<string> {
  return (await page.locator(".data b").textContent({ timeout: 1000 }).catch(() => null)) ?? "";
}

function lastJob(visit: Visit): string {
  return visit.sent.filter(({ method, path }) => method === "POST" && path === "/v1/jobs").at(-1)?.body ?? "";
}

/** Takes a complaint of the console that had to come, once. */
function expected(visit: Visit, pattern: RegExp): void {
  const at = visit.complaints.findIndex((complaint) => pattern.test(complaint));
  assert.ok(at >= 0, `the console said ${pattern}`);
  visit.complaints.splice(at, 1);
}

async function paste(page: Page, text: string): Promise<void> {
  await page.evaluate((content) => {
    const data = new DataTransfer();
    data.setData("text/plain", content);
    document.body.dispatchEvent(new ClipboardEvent("paste", { clipboardData: data, bubbles: true, cancelable: true }));
  }, text);
}

async function choose(page: Page, name: string, text: string): Promise<void> {
  await page.locator("#file").setInputFiles({ name, mimeType: "text/plain", buffer: Buffer.from(text) });
}
