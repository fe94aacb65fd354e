/** Many fits in one request. */

import { ApiError, type BatchItem, type api } from "piad";

import { all, equal, first, ok, refused } from "../check.js";
import { CURVE, FITS } from "../shapes.js";
import type { Scenarios } from "../world.js";

const POINTS = { curve: { points: CURVE } };

function wave(number: number): api.JobRequest {
  const points = Array.from({ length: 50 }, (_, i) => [i / 7, Math.sin(i / 7 + number)]);
  return { name: `wave ${number}`, curve: { points } };
}

function* waves(count: number): Generator<api.JobRequest> {
  for (let number = 0; number < count; number += 1) yield number === 1500 ? { curve: { points: [[0, 0], [1, 1], [1, 1]] } } : wave(number);
}

export const batches: Scenarios = {
  "items of a batch are what fits of their own are": async ({ client }) => {
    const requests = Object.entries(FITS).map(([name, request]) => ({ ...request, name }));
    for (const encoding of ["base64", "json"] as const) {
      const batch = client().batch(requests, { encoding });
      const items = await all(batch);
      for (const [index, item] of items.entries()) {
        const { id: _, ...alone } = await client().fit(requests[index]!);
        equal([item.index, item.name, item.state], [index, requests[index]!.name, alone.state]);
        equal([item.iteration, item.error], [alone.iteration, alone.error]);
        equal(item.result, { id: "", ...alone });
      }
      equal(batch.totals.items, requests.length);
    }
  },

  "thousands of items come in order": async ({ client }) => {
    const defaults = { method: { kind: "least_squares", control_points: "auto" }, stop: { tolerance: 0.01 } };
    const batch = client().batch(waves(2000), { defaults });
    const items = await all(batch);
    equal(items.map(({ index }) => index), [...items.keys()]);
    const wrong = items[1500] as BatchItem;
    equal([wrong.state, wrong.result, wrong.problem?.errors?.[0]?.pointer], ["failed", null, "/items/1500/curve/points/2"]);
    ok(wrong.problem?.detail.startsWith("/items/1500/curve/points/2: "), wrong.problem?.detail);
    equal(batch.totals, { items: 2000, converged: 1999, failed: 1 });
    equal([items[7]?.name, (items[7]?.result?.controlPoints.shape[0] ?? 99) < 30], ["wave 7", true]);
  },

  "items that are no fits fail alone": async ({ client }) => {
    const broken = { curve: { points: [...CURVE.slice(0, 3), [NaN, 0, 0]] } };
    const items = await all(client().batch([POINTS, broken, { ...POINTS, stop: { tolerance: 1e-9, max_iterations: 1 } }]));
    equal(items.map(({ state }) => state), ["converged", "failed", "exhausted"]);
    ok(items[1]?.problem?.errors?.[0]?.pointer?.startsWith("/items/1/curve/points/3"));
    equal([items[2]?.problem?.type, items[2]?.iteration, items[2]?.result?.iteration], ["/problems/not-converged", 1, 1]);
    const refusal = await refused(all(client().batch([POINTS], { defaults: { tolerance: 1 } })), ApiError);
    equal([refusal.status, refusal.pointers], [422, ["/defaults/tolerance"]]);
    equal(await all(client().batch([])), []);
  },

  "batches resume after a server was killed": async ({ client, environment }) => {
    const server = await environment.durable();
    const seen: number[] = [];
    for await (const { index } of client({}, server).batch(waves(1000))) {
      seen.push(index);
      if (index === 300) {
        await environment.kill(server);
        await environment.restart(server);
      }
    }
    equal(seen, [...Array(1000).keys()]);
    await environment.kill(server);
  },

  "batches that are left or aborted end": async ({ client }) => {
    equal((await first(client().batch(waves(600)))).index, 0);
    const controller = new AbortController();
    const aborted = all(client().batch(waves(600), { signal: controller.signal }));
    controller.abort(new Error("enough"));
    equal((await refused(aborted, Error)).message, "enough");
    equal((await client().fit(POINTS)).state, "converged");
  },
};
