/** The client in the scenarios of tests/conformance/README.md. */

import { ApiError, Client, type Job, type Result, type Tensor, type api } from "piad";

type Summary = Record<string, unknown>;

const [scenario = "", url = "", token = ""] = process.argv.slice(2);
const client = new Client(url, { token });

const numbers = ({ data }: Tensor): number[] => Array.from(data);

const summary = (result: Result): Summary => {
  const [{ knots }] = result.shape.bases;
  const { state, iteration, error } = result;
  const ends = { control_points: numbers(result.controlPoints), knots: knots === null ? null : Array.from(knots) };
  return { state, iteration, error: error.max, ...ends };
};

/** The events of the stream of a new job. */
async function levels(request: api.JobRequest, { pause = 0, ready = false } = {}): Promise<Summary & { numbers: number[]; last: number[] }> {
  const stream = client.createStream(request, { view: "control_points" });
  const seen: number[] = [];
  let [first, last]: [number[], number[]] = [[], []];
  for await (const { number, controlPoints } of stream) {
    seen.push(number);
    last = numbers(controlPoints);
    if (seen.length === 1) first = last;
    if (ready && number === 5) console.log("ready");
    if (pause > 0) await new Promise((resolve) => setTimeout(resolve, pause));
  }
  return { numbers: seen, first, last, state: stream.end?.state };
}

async function refused(call: Promise<unknown>): Promise<ApiError> {
  const outcome = await call.then(() => null, (error: unknown) => error);
  if (outcome instanceof ApiError) return outcome;
  throw new Error(`it was not refused: ${String(outcome)}`);
}

const scenarios: Readonly<Record<string, (request: never) => Promise<Summary>>> = {
  fit: async (request: api.JobRequest) => summary(await client.fit(request)),
  watch: (request: api.JobRequest) => levels(request),
  resume: (request: api.JobRequest) => levels(request, { ready: true }),
  slow: (request: api.JobRequest) => levels(request, { pause: 20 }),

  large: async (request: api.JobRequest) => {
    const { numbers, last } = await levels(request);
    return { numbers, count: last.length, sum: last.reduce((sum, x) => sum + x, 0) };
  },

  differences: async (request: api.JobRequest) => {
    const stream = client.createStream(request, { view: "control_points", encoding: "delta" });
    const levels: [number, number[]][] = [];
    for await (const { number, controlPoints } of stream) levels.push([number, numbers(controlPoints)]);
    return { numbers: levels.map(([number]) => number), points: levels.map(([, points]) => points), state: stream.end?.state };
  },

  cancel: async (request: api.JobRequest) => {
    const job: Job = await client.create(request);
    for await (const _ of job.iterations({ view: "errors" })) break;
    const [{ state }, again] = [await job.cancel(), await job.cancel()];
    return { state, again: again.state };
  },

  edit: async ({ job: request, edit }: { job: api.JobRequest; edit: api.EditRequest }) => {
    const job = await client.create(request, { wait: 60 });
    await job.wait();
    const edited = await job.edit(edit);
    const result = summary(await edited.result());
    return { ...result, parent: job.id, is_parent: edited.status.parent?.id === job.id };
  },

  errors: async (request: api.JobRequest) => {
    const { status, type, pointers, detail } = await refused(client.create(request));
    return { status, type, pointers, detail };
  },

  tokens: async (request: api.JobRequest) => {
    const without = (await refused(new Client(url).create(request))).type;
    return { without, with: (await (await client.create(request)).wait()).state };
  },
};

let input = "";
for await (const chunk of process.stdin) input += String(chunk);
const play = scenarios[scenario];
if (play === undefined) throw new Error(`there is no scenario ${scenario}`);
console.log(JSON.stringify(await play(JSON.parse(input) as never)));
