/** What is seen when the server goes away, and when it is there again. */

import { strict as assert } from "node:assert";
import { mkdtemp, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, describe, test } from "node:test";

import type { Browser } from "playwright-core";

import { Server } from "./server.js";
import { PATIENT, Visit, browse, says, until } from "./visit.js";

/** One that is still running when the server is stopped, and ends a while later. */
const LONG = { name: "long", curve: { points: Array.from({ length: 400 }, (_, i) => [i, (i * 7) % 11]) }, method: { kind: "transpose" }, stop: { tolerance: 1e-300, max_iterations: 1_000_000 } };
const SHORT = { name: "short", curve: { points: [[0, 0], [1, 2], [3, 3], [5, 2], [6, 0]] } };

describe("a server that goes away", () => {
  let browser: Browser;

  before(async () => void (browser = await browse()));
  after(async () => browser?.close());

  const latest = async (visit: Visit): Promise<number> => (await visit.iteration())[1];
  const announces = (visit: Visit, pattern: RegExp, kind: "info" | "error") =>
    says(visit.page.locator(`#announcer[data-kind=${kind}]`), pattern);
  /** What the browser itself writes when it does not get what it asks for. */
  const forgive = (visit: Visit) => {
    const others = visit.complaints.filter((line) => !/Failed to load resource|ERR_CONNECTION|ERR_INCOMPLETE/.test(line));
    visit.complaints.splice(0, Infinity, ...others);
  };

  test("is followed again where its jobs outlive it", PATIENT, async () => {
    const directory = await mkdtemp(join(tmpdir(), "piad-page-"));
    const server = await new Server(directory).start();
    try {
      const created = await fetch(`${server.url}v1/jobs`, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(LONG) });
      const { id } = (await created.json()) as { id: string };
      const visit = await Visit.to(browser, `${server.url}#job=${id}`);
      await until(async () => (await latest(visit)) > 20, "the iterations come");
      await visit.whole();
      await server.stop();
      await announces(visit, /cannot be reached/, "error");
      const before = await latest(visit);
      await says(visit.page.locator(".label"), /long/);
      await server.start();
      await announces(visit, /there again/, "info");
      await until(async () => (await latest(visit)) > before, "the iterations go on");
      await until(async () => (await visit.drawn()).share > 0.002, "it is drawn");
      forgive(visit);
      await visit.end();
    } finally {
      await server.stop();
      await rm(directory, { recursive: true, force: true });
    }
  });

  test("and has forgotten its jobs says so, and fits others", PATIENT, async () => {
    const server = await new Server().start();
    try {
      const created = await fetch(`${server.url}v1/jobs`, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(LONG) });
      const { id } = (await created.json()) as { id: string };
      const visit = await Visit.to(browser, `${server.url}#job=${id}`);
      await until(async () => (await latest(visit)) > 20, "the iterations come");
      await visit.whole();
      await server.stop();
      await server.start();
      await announces(visit, /There is no job .*deleted/, "error");
      await visit.page.getByRole("button", { name: "Rose" }).click();
      await visit.standing(/^converged/);
      await until(async () => (await visit.drawn()).share > 0.005, "another is drawn");
      forgive(visit);
      await visit.end();
    } finally {
      await server.stop();
    }
  });

  test("says in each panel that it cannot be reached, and what was there stays", PATIENT, async () => {
    const server = await new Server().start();
    try {
      const { id } = await server.job(SHORT);
      const visit = await Visit.to(browser, `${server.url}#job=${id}`);
      await visit.standing(/^converged/);
      await visit.page.locator(".presets").waitFor();
      await visit.whole();
      await server.stop();
      await visit.page.getByRole("tab", { name: "Jobs" }).click();
      await until(async () => /could not be read\. The server cannot be reached/.test((await visit.page.locator("#jobs").textContent()) ?? ""), "the list says it");
      await visit.page.getByRole("tab", { name: "Data" }).click();
      await visit.page.getByRole("button", { name: "Fit", exact: true }).click();
      await until(async () => /cannot be reached/.test((await visit.page.locator("form .wrong").textContent()) ?? ""), "the form says it");
      assert.ok((await visit.drawn()).share > 0.005, "it is still drawn");
      assert.deepEqual(await visit.axe(), []);
      await server.start();
      await visit.page.getByRole("button", { name: "Fit", exact: true }).click();
      await until(async () => !visit.page.url().includes(id), "another job is shown");
      await visit.standing(/^converged/);
      forgive(visit);
      await visit.end();
    } finally {
      await server.stop();
    }
  });
});

describe("each panel", () => {
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

  for (const colorScheme of ["light", "dark"] as const) {
    for (const [width, height] of [[1280, 720], [390, 844]] as const) {
      test(`is fit for all: ${colorScheme}, ${width} pixels wide`, PATIENT, async () => {
        // An even degree is warned of.
        const { id } = await server.job({ ...SHORT, name: "a name that is longer than most of them are, of a section", curve: { points: [...SHORT.curve.points, [8, 1], [9, 3]], basis: { kind: "bspline", degree: 4, knots: "data" } } });
        const other = await server.job(SHORT);
        const visit = await Visit.to(browser, `${server.url}#job=${id}`, { viewport: { width, height }, colorScheme });
        await visit.standing(/^converged/);
        await says(visit.page.locator(".label .warning").first(), /degree/);
        for (const name of ["Data", "Jobs", "Export"]) {
          await visit.page.getByRole("tab", { name }).click();
          if (name === "Jobs") {
            await visit.page.getByRole("button", { name: "Delete short" }).first().click();
            await says(visit.page.locator(".joblist .warnings li").first(), /degree/);
            await until(async () => (await visit.page.locator("#job-state option").count()) > 5, "states are offered");
          } else await until(async () => (await visit.page.locator(name === "Data" ? ".field" : "ul.files li").count()) > 5, `${name} is there`);
          await visit.page.evaluate(() => document.querySelectorAll("#panels details").forEach((details) => details.setAttribute("open", "")));
          assert.deepEqual(await visit.axe(), [], name);
          assert.ok((await visit.page.evaluate(() => document.documentElement.scrollWidth)) <= width, `${name} is not too wide`);
        }
        await visit.page.evaluate((hash) => (location.hash = hash), `#job=${id},${other.id}&show=data,spikes`);
        await until(async () => (await visit.page.locator(".label").count()) === 2, "there are two");
        assert.deepEqual(await visit.axe(), []);
        await visit.end();
      });
    }
  }
});
