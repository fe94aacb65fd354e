/** What is drawn of a fit to judge it, in light and dark, small and large. */

import { strict as assert } from "node:assert";
import { after, before, describe, test } from "node:test";

import type { Browser } from "playwright-core";

import { Server } from "./server.js";
import { PATIENT, Visit, becomes, browse, says, until } from "./visit.js";

const CURVE = { name: "bend", curve: { points: Array.from({ length: 14 }, (_, i) => [i, 3 * Math.sin(i / 2)]) } };
const SURFACE = {
  name: "hill",
  surface: { points: Array.from({ length: 9 }, (_, i) => Array.from({ length: 8 }, (_, j) => [i, j, 2.5 * Math.exp(-((i - 4) ** 2 + (j - 3.5) ** 2) / 4)])) },
};

describe("what is drawn", () => {
  const server = new Server();
  let browser: Browser;
  let curve = "";
  let surface = "";

  before(async () => {
    await server.start();
    browser = await browse();
    curve = (await server.job(CURVE)).id;
    surface = (await server.job(SURFACE)).id;
  });
  after(async () => {
    await browser?.close();
    await server.stop();
  });

  const settle = async (visit: Visit) => {
    await visit.standing(/^converged/);
    const { share } = await visit.still();
    assert.ok(share > 0.01, "something is drawn");
  };

  for (const layer of ["data", "polygon", "spikes", "comb"]) {
    test(`${layer} of a curve`, PATIENT, async () => {
      const visit = await Visit.to(browser, `${server.url}#job=${curve}&k=1`);
      await settle(visit);
      const before = await visit.drawn();
      const button = visit.page.locator(`[data-layer=${layer}]`);
      const was = await button.getAttribute("aria-pressed");
      await button.click();
      await becomes(() => button.getAttribute("aria-pressed"), was === "true" ? "false" : "true");
      await until(async () => (await visit.difference(before)) > 0.0005, `${layer} is seen`);
      assert.match(visit.page.url(), /&show=/);
      await visit.end();
    });
  }

  for (const layer of ["data", "polygon", "spikes", "heat", "zebra"]) {
    test(`${layer} of a surface`, PATIENT, async () => {
      const visit = await Visit.to(browser, `${server.url}#job=${surface}&k=0`);
      await settle(visit);
      const before = await visit.drawn();
      await visit.page.locator(`[data-layer=${layer}]`).click();
      await until(async () => (await visit.difference(before)) > 0.0005, `${layer} is seen`);
      await visit.end();
    });
  }

  test("what curves have not is not offered for them", PATIENT, async () => {
    const visit = await Visit.to(browser, `${server.url}#job=${curve}`);
    await settle(visit);
    await becomes(() => visit.page.locator("[data-layer=zebra]").isVisible(), false);
    await becomes(() => visit.page.locator("[data-layer=comb]").isVisible(), true);
    await visit.end();
  });

  test("colours have a legend from the tolerance to the first error", PATIENT, async () => {
    const visit = await Visit.to(browser, `${server.url}#job=${surface}&k=0&show=heat`);
    await settle(visit);
    await until(async () => (await visit.page.locator(".legend").count()) === 1, "the legend is there");
    assert.match((await visit.page.locator(".legend").getAttribute("aria-label")) ?? "", /^Distance from the data, from .*10⁻⁵ to 0\.\d+$/);
    const far = await visit.drawn();
    await visit.page.keyboard.press("End");
    await until(async () => (await visit.difference(far)) > 0.02, "the colours change");
    await visit.end();
  });

  test("numbers stand under the pointer", PATIENT, async () => {
    const visit = await Visit.to(browser, `${server.url}#job=${curve}&k=0&show=data,spikes`);
    await settle(visit);
    const [x, y] = await visit.leftmost();
    await visit.page.mouse.move(x, y);
    const tip = visit.page.locator("#tip");
    await tip.waitFor();
    await says(tip, /^point\d+x.*y.*error/);
    await visit.end();
  });

  test("up to four jobs stand side by side, in one chart", PATIENT, async () => {
    const others = await Promise.all(["weighted", "chebyshev", "direct"].map((kind) => server.job({ ...SURFACE, name: kind, method: { kind } })));
    const jobs = [surface, ...others.map(({ id }) => id)].join(",");
    const visit = await Visit.to(browser, `${server.url}#job=${jobs}`);
    await settle(visit);
    await becomes(() => visit.page.locator(".label h2").allTextContents(), ["hill", "weighted", "chebyshev", "direct"]);
    const chart = async () => (await visit.page.locator(".plot").getAttribute("aria-label")) ?? "";
    await until(async () => /hill: .*weighted: .*chebyshev: .*direct: /.test(await chart()), "the chart has them all");
    await visit.page.locator(".label").nth(1).getByRole("button").click();
    await until(async () => (await visit.page.locator(".label").count()) === 3, "one has gone");
    assert.ok(!visit.page.url().includes(others[0]!.id));
    await visit.end();
  });

  for (const colorScheme of ["light", "dark"] as const) {
    for (const [width, height] of [[1440, 900], [390, 844]] as const) {
      test(`axe-core finds nothing: ${colorScheme}, ${width} pixels wide`, PATIENT, async () => {
        const visit = await Visit.to(browser, `${server.url}#job=${surface},${curve}&show=data,heat,polygon`, { colorScheme, viewport: { width, height } });
        await settle(visit);
        assert.deepEqual(await visit.axe(), []);
        const wide = await visit.page.evaluate(() => document.documentElement.scrollWidth);
        assert.ok(wide <= width, `the page is ${wide} pixels wide`);
        await visit.end();
      });
    }
  }
});
