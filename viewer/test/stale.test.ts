/** An error is seen as long as its cause is there. */

import { after, before, describe, test } from "node:test";

import { strict as assert } from "node:assert";

import type { Browser, Page } from "playwright-core";

import { Server } from "./server.js";
import { PATIENT, Visit, becomes, browse, says, until } from "./visit.js";

const ARCH = { name: "arch", curve: { points: [[0, 0], [1, 2], [3, 3], [5, 2], [6, 0]] } };

describe("an error", () => {
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
    const { id } = await server.job(ARCH);
    const visit = await Visit.to(browser, `${server.url}#job=${id}`);
    await visit.standing(/^converged/);
    await until(async () => (await field(visit.page, "/name").inputValue()) === "arch", "the request is in the form");
    await visit.advanced();
    return visit;
  };
  /** Ends a visit to which requests were refused. */
  const end = async (visit: Visit): Promise<void> => {
    visit.complaints.splice(0, Infinity, ...visit.complaints.filter((line) => !/status of 4\d\d/.test(line)));
    await visit.end();
  };
  const fit = (visit: Visit) => visit.page.getByRole("button", { name: "Fit", exact: true }).click();

  test("of a field goes when the field is changed", PATIENT, async () => {
    const visit = await open();
    const degree = field(visit.page, "/curve/basis/degree");
    await degree.fill("-1");
    await fit(visit);
    await becomes(() => degree.getAttribute("aria-invalid"), "true");
    await degree.fill("2");
    await degree.press("Tab");
    await becomes(() => degree.getAttribute("aria-invalid"), null);
    assert.equal(await visit.page.locator(".said:visible").count(), 0);
    await end(visit);
  });

  test("of the request goes when what it is about is changed, and stays when other things are", PATIENT, async () => {
    const visit = await open();
    await field(visit.page, "/method/kind").selectOption("least_squares");
    await fit(visit);
    const said = visit.page.locator("[data-field='/method/control_points'] .said");
    await says(said, /needs Control points/);
    await field(visit.page, "/name").fill("other");
    await field(visit.page, "/name").press("Tab");
    await says(said, /needs Control points/);
    await field(visit.page, "/method/control_points").fill("4");
    await field(visit.page, "/method/control_points").press("Tab");
    await becomes(() => said.isVisible(), false);
    await fit(visit);
    await visit.standing(/^(converged|stalled|not yet)/);
    await end(visit);
  });

  test("of a file goes when something else is fitted", PATIENT, async () => {
    const visit = await open();
    await visit.page.locator("#file").setInputFiles({ name: "half.csv", mimeType: "text/plain", buffer: Buffer.from("x,y\n1,0\n0.5,zwei\n0,0\n") });
    const wrong = visit.page.locator(".wrong[role=alert]");
    await says(wrong, /half\.csv, line 3/);
    await fit(visit);
    await becomes(() => wrong.count(), 0);
    await end(visit);
  });

  test("of a job goes when another one is opened", PATIENT, async () => {
    const visit = await Visit.to(browser, `${server.url}#job=01a20965-d4dd-75e8-902b-45b708e30e33`);
    const announcer = visit.page.locator("#announcer[data-said][data-kind=error]");
    await says(announcer, /^There is no job 01a20965/);
    await visit.page.getByRole("button", { name: "Rose" }).click();
    await visit.standing(/^converged/);
    await becomes(() => announcer.count(), 0);
    assert.doesNotMatch((await visit.page.locator("#announcer").textContent()) ?? "", /there again/);
    await end(visit);
  });
});

function field(page: Page, pointer: string) {
  return page.locator(`[data-field='${pointer}'] :is(input, select)`).first();
}
