/** Each iteration once and in order, even if connections break. */

import { ApiError, ConnectionLost, type ErrorIteration, type FittedIteration, type SampledIteration } from "piad";

import { all, equal, first, ok, refused, sleep } from "../check.js";
import { AUTOMATIC, CURVE, FITS, SURFACE, large, slow } from "../shapes.js";
import type { Scenarios } from "../world.js";

/** The coordinates and weights of an iteration. */
function numbersOf(level: FittedIteration | SampledIteration): number[] {
  if (level.view === "samples") return [...level.samples.data];
  return [...level.controlPoints.data, ...(level.weights?.data ?? [])];
}

const POINTS = { curve: { points: CURVE } };

export const streams: Scenarios = {
  "views and choices": async ({ client }) => {
    const job = await client().create(POINTS);
    const last = (await job.wait()).iteration ?? 0;
    const numbers = async (items: AsyncIterable<{ number: number }>) => (await all(items)).map(({ number }) => number);
    const error: ErrorIteration = await first(job.iterations({ view: "errors" }));
    ok(!("controlPoints" in error));
    const sampled: SampledIteration = await first(job.iterations({ view: "samples", samples: 11 }));
    equal([sampled.samples.shape, sampled.parameters[0].length], [[11, 3], 11]);
    const fitted: FittedIteration = await first(job.iterations({ view: "control_points", digits: "auto" }));
    equal(fitted.controlPoints.shape[1], 3);
    const fifth = await numbers(job.iterations({ every: 5 }));
    equal(fifth, [...Array.from({ length: Math.ceil(last / 5) }, (_, i) => 5 * i), last]);
    const reached = await all(job.iterations({ milestones: [1e-1, 1e-2, 1e-3] }));
    equal(reached.slice(-2).map(({ milestone }) => milestone), [1e-3, null]);
    equal((await numbers(job.iterations({ after: 3 })))[0], 4);
    equal((await numbers(job.iterations({ pace: "latest" }))).at(-1), last);
    // @ts-expect-error: errors have no control points.
    void error.controlPoints;
    // @ts-expect-error: unknown view.
    job.iterations({ view: "points" });
  },

  "changes are applied": async ({ client }) => {
    for (const [name, index] of [["curve", 2], ["homogeneous", 2], ["closed", 2], ["surface", [2, 2]], ["homogeneousSurface", [2, 2]]] as const) {
      const indices = [typeof index === "number" ? index : [...index]];
      const job = await client().create({ ...FITS[name]!, method: { kind: "local", indices } }, { wait: 10 });
      const full = await all(job.iterations({ view: "control_points" }));
      const changed = await all(job.iterations({ view: "control_points", changed: true }));
      equal(changed, full, name);
    }
  },

  "differences are applied": async ({ client }) => {
    for (const [name, request] of Object.entries(FITS)) {
      const job = await client().create(request, { wait: 10 });
      for (const view of ["control_points", "samples"] as const) {
        const exact = await all(job.iterations({ view, encoding: "base64" }));
        const near = await all(job.iterations({ view, encoding: "delta" }));
        equal(near.map(({ number }) => number), exact.map(({ number }) => number), name);
        equal(near.at(-1), exact.at(-1), name);
        for (const [k, level] of near.entries()) {
          const [found, expected] = [numbersOf(level), numbersOf(exact[k]!)];
          equal(found.length, expected.length, name);
          const bound = (level.error.max ?? 0) / 64 + 1e-12;
          ok(found.every((x, i) => Math.abs(x - expected[i]!) <= bound), `${name} ${view} ${k}`);
        }
      }
    }
  },

  "events as the server writes them": async ({ client }) => {
    const stream = client().createStream({ ...POINTS, name: "Flügel ✈" }, { view: "errors" });
    const events = await all(stream.events());
    equal([events[0]?.event, events[1]?.event, events.at(-1)?.event], ["job", "iteration", "end"]);
    equal([stream.job?.name, stream.end?.state], ["Flügel ✈", "converged"]);
    for (const event of events) if (event.event === "iteration") equal(event.id, event.data.iteration);
  },

  "bodies come in any pieces": async ({ client }) => {
    const request = { ...POINTS, name: "Flügel ✈" };
    const whole = await all(client().createStream(request).events());
    for (const size of [1, 7, 1000]) {
      const job = client({ fetch: async (url, init) => inPieces(await fetch(url, init), size) }).createStream(request);
      const events = await all(job.events());
      equal(events.filter(({ event }) => event === "iteration"), whole.filter(({ event }) => event === "iteration"));
      equal(job.job?.name, request.name);
    }
  },

  "what a job says about its streams": async ({ client }) => {
    const stream = { view: "errors", every: 2, on_disconnect: "cancel" } as const;
    const job = await client().create({ ...POINTS, stream });
    equal((await job.shape()).bases[0].degree, 3);
    equal((await job.wait()).state, "converged");
    const levels = await all(job.iterations());
    equal([levels[0]?.view, levels[1]?.number], ["errors", 2]);
    equal((await all(client().createStream({ ...POINTS, stream }))).length, levels.length);
  },

  "streams survive SIGKILL": async ({ client, environment }) => {
    const url = await environment.durable();
    const job = await client({}, url).create(slow(3000));
    const numbers: number[] = [];
    for await (const level of job.iterations({ view: "control_points", changed: true })) {
      numbers.push(level.number);
      ok(level.controlPoints.data.every(Number.isFinite));
      if (level.number === 200 || level.number === 1000) {
        await environment.kill(url);
        await environment.restart(url);
      }
    }
    equal(numbers, Array.from({ length: 3001 }, (_, i) => i));
    equal((await job.refresh()).state, "exhausted");
    await environment.kill(url);
  },

  "streams of new jobs survive SIGKILL": async ({ client, environment }) => {
    const url = await environment.durable();
    const stream = client({}, url).createStream(slow(2000), { view: "errors" });
    const numbers: number[] = [];
    for await (const level of stream) {
      numbers.push(level.number);
      if (level.number !== 300) continue;
      await environment.kill(url);
      await environment.restart(url);
    }
    equal(numbers, Array.from({ length: 2001 }, (_, i) => i));
    equal([stream.end?.state, (await all(client({}, url).jobs())).length], ["exhausted", 1]);
    await environment.kill(url);
  },

  "knots are known after a broken connection": async ({ client, environment, url }) => {
    const proxy = await environment.proxy(url);
    const resumed: (string | null)[] = [];
    const noted = (init: RequestInit) => resumed.push(new Headers(init.headers).get("Last-Event-ID"));
    const piad = client({ fetch: (url, init) => (noted(init), fetch(url, init)) }, proxy);
    await environment.cutAfter(proxy, 12_000);
    const stream = piad.createStream(AUTOMATIC, { view: "control_points" });
    const levels = await all(stream);
    equal([resumed.length, resumed[0], Number(resumed[1]) > 3], [2, null, true], `it resumes after ${resumed[1]}`);
    const job = await client().job(stream.job?.id ?? "");
    equal(levels, await all(job.iterations({ view: "control_points" })));
  },

  "iterations that a server sends twice come once": async ({ client, environment, url }) => {
    const proxy = await environment.proxy(url);
    await environment.cutAfter(proxy, 12_000);
    const forgetful = (url: string, { headers, ...init }: RequestInit) => {
      const others = [...new Headers(headers)].filter(([name]) => name !== "last-event-id");
      return fetch(url, { ...init, headers: others });
    };
    const levels = await all(client({ fetch: forgetful }, proxy).createStream(AUTOMATIC, { view: "errors" }));
    equal(levels.map(({ number }) => number), [...levels.keys()]);
  },

  "another version sends all iterations again": async ({ client }) => {
    let last = "";
    // The first connection breaks in the middle of an event.
    const newer = async (url: string, init: RequestInit) => {
      const headers = new Headers(init.headers);
      last = headers.get("Last-Event-ID") ?? "";
      headers.delete("Last-Event-ID");
      const answer = await fetch(url, { ...init, headers });
      const text = await answer.text();
      if (last === "") return new Response(text.slice(0, 12_000), answer);
      const restarted = text.replace("data: {", 'data: {"resumed":"restarted",');
      return new Response(restarted.replace(/^id: (\d+)$/gm, "id: $1@2"), answer);
    };
    const levels = await all(client({ fetch: newer }).createStream(AUTOMATIC, { view: "errors" }));
    const numbers = levels.map(({ number }) => number);
    const first = Number(last) + 1;
    equal([first > 3, numbers], [true, [...Array(first).keys(), ...Array(levels.length - first).keys()]]);
  },

  "lost answers make one job": async ({ client, environment, url }) => {
    const proxy = await environment.proxy(url);
    const piad = client({}, proxy);
    const count = async () => (await all(client().jobs())).length;
    const before = await count();
    await environment.loseAnswer(proxy);
    const job = await piad.create(slow(1_000_000));
    equal(await count(), before + 1);
    await first(job.iterations());
    await environment.loseAnswer(proxy);
    equal((await job.cancel()).state, "cancelled");
    await environment.loseAnswer(proxy);
    await job.edit({ stop: { max_iterations: 5 } });
    equal(await count(), before + 2);
    await environment.loseAnswer(proxy);
    equal((await all(piad.createStream(POINTS))).length > 5, true);
    equal(await count(), before + 3);
    await environment.loseAnswer(proxy);
    await job.delete();
    equal(await count(), before + 2);
  },

  "streams give up": async ({ client, environment }) => {
    const url = await environment.durable();
    const job = await client({ attempts: 2 }, url).create(slow(1_000_000));
    const levels = job.iterations()[Symbol.asyncIterator]();
    await levels.next();
    await environment.kill(url);
    await refused((async () => { while (!(await levels.next()).done); })(), ConnectionLost);
    await refused(job.refresh(), ConnectionLost);
  },

  "signals end everything": async ({ client, environment }) => {
    const piad = client();
    const job = await piad.create(slow(1_000_000));
    const controller = new AbortController();
    const { signal } = controller;
    let seen = 0;
    const reading = (async () => { for await (const level of job.iterations({ signal })) seen = level.number; })();
    while (seen < 10) await sleep(0.01);
    const why = new Error("enough");
    controller.abort(why);
    equal(await refused(reading, Error), why);
    const open = async () => Number(/^piad_streams_open (\d+)$/m.exec(await piad.metrics())?.[1]);
    for (let i = 0; (await open()) > 0; i++) {
      ok(i < 100, "the server still streams");
      await sleep(0.02);
    }
    await refused(job.refresh({ signal }), Error);
    await job.shape();
    const waiting = Date.now();
    equal((await refused(job.iteration(900_000, { signal: AbortSignal.timeout(100) }), DOMException)).name, "TimeoutError");
    await refused(job.wait({ signal: AbortSignal.timeout(100) }), DOMException);
    ok(Date.now() - waiting < 8000, "answers that do not come are given up");
    await refused(first(job.iterations({ signal })), Error);
    await job.delete();
    // Waiting for a server that has stopped.
    const url = await environment.durable();
    const patient = client({ attempts: 20 }, url);
    await patient.live();
    await environment.kill(url);
    const started = Date.now();
    equal((await refused(patient.live({ signal: AbortSignal.timeout(700) }), DOMException)).name, "TimeoutError");
    ok(Date.now() - started < 8000);
  },

  "streams that are left can end their job": async ({ client, environment, url }) => {
    const stream = client().createStream(slow(1_000_000), { on_disconnect: "cancel" });
    for await (const level of stream) if (level.number === 5) break;
    const job = await client().job(stream.job?.id ?? "");
    equal((await job.wait()).state, "cancelled");
    const proxy = await environment.proxy(url);
    await environment.cutAfter(proxy, 20_000);
    const cut = client({}, proxy).createStream(slow(1_000_000), { on_disconnect: "cancel", view: "errors" });
    await all(cut);
    equal(cut.end?.state, "cancelled");
    const kept = client().createStream(slow(1_000_000));
    await first(kept);
    await sleep(0.2);
    const other = await client().job(kept.job?.id ?? "");
    equal(other.status.state, "running");
    await other.delete();
  },

  "who is slow is waited for": async ({ client, environment, url }) => {
    const proxy = await environment.proxy(url);
    const stream = client({}, proxy).createStream(large(400), { view: "control_points" });
    const levels = stream[Symbol.asyncIterator]();
    for (let i = 0; i < 3; i++) equal((await levels.next()).value?.number, i);
    const passed = () => environment.passed(proxy);
    let stalled = -1;
    for (let i = 0; (await passed()) > stalled; i++) {
      ok(i < 15, "the connection does not stall");
      stalled = await passed();
      await sleep(1);
    }
    ok(stalled < 100e6, `${stalled} bytes have come of about 400 MB`);
    for (let i = 3; i < 30; i++) equal((await levels.next()).value?.number, i);
    ok((await passed()) > 27e6);
    await levels.return();
    await (await client().job(stream.job?.id ?? "")).delete();
  },

  "servers without room are tried again": async ({ client }) => {
    let requests = 0;
    const answers = [new Response("", { status: 503, headers: { "Retry-After": "1" } }), new Response("", { status: 429 })];
    const flaky = client({ fetch: async (url, init) => (requests++, answers.shift() ?? fetch(url, init)) });
    const started = Date.now();
    await flaky.create(POINTS);
    equal([requests, Date.now() - started >= 1000], [3, true]);
    const busy = client({ attempts: 2, fetch: async () => new Response("full", { status: 503 }) });
    const error = await refused(busy.capabilities(), ApiError);
    equal([error.status, error.type, error.detail], [503, "about:blank", "full"]);
    const closed = client({ fetch: async () => new Response("", { status: 503, headers: { "Retry-After": "3600" } }) });
    equal((await refused(closed.capabilities(), ApiError)).retryAfter, 3600);
  },

  "surfaces are streamed as samples of 32 bits": async ({ client }) => {
    const stream = client().createStream({ surface: { points: SURFACE } }, { view: "samples", samples: "20x10", encoding: "base64_f32" });
    for await (const { samples, parameters } of stream) {
      ok(samples.data instanceof Float32Array);
      equal([samples.shape, parameters.map(({ length }) => length)], [[20, 10, 3], [20, 10]]);
    }
  },
};

function inPieces(response: Response, size: number): Response {
  const pieces = new TransformStream<Uint8Array, Uint8Array>({
    transform(chunk, controller) {
      for (let i = 0; i < chunk.length; i += size) controller.enqueue(chunk.slice(i, i + size));
    },
  });
  return new Response(response.body?.pipeThrough(pieces) ?? null, response);
}
