/** Batches: many fits in one request, and their results. */

import type * as api from "./api.js";
import type { Call, Connection } from "./connection.js";
import { parse } from "./connection.js";
import { ApiError, ConnectionLost, PiadError, type Problem } from "./errors.js";
import { type Result, resultOf } from "./iteration.js";
import type { Cancellable } from "./options.js";

// A request is sent completely before its response is read: the server reads this far ahead.
const PART_LENGTH = 256 * 1024;
const PART_ITEMS = 5000;

// Milliseconds after which a partly filled request is sent.
const PART_TIME = 500;

const LINES = "application/x-ndjson";

/** Options of a batch. */
export interface Batching extends Cancellable {
  /** Job fields other than points, for items that do not set them. */
  readonly defaults?: Readonly<Record<string, unknown>> | undefined;
  /** The encoding of numbers; base64 is the default. */
  readonly encoding?: api.NumberEncoding | undefined;
}

/** The result of an item of a batch. */
export interface BatchItem {
  /** Its index in the batch, from 0. */
  readonly index: number;
  readonly name: string | null;
  /** `failed` also if the item is invalid. */
  readonly state: api.JobState;
  /** The number of the last iteration; null if there is none. */
  readonly iteration: number | null;
  readonly error: api.FitError | null;
  /** The last iteration, also if the fit has not converged; its id is empty. */
  readonly result: Result | null;
  /** Why it has not converged; its pointers begin with `/items/3` or `/defaults`. */
  readonly problem: Problem | null;
  /** Notes about the interpretation of its points, such as the chosen parameters. */
  readonly notices: readonly string[];
}

/** Counts of the items of a batch that have ended. */
export interface BatchTotals {
  readonly items: number;
  readonly converged: number;
  /** The number that have not converged. */
  readonly failed: number;
}

/** Jobs, as an iterable or async iterable. */
export type Items = Iterable<api.JobRequest> | AsyncIterable<api.JobRequest>;

/** The results of a batch, in the order of the items, as they complete. It can be iterated once. */
export class Batch implements AsyncIterable<BatchItem> {
  readonly #connection: Connection;
  readonly #items: AsyncGenerator<BatchItem, void, undefined>;
  readonly #options: Batching;
  #totals: BatchTotals = { items: 0, converged: 0, failed: 0 };

  constructor(connection: Connection, items: Items, options: Batching) {
    this.#connection = connection;
    this.#options = options;
    this.#items = this.#read(items);
  }

  /** Counts of the items so far. */
  get totals(): BatchTotals {
    return this.#totals;
  }

  [Symbol.asyncIterator](): AsyncGenerator<BatchItem, void, undefined> {
    return this.#items;
  }

  async *#read(items: Items): AsyncGenerator<BatchItem, void, undefined> {
    let first = 0;
    for await (const part of parts(items)) {
      for await (const item of this.#fit(part, first)) {
        const { converged, failed } = this.#totals;
        const has = item.state === "converged" ? 1 : 0;
        this.#totals = { items: item.index + 1, converged: converged + has, failed: failed + 1 - has };
        yield item;
      }
      first += part.length;
    }
  }

  /** Fits a group of items. After a broken connection, items without a result are sent again. */
  async *#fit(lines: readonly string[], first: number): AsyncGenerator<BatchItem, void, undefined> {
    const retries = this.#connection.retries();
    for (let sent = 0; sent < lines.length; ) {
      const rest = lines.slice(sent);
      try {
        let ended = false;
        for await (const line of this.#lines(rest)) {
          if ("totals" in line) ended = true;
          else if (!("index" in line)) throw new ApiError(line.problem);
          else {
            sent += 1;
            retries.reset();
            yield itemOf(line, first + sent - 1);
          }
        }
        if (ended) return;
        throw new ConnectionLost("the answer to the batch has no end");
      } catch (error) {
        if (!(error instanceof PiadError)) throw error;
        await retries.wait(error, this.#options.signal);
      }
    }
  }

  /** The lines of the response to a group. */
  async *#lines(items: readonly string[]): AsyncGenerator<api.BatchLine, void, undefined> {
    const { defaults, encoding = "base64", signal } = this.#options;
    const begin = defaults === undefined ? "" : `${JSON.stringify({ defaults })}\n`;
    const call: Call = {
      method: "POST",
      path: "/v1/batch",
      query: { encoding },
      headers: { Accept: LINES },
      text: { type: LINES, content: begin + items.join("") },
      signal,
    };
    const { response, attempt } = await this.#connection.stream(call);
    try {
      for await (const line of linesOf(attempt.chunks(response))) yield parse<api.BatchLine>(line);
    } finally {
      attempt.end();
    }
  }
}

/** An item of a batch, with its index. */
function itemOf(line: api.BatchItem, index: number): BatchItem {
  const { name = null, state, iteration = null, error = null, problem, notices = [] } = line;
  const fitted = (kind: "curve" | "surface", geometry: api.FitGeometry | undefined): Result | null => {
    if (geometry === undefined || iteration === null || error === null) return null;
    return resultOf({ ...geometry, id: "", kind, name, state, iteration, error });
  };
  const result = fitted("curve", line.curve) ?? fitted("surface", line.surface);
  const moved = problem === undefined ? null : movedTo(problem, line.index, index);
  return { index, name, state, iteration, error, result, problem: moved, notices };
}

/** Replaces the index of the item in its request by that in the batch. */
function movedTo(problem: Problem, own: number, index: number): Problem {
  const place = new RegExp(`/items/${own}(?![0-9])`, "g");
  const moved = (text: string) => text.replace(place, `/items/${index}`);
  const errors = problem.errors?.map(({ pointer, ...error }) =>
    pointer === undefined ? error : { ...error, pointer: moved(pointer) },
  );
  return { ...problem, detail: moved(problem.detail), ...(errors && { errors }) };
}

/** Groups items as lines. */
async function* parts(items: Items): AsyncGenerator<readonly string[], void, undefined> {
  let part: string[] = [];
  let [length, begun] = [0, 0];
  for await (const item of items) {
    // NaN and infinity become null, so that only this item fails.
    const line = `${JSON.stringify(item)}\n`;
    if (part.length > 0 && length + line.length > PART_LENGTH) {
      yield part;
      [part, length] = [[], 0];
    }
    if (part.length === 0) begun = Date.now();
    part.push(line);
    length += line.length;
    if (part.length >= PART_ITEMS || Date.now() - begun > PART_TIME) {
      yield part;
      [part, length] = [[], 0];
    }
  }
  if (part.length > 0) yield part;
}

/** Splits chunks of text into lines. */
async function* linesOf(chunks: AsyncIterable<Uint8Array>): AsyncGenerator<string, void, undefined> {
  const decoder = new TextDecoder();
  let begun = "";
  for await (const chunk of chunks) {
    const [end = "", ...lines] = decoder.decode(chunk, { stream: true }).split("\n");
    begun += end;
    for (const line of lines) {
      yield begun;
      begun = line;
    }
  }
}
