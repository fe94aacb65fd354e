/** Failures: rejected requests, no server, another server, silence. */

import { ApiError, Client, ConnectionLost, JobFailed, PiadError, ProtocolError } from "piad";

import { equal, ok, refused } from "../check.js";
import { CURVE } from "../shapes.js";
import type { Scenarios } from "../world.js";

export const failures: Scenarios = {
  "errors have locations": async ({ client }) => {
    const curve = { points: [[0, 0], [1, 2], [1, 2]] };
    const error = await refused(client().create({ curve, stop: { tolerance: -1 } }), ApiError);
    ok(error instanceof PiadError);
    equal([error.status, error.type, error.title], [422, "/problems/invalid-fit", error.problem.title]);
    ok(error.pointers.includes("/stop/tolerance") && error.pointers.includes("/curve/points/2"), error.message);
    ok(error.errors.every(({ detail }) => error.detail.includes(detail) || detail.length > 0));
    ok(error.message.startsWith(`422 ${error.title}: `));
    const streamed = await refused(client().createStream({ curve })[Symbol.asyncIterator]().next(), ApiError);
    equal(streamed.status, 422);
    const bad = await refused(client().rates({ points: 1 }), ApiError);
    equal([bad.status, bad.errors[0]?.parameter], [400, "points"]);
    // @ts-expect-error: unknown basis.
    const typed = await refused(client().create({ curve: { points: CURVE, basis: { kind: "nurbs" } } }), ApiError);
    ok(typed.pointers.includes("/curve/basis/kind"));
  },

  "numbers that JSON does not have": async ({ client }) => {
    const request = { name: null, curve: { points: [[0, 0], [1, NaN], [2, 0]] } };
    const error = await refused(client().create(request), RangeError);
    equal(error.message, "curve.points[1][1] is NaN: numbers must be finite");
    equal((await client().create({ name: null, curve: { points: CURVE } })).status.name, null);
  },

  "jobs that fail": async ({ client }) => {
    const points = Array.from({ length: 900 }, (_, i) => [i, Math.sin(i)]);
    const curve = { points, parameters: "uniform", basis: { kind: "bernstein" } } as const;
    const job = await client().create({ curve, method: { kind: "extended", start: "data" } });
    const error = await refused(job.result(), JobFailed);
    equal([error.status.state, error.problem?.type], ["failed", "/problems/overflow"]);
    ok(error.message.includes(job.id) && error.message.includes(error.problem?.detail ?? "nothing"));
  },

  "addresses": async ({ client, url }) => {
    for (const wrong of ["127.0.0.1:8080", "ftp://127.0.0.1", "http://"]) {
      try {
        new Client(wrong);
      } catch (error) {
        ok(error instanceof TypeError);
        continue;
      }
      ok("location" in globalThis && wrong !== "ftp://127.0.0.1", wrong);
    }
    await refused(Promise.resolve().then(() => client({ attempts: 0 })), RangeError);
    ok(await client({}, `${url}/`).live());
  },

  "no server listens": async ({ client, environment }) => {
    const started = Date.now();
    const url = await environment.nowhere();
    const error = await refused(client({}, url).capabilities(), ConnectionLost);
    ok(error.message.includes(url) && error.cause instanceof Error, error.message);
    ok(Date.now() - started < 10_000);
  },

  "a server that does not respond": async ({ client }) => {
    const silent = (_: string, { signal }: RequestInit) =>
      new Promise<Response>((_, reject) => signal?.addEventListener("abort", () => reject(signal.reason)));
    const error = await refused(client({ fetch: silent, timeout: 0.1, attempts: 2 }).live(), ConnectionLost);
    ok(error.message.includes("0.1 s of silence"), error.message);
  },

  "others than a server": async ({ client }) => {
    const page = client({ fetch: async () => new Response("<html>", { headers: { "Content-Type": "text/html" } }) });
    await refused(page.capabilities(), ProtocolError);
    const missing = client({ fetch: async () => new Response("no", { status: 404, statusText: "Not Found" }) });
    const error = await refused(missing.capabilities(), ApiError);
    equal([error.problem, error.pointers], [{ type: "about:blank", title: "Not Found", status: 404, detail: "no" }, []]);
  },

  "headers go with every request": async ({ client }) => {
    const seen: (string | null)[] = [];
    const headers = { Authorization: "Bearer x" };
    const piad = client({ headers, fetch: (url, init) => (seen.push(new Headers(init.headers).get("Authorization")), fetch(url, { ...init, headers: [] })) });
    await piad.live();
    equal(seen, ["Bearer x"]);
  },
};
