/** The page of a server that asks for a token. */

import { strict as assert } from "node:assert";
import { after, before, describe, test } from "node:test";

import type { Browser } from "playwright-core";

import { Server } from "./server.js";
import { PATIENT, Visit, browse, until } from "./visit.js";

const TOKEN = "a-token-that-nobody-guesses-as-it-is-long";

describe("a token", () => {
  const server = new Server(":memory:", "/", TOKEN);
  let browser: Browser;

  before(async () => {
    await server.start();
    browser = await browse();
  });
  after(async () => {
    await browser?.close();
    await server.stop();
  });

  test("is asked for until it is valid, and kept as long as the tab is open", PATIENT, async () => {
    const visit = await Visit.to(browser, server.url);
    const dialog = visit.page.getByRole("dialog", { name: "Token" });
    await dialog.getByText("This server asks for a token.").waitFor();
    await dialog.getByLabel("Token").fill("another-token-that-is-as-long-as-that-one");
    await dialog.getByRole("button", { name: "Use it" }).click();
    await dialog.getByText("This token is not valid").waitFor();
    await dialog.getByLabel("Token").fill(TOKEN);
    await dialog.getByLabel("Token").press("Enter");
    await visit.standing(/^converged/);
    assert.equal(await dialog.count(), 0);
    await visit.page.reload();
    await visit.standing(/^converged/);
    assert.equal(await dialog.count(), 0);
    // Chromium tells of the answers that asked for it.
    const refused = visit.complaints.splice(0);
    assert.ok(refused.length >= 2 && refused.every((words) => words.includes("401")), refused.join("\n"));
    await visit.end();
  });

  test("that is not given leaves the page with what the server says", PATIENT, async () => {
    const visit = await Visit.to(browser, server.url);
    await visit.page.getByRole("dialog", { name: "Token" }).waitFor();
    await visit.page.keyboard.press("Escape");
    await until(async () => /a token is needed/.test((await visit.page.textContent("body")) ?? ""), "it is said");
    visit.complaints.splice(0);
    await visit.end();
  });
});
