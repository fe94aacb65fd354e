/** The jobs of the server, and what is taken away. */

import { strict as assert } from "node:assert";
import { readFile } from "node:fs/promises";
import { after, before, describe, test } from "node:test";

import type { Browser, Locator, Page } from "playwright-core";

import { Server } from "./server.js";
import { PATIENT, Visit, becomes, browse, says, until } from "./visit.js";

const POINTS = [[0, 0], [1, 2], [3, 3], [5, 2], [6, 0]];
const job = (name: string) => ({ name, curve: { points: POINTS } });

/** One that takes longer than anybody waits. */
const ENDLESS = { name: "endless", curve: { points: Array.from({ length: 400 }, (_, i) => [i, (i * 7) % 11]) }, method: { kind: "transpose" }, stop: { tolerance: 1e-300, max_iterations: 1_000_000 } };

describe("jobs", () => {
  let server: Server;
  let browser: Browser;

  before(async () => {
    server = await new Server().start();
    browser = await browse();
  });
  after(async () => {
    await browser?.close();
    await server.stop();
  });

  async function visitJobs(name: string): Promise<Visit> {
    const { id } = await server.job(job(name));
    const visit = await Visit.to(browser, `${server.url}#job=${id}`);
    await visit.page.getByRole("tab", { name: "Jobs" }).click();
    await row(visit.page, name).waitFor();
    return visit;
  }

  test("are listed as they come, opened, and stand beside each other", PATIENT, async () => {
    const visit = await visitJobs("first");
    await says(row(visit.page, "first"), /converged.*Curve, 5 points · global/);
    await becomes(() => row(visit.page, "first").getByRole("button", { name: "first", exact: true }).getAttribute("aria-current"), "true");
    await server.job(job("second"));
    await row(visit.page, "second").waitFor();
    await row(visit.page, "second").getByRole("button", { name: "Compare" }).click();
    await until(async () => (await visit.page.locator(".label").count()) === 2, "there are two");
    assert.deepEqual(await visit.axe(), []);
    await row(visit.page, "first").getByRole("button", { name: "Take off" }).click();
    await until(async () => (await visit.page.locator(".label h2").allTextContents()).join() === "second", "one is left");
    await row(visit.page, "first").getByRole("button", { name: "first", exact: true }).click();
    await until(async () => (await visit.page.locator(".label h2").allTextContents()).join() === "first", "the first is open");
    await visit.end();
  });

  test("say how old they are, and are found by their names", PATIENT, async () => {
    await server.job({ curve: { points: POINTS } });
    const visit = await visitJobs("needle");
    await says(row(visit.page, "needle").locator("time"), /^\d+ s ago$/);
    // One without a name is called what it is.
    await row(visit.page, "Curve of 5 points").first().waitFor();
    await visit.page.getByLabel("Search the jobs").fill("need");
    await becomes(() => visit.page.locator(".joblist li").count(), 1);
    await visit.page.getByLabel("Search the jobs").fill("nothing like it");
    await visit.page.getByText("No job has “nothing like it”").waitFor();
    assert.deepEqual(await visit.axe(), []);
    await visit.end();
  });

  test("are deleted after a second thought", PATIENT, async () => {
    const visit = await visitJobs("doomed");
    await row(visit.page, "doomed").getByRole("button", { name: "Delete doomed" }).click();
    await visit.page.keyboard.press("Escape");
    assert.ok(await row(visit.page, "doomed").isVisible());
    await row(visit.page, "doomed").getByRole("button", { name: "Delete doomed" }).click();
    assert.equal(visit.sent.filter(({ method }) => method === "DELETE").length, 0);
    await row(visit.page, "doomed").getByRole("button", { name: "Delete for good" }).click();
    await row(visit.page, "doomed").waitFor({ state: "detached" });
    assert.equal(visit.sent.filter(({ method }) => method === "DELETE").length, 1);
    await visit.end();
  });

  test("that run tell how far they are, and are cancelled", PATIENT, async () => {
    const made = await fetch(`${server.url}v1/jobs`, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(ENDLESS) });
    assert.ok(made.ok, await made.text());
    const visit = await visitJobs("beside it");
    const endless = row(visit.page, "endless");
    await endless.locator("progress").waitFor();
    const before = (await endless.textContent()) ?? "";
    await until(async () => (await endless.textContent()) !== before, "it goes on");
    await endless.getByRole("button", { name: "Cancel endless" }).click();
    await until(async () => /cancelled/.test((await endless.textContent()) ?? ""), "it is cancelled");
    await becomes(() => endless.locator("progress").isVisible(), false);
    await visit.page.getByLabel("State").selectOption("cancelled");
    await until(async () => (await visit.page.locator(".joblist li").count()) === 1, "only that one is left");
    await visit.page.getByLabel("State").selectOption("failed");
    await visit.page.getByText("No job is failed.").waitFor();
    await visit.end();
  });

  test("come in pages", PATIENT, async () => {
    for (let i = 0; i < 30; i++) await server.job(job(`page ${i}`));
    const visit = await visitJobs("newest");
    await becomes(() => visit.page.locator(".joblist li").count(), 25);
    await visit.page.getByRole("button", { name: "Show more" }).click();
    await row(visit.page, "page 0").waitFor();
    await visit.end();
  });

  test("are not asked for while nobody sees them", PATIENT, async () => {
    const { id } = await server.job(job("quiet"));
    const visit = await Visit.to(browser, `${server.url}#job=${id}`);
    await visit.standing(/^converged/);
    assert.equal(visit.sent.filter(({ path }) => path.startsWith("/v1/jobs?")).length, 0);
    await visit.end();
  });

  test("an iteration is taken as a file, and as a link", PATIENT, async () => {
    const { id } = await server.job(job("to take"));
    const visit = await Visit.to(browser, `${server.url}#job=${id}&k=2`);
    await visit.standing(/^converged/);
    await visit.page.getByRole("tab", { name: "Export" }).click();
    await visit.page.getByText("Iteration 2 of to take").waitFor();
    const { formats } = await server.get<{ formats: { result: string[] } }>("v1/capabilities");
    const files = formats.result.filter((type) => type !== "application/x-protobuf");
    await becomes(() => visit.page.locator("[data-format]").count(), files.length);
    for (const button of await visit.page.locator("[data-format]").all()) {
      const format = await button.getAttribute("data-format");
      // A track needs a place on the earth, which is an option.
      if (format === "json" || format === "gpx") continue;
      const { status } = await fetch(`${server.url}v1/jobs/${id}/iterations/2/${format}`);
      await until(async () => (await button.isVisible()) === (status === 200), `${format} is offered if there is one, and the server answers ${status}`);
    }
    assert.match(await taken(visit.page, "step"), /^ISO-10303-21;/);
    assert.ok(visit.sent.some(({ path }) => path === `/v1/jobs/${id}/iterations/2/step`));
    assert.match(await taken(visit.page, "svg"), /<svg/);
    assert.equal(JSON.parse(await taken(visit.page, "json")).iteration, 2);
    assert.deepEqual(await visit.axe(), []);

    for (const [name, content] of [["STEP", /ISO-10303-21/], ["CSV", /\d/], ["glTF", /vertices/]] as const) {
      await visit.press(visit.page.getByRole("button", { name: `Preview ${name}` }));
      await says(visit.page.locator(".preview"), content);
    }
    await visit.press(visit.page.getByRole("button", { name: "Preview SVG" }));
    await visit.page.getByRole("img", { name: "The drawing in the file" }).waitFor();
    assert.deepEqual(await visit.axe(), []);

    await visit.page.getByText("Options").click();
    await visit.page.getByLabel("Samples").fill("7");
    assert.equal((await taken(visit.page, "csv")).trim().split("\n").filter((line) => /^[\d.-]/.test(line)).length, 7);

    await visit.page.context().grantPermissions(["clipboard-read", "clipboard-write"]);
    await visit.page.getByRole("button", { name: "Copy link" }).click();
    await visit.page.getByText("The link is on the clipboard.").waitFor();
    const link = await visit.page.evaluate(() => navigator.clipboard.readText());
    assert.equal(link, `${server.url}#job=${id}&k=2`);

    await visit.page.getByLabel("Samples").fill("");
    const points = [0, 1, 2, 3].map((i) => [0, 1, 2, 3].map((j) => [i, j, i * j]));
    const surface = await server.job({ name: "of triangles", surface: { points } });
    await visit.page.evaluate((hash) => (location.hash = hash), `#job=${surface.id}`);
    await visit.page.getByText(/^Iteration \d+ of of triangles/).waitFor();
    assert.ok((await taken(visit.page, "stl")).length > 84, "surfaces have triangles");
    await visit.end();
  });
});

test("without jobs the list says what to do", PATIENT, async () => {
  const server = await new Server().start();
  const browser = await browse();
  try {
    const visit = await Visit.to(browser, `${server.url}#job=01a20971-0000-7000-8000-000000000000`);
    await visit.page.getByRole("tab", { name: "Jobs" }).click();
    await visit.page.getByText("There are no jobs.").waitFor();
  } finally {
    await browser.close();
    await server.stop();
  }
});

function row(page: Page, name: string): Locator {
  return page.locator(".joblist li").filter({ has: page.getByRole("button", { name, exact: true }) });
}

/** What is in a file that is taken. */
async function taken(page: Page, format: string): Promise<string> {
  const [download] = await Promise.all([page.waitForEvent("download"), page.locator(`[data-format=${format}]`).click()]);
  return readFile(await download.path(), "utf8");
}
