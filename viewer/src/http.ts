/** Requests to the server that the page came from, with a token if it asks for one. */

import { el } from "./html.js";

// For as long as the tab is open.
const KEPT = "piad-token";

/** The question that is open. */
let asking: Promise<string | null> | undefined;

/** Like the global `fetch`. Whoever uses the page is asked for a token where the server wants another one. */
export async function authorized(url: string | URL, init: RequestInit = {}): Promise<Response> {
  for (;;) {
    const token = sessionStorage.getItem(KEPT);
    const headers = new Headers(init.headers);
    if (token !== null) headers.set("Authorization", `Bearer ${token}`);
    const answer = await fetch(url, { ...init, headers });
    if (answer.status !== 401) return answer;
    // The answer to another request may have led to a new one meanwhile.
    if (sessionStorage.getItem(KEPT) !== token) continue;
    asking ??= question(token !== null).finally(() => (asking = undefined));
    const given = await asking;
    if (given === null) return answer;
    sessionStorage.setItem(KEPT, given);
  }
}

/** What is given, or null. */
function question(again: boolean): Promise<string | null> {
  const input = el("input", { type: "password", name: "token", required: true, autocomplete: "off" });
  const words = again ? "This token is not valid, or not any more." : "This server asks for a token.";
  const form = el(
    "form",
    { method: "dialog" },
    el("p", {}, words),
    el("label", {}, "Token ", input),
    el("button", { type: "submit", value: "use" }, "Use it"),
  );
  const dialog = el("dialog", { class: "question", "aria-label": "Token" }, form);
  document.body.append(dialog);
  return new Promise((resolve) => {
    dialog.addEventListener("close", () => {
      dialog.remove();
      resolve(dialog.returnValue === "use" ? input.value.trim() : null);
    });
    dialog.showModal();
  });
}
