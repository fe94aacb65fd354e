/** What the page says. */

import type { App } from "../app.js";

// How long a sentence stays that asks for nothing, in milliseconds.
const STAYS = 6000;

/** Says sentences in a live region. Errors stay until something else is said, or they are forgotten. */
export function createAnnouncer(region: HTMLElement): Pick<App, "say" | "forget"> {
  let timer = 0;
  const say: App["say"] = (sentence, kind = "info") => {
    clearTimeout(timer);
    region.textContent = sentence;
    region.dataset["kind"] = kind;
    region.toggleAttribute("data-said", sentence !== "");
    if (kind === "info") timer = window.setTimeout(() => region.removeAttribute("data-said"), STAYS);
  };
  const forget = () => region.dataset["kind"] === "error" && say("");
  return { say, forget };
}
