/**
 * What the server is asked for first. It is a small script of its own, so that the answers come while the browser
 * still reads what draws them.
 */

import type { Fit } from "./fit/fit.js";
import { precise, samplesOf } from "./scene/frame-data.js";
import { fits, view } from "./session.js";
import { begin } from "./ui/examples.js";

begin();
const known = new Set<string>();
fits.shown.forEach(ask);
view.subscribe(() => fits.shown.forEach(ask));

/** Asks for what is drawn of a fit at first. */
function ask(fit: Fit): void {
  if (known.has(fit.id) || known.size > 0) return;
  known.add(fit.id);
  const { iteration, layers } = view.value;
  // The last one is not known yet.
  if (iteration === "latest") return void fit.data().catch(() => {});
  fit
    .data()
    .then((data) => fit.geometry.samples(iteration, samplesOf(data, { zoom: 1, cells: fits.shown.length }), precise(data, layers), data.axes))
    .catch(() => {});
}
