/** The life of jobs: each operation of the API. */

import { ApiError, ConnectionLost, type FittedIteration, ProtocolError, type Tensor, type api } from "piad";

import { all, equal, first, ok, refused } from "../check.js";
import { AUTOMATIC, AUTOMATIC_SURFACE, CURVE, FITS, slow } from "../shapes.js";
import type { Scenarios } from "../world.js";

const POINTS = { curve: { points: CURVE } };
/** Curves have no triangles for STL and PLY, and this one no geographic coordinates for GPX. */
const FORMATS: Readonly<Record<Exclude<api.ParameterFormat, "stl" | "ply" | "gpx">, string>> = {
  step: "ISO-10303-21;",
  iges: "",
  obj: "#",
  gltf: "glTF",
  dxf: "999",
  svg: "<",
  geojson: "{",
  csv: "t,x,y,z",
};

export const jobs: Scenarios = {
  "a curve is fitted": async ({ client }) => {
    const result = await client().fit({ ...POINTS, name: "arc", stop: { tolerance: 1e-9 } });
    equal([result.state, result.name, result.shape.kind], ["converged", "arc", "curve"]);
    const [{ knots, degree, kind }] = result.shape.bases;
    const [count = 0, dimension] = result.controlPoints.shape;
    equal([kind, degree, dimension, knots?.length], ["bspline", 3, 3, count + degree + 1]);
    equal([...result.controlPoints.data.slice(-3)], CURVE.at(-1));
    ok((result.error.max ?? 1) <= 1e-9);
  },

  "all shapes come the same in lists and in base64": async ({ client }) => {
    for (const [name, request] of Object.entries(FITS)) {
      const job = await client().create(request, { wait: 30 });
      const levels = await all(job.iterations({ view: "control_points" }));
      equal(await all(job.iterations({ view: "control_points", encoding: "json" })), levels, name);
      equal(levels.map(({ number }) => number), [...levels.keys()], name);
      const result = await job.result();
      equal(await job.result({ encoding: "json" }), result, name);
      const { controlPoints, weights, shape } = levels.at(-1)!;
      equal([controlPoints, weights, shape], [result.controlPoints, result.weights, result.shape], name);
      equal(await job.iteration(0), levels[0], name);
      consistent(levels[0]!, name);
      const sampled = await job.iteration("last", { view: "samples", samples: shape.bases.length === 1 ? 7 : "4x3" });
      equal(await job.iteration("last", { view: "samples", samples: shape.bases.length === 1 ? 7 : "4x3", encoding: "json" }), sampled);
      equal(sampled.parameters.map(({ length }) => length), shape.bases.length === 1 ? [7] : [4, 3]);
    }
  },

  "32 bits are Float32Arrays": async ({ client }) => {
    const job = await client().create(POINTS);
    const single = await first(job.iterations({ view: "control_points", encoding: "base64_f32" }));
    const double = await job.iteration(0);
    ok(single.controlPoints.data instanceof Float32Array && double.controlPoints.data instanceof Float64Array);
    equal(single.controlPoints.data, Float32Array.from(double.controlPoints.data));
    equal(single.shape.bases[0].knots, double.shape.bases[0].knots);
    const weighted = await client().create(FITS["fixedSurface"]!);
    const [rough, exact] = [await weighted.result({ encoding: "base64_f32" }), await weighted.result()];
    equal(rough.shape.fixedWeights?.shape, exact.shape.fixedWeights?.shape);
    exact.shape.fixedWeights?.data.forEach((weight, i) => ok(Math.abs(weight - rough.shape.fixedWeights!.data[i]!) < 1e-6));
  },

  "fits choose their knots": async ({ client }) => {
    for (const request of [AUTOMATIC, AUTOMATIC_SURFACE]) {
      const job = await client().create(request);
      const levels = await all(job.iterations({ view: "control_points" }));
      for (const level of levels) consistent(level, `iteration ${level.number}`);
      const counts = levels.map(({ controlPoints }) => controlPoints.data.length);
      ok(Math.max(...counts) > counts[0]!, "it has become finer");
      const middle = Math.floor(levels.length / 2);
      equal(await job.iteration(middle), levels[middle]);
      equal((await job.result()).shape, levels.at(-1)?.shape);
      const resumed = await all(job.iterations({ view: "control_points", after: middle }));
      equal(resumed, levels.slice(middle + 1));
      const errors = await all(job.iterations({ view: "errors" }));
      equal(errors.map(({ shape }) => shape), levels.map(({ shape }) => shape));
    }
  },

  "jobs are found, listed and deleted": async ({ client }) => {
    const piad = client();
    const made = [];
    for (const name of ["a", "b", "c", "d", "e"]) made.push((await piad.create({ ...POINTS, name }, { wait: 10 })).id);
    const listed = (await all(piad.jobs({ page: 2, state: "converged" }))).map(({ id }) => id);
    equal(listed.slice(0, 5), made.reverse());
    const job = await piad.job(made[0]!);
    equal([job.status.name, job.ended, (await job.input()).curve?.points], ["e", true, CURVE]);
    await job.delete();
    await job.delete();
    const gone = await refused(job.refresh(), ApiError);
    equal([gone.status, gone.type], [404, "/problems/unknown-job"]);
  },

  "fits need not be jobs": async ({ client }) => {
    const once = await client().fitOnce({ ...POINTS, stop: { tolerance: 1e-9 } });
    const kept = await client().fit({ ...POINTS, stop: { tolerance: 1e-9 } });
    equal([once.state, [...once.controlPoints.data]], ["converged", [...kept.controlPoints.data]]);
    equal((await refused(client().job(once.id), ApiError)).status, 404);
    const short = await refused(client().fitOnce({ ...POINTS, stop: { tolerance: 1e-9, max_iterations: 1 } }), ApiError);
    equal([short.status, short.type], [422, "/problems/not-converged"]);
  },

  "data are measured from the nearest points": async ({ client }) => {
    const job = await client().create(POINTS, { wait: 10 });
    const deviation = await job.deviation({ list: true });
    equal([deviation.iteration, (deviation.distances as number[]).length], [job.status.iteration, CURVE.length]);
    ok(deviation.max <= (job.status.error?.max ?? 0));
    equal((await job.deviation({ iteration: 0 })).distances, undefined);
  },

  "the shape of a fit is measured": async ({ client }) => {
    const job = await client().create(POINTS, { wait: 10 });
    const shape = await job.curvature({ samples: "9" });
    ok(shape.kind === "curve" && (shape.length ?? 0) > 0);
    equal((shape.samples.curvature as (number | null)[]).length, 9);
    ok(shape.curvature.largest !== null && shape.continuity.count === shape.continuity.knots.length);
    const first = await job.curvature({ iteration: 0, spacing: 0.5 });
    equal([first.kind, first.iteration], ["curve", 0]);
    equal((await refused(job.curvature({ samples: "9x9" }), ApiError)).status, 400);
  },

  "points are moved": async ({ client }) => {
    const job = await client().create(POINTS, { wait: 10 });
    const move: api.EditRequest = { points: [{ index: 2, point: [-1.5, 0, 1] }], method: { kind: "local", indices: [1, 2, 3] } };
    const edited = await job.edit(move, { wait: 10 });
    equal([edited.status.parent, edited.ended], [{ id: job.id, iteration: job.status.iteration }, true]);
    ok((await edited.limit()).max >= 0);
    const stream = job.editStream(move, { view: "control_points", changed: true });
    const levels = await all(stream);
    equal(levels, await all(edited.iterations({ view: "control_points" })));
    equal([stream.job?.kind, stream.end?.state], ["curve", edited.status.state]);
  },

  "points are dragged": async ({ client }) => {
    const sent: RequestInit[] = [];
    const watched = (address: string, init: RequestInit) => {
      if (address.includes("/edits")) sent.push(init);
      return fetch(address, init);
    };
    const job = await client({ fetch: watched }).create(POINTS, { wait: 10 });
    const move: api.EditRequest = { points: [{ index: 2, point: [-1.5, 0, 1] }], method: { kind: "local", indices: [1, 2, 3] } };
    const kept = await all((await job.edit(move, { wait: 10 })).iterations({ view: "control_points" }));
    const drag: api.EditRequest = { ...move, ephemeral: true, session: "mine" };
    const from = await job.iteration("last");
    const stream = job.editStream(drag, { describe: "none", changed: true, from });
    equal(await all(stream), kept);
    equal([stream.job?.knots, stream.job?.links, stream.end?.state], [undefined, null, "converged"]);
    // Knots that are not described are unknown.
    const short = await all(job.editStream(drag, { describe: "none", view: "control_points" }));
    equal([short.at(-1)?.shape.bases[0].knots, short.at(-1)?.controlPoints], [null, kept.at(-1)?.controlPoints]);
    await refused(all(job.editStream(drag, { changed: true })), ProtocolError);
    equal(sent.map(({ headers }) => new Headers(headers).has("Idempotency-Key")), [true, false, false, false]);
    const gone = await refused(client().job(stream.job!.id), ApiError);
    equal(gone.status, 404);
    equal((await refused(job.edit(drag), ApiError)).pointers, ["/ephemeral"]);
  },

  "a drag cannot be resumed": async ({ client }) => {
    const job = await client().create(POINTS, { wait: 10 });
    let posts = 0;
    const broken = async (address: string, init: RequestInit) => {
      if (!address.includes("/edits")) return fetch(address, init);
      posts += 1;
      const answer = await fetch(address, init);
      let rest = 700;
      const cut = new TransformStream<Uint8Array, Uint8Array>({
        transform(chunk, controller) {
          controller.enqueue(chunk.slice(0, rest));
          if ((rest -= chunk.length) <= 0) controller.error(new TypeError("the connection broke"));
        },
      });
      return new Response(answer.body!.pipeThrough(cut), answer);
    };
    const other = await client({ fetch: broken }).job(job.id);
    const edit: api.EditRequest = { points: [{ index: 2, point: [-1.5, 0, 1] }], ephemeral: true };
    await refused(all(other.editStream(edit, { describe: "none", view: "control_points", encoding: "json" })), ConnectionLost);
    equal(posts, 1);
  },

  "files of points are read": async ({ client }) => {
    const piad = client();
    const { curve, notices } = await piad.readPoints("\ufeffx;y\r\n1,5;2\r\n-3;0,25\r\n4;4\r\n");
    equal([curve?.points, notices], [[[1.5, 2], [-3, 0.25], [4, 4]], []]);
    equal((await piad.fit({ curve: curve! })).state, "converged");
    const field = Array.from({ length: 6 }, (_, i) => `${i % 3} ${i * i} ${i}`).join("\n");
    const { surface } = await piad.readPoints(new Blob([field]), { size: "2x3" });
    equal(surface?.points?.[1]?.[2], [2, 25, 5]);
    const wrong = await refused(piad.readPoints("1,2\n3,oops\n"), ApiError);
    equal([wrong.status, wrong.problem?.errors?.[0]?.line], [422, 2]);
  },

  "jobs are cancelled": async ({ client }) => {
    const job = await client().create(slow(1_000_000));
    await first(job.iterations());
    equal((await job.cancel()).state, "cancelled");
    equal((await job.result()).state, "cancelled");
    const late = await refused((await client().create(POINTS, { wait: 10 })).cancel(), ApiError);
    equal([late.status, late.type], [409, "/problems/already-ended"]);
  },

  "files are taken": async ({ client }) => {
    const job = await client().create({ ...POINTS, name: "Flügel" }, { wait: 10 });
    for (const [format, start] of Object.entries(FORMATS) as [keyof typeof FORMATS, string][]) {
      const file = await job.file(format);
      ok(file.size > 100 && file.name.length > 5, format);
      ok((await file.text()).startsWith(start), format);
    }
    const drawing = await job.file("csv", { iteration: 0, samples: 11 });
    equal((await drawing.text()).trim().split("\n").length, 12);
  },

  "servers behind a prefix": async ({ client, url }) => {
    const prefixed = `${url}/fits/`;
    const proxied = (address: string, init: RequestInit) => {
      ok(address.startsWith(prefixed), address);
      return fetch(address.replace(prefixed, `${url}/`), init);
    };
    const piad = client({ fetch: proxied }, prefixed);
    const [one, other] = [await piad.create(POINTS, { wait: 10 }), await piad.create(POINTS, { wait: 10 })];
    equal((await all(piad.jobs({ page: 1 }))).slice(0, 2).map(({ id }) => id), [other.id, one.id]);
    equal((await all(one.iterations())).length, (await all(other.iterations())).length);
  },

  "servers that know their prefix": async ({ client, environment }) => {
    const url = await environment.durable("/tools/fits");
    const piad = client({}, `${url}/tools/fits`);
    const [one, other] = [await piad.create(POINTS, { wait: 10 }), await piad.create(POINTS, { wait: 10 })];
    equal((await piad.service()).links["jobs"], "/tools/fits/v1/jobs");
    equal((await all(piad.jobs({ page: 1 }))).map(({ id }) => id), [other.id, one.id]);
    equal((await all(one.iterations())).length, (await all(other.iterations())).length);
  },

  "servers that ask for a token": async ({ client, environment }) => {
    const token = `piad_${"0123456789abcdef".repeat(4)}`;
    const url = await environment.durable("/", token);
    equal((await refused(client({}, url).create(POINTS), ApiError)).problem.type, "/problems/unauthenticated");
    const job = await client({ token }, url).create(POINTS, { wait: 10 });
    const events = `${url}/v1/jobs/${job.id}/events`;
    equal((await fetch(events)).status, 401);
    const { ticket, expires } = await job.ticket();
    ok(Date.parse(expires) > Date.now());
    const text = await (await fetch(`${events}?ticket=${ticket}`)).text();
    ok(text.includes("event: end"));
  },

  "a server without tokens has no tickets": async ({ client }) => {
    const job = await client().create(POINTS);
    equal((await refused(job.ticket(), ApiError)).problem.type, "/problems/no-tickets");
  },

  "information about a server": async ({ client }) => {
    const piad = client();
    ok((await piad.capabilities()).methods.length > 5);
    const rates = await piad.rates({ points: 5, degree: 2 });
    equal([rates.points, rates.bases.length > 2], [5, true]);
    const type = "/problems/invalid-fit";
    equal(await piad.problem(type), (await piad.problems()).find((problem) => problem.type === type));
    equal([(await piad.live()).status, (await piad.ready()).status], ["alive", "ready"]);
    ok((await piad.metrics()).includes("piad_iterations_total"));
    ok("version" in (await piad.service()));
    ok("paths" in (await piad.description()));
  },
};

/** Fails unless the numbers of control points and knots are consistent. */
function consistent({ shape, controlPoints, weights }: FittedIteration, name: string): void {
  const counts = shape.bases.map(({ knots, degree }) => (knots === null ? degree + 1 : knots.length - degree - 1));
  equal(controlPoints.shape.slice(0, -1), counts, name);
  for (const tensor of [controlPoints, weights, shape.fixedWeights]) if (tensor !== null) full(tensor, name);
  for (const tensor of [weights, shape.fixedWeights]) if (tensor !== null) equal(tensor.shape, counts, name);
}

function full({ data, shape }: Tensor, name: string): void {
  equal(data.length, shape.reduce((product, length) => product * length), name);
  ok(data.every(Number.isFinite), name);
}
