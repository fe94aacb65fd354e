/** The event stream of a job, across connections. */

import type { EventSourceMessage } from "eventsource-parser";

import type * as api from "./api.js";
import type { Retries } from "./backoff.js";
import { type Call, type Connection, parse } from "./connection.js";
import { ConnectionLost, PiadError, ProtocolError } from "./errors.js";
import { type Iteration, iterationOf } from "./iteration.js";
import { type Shape, shapeOf } from "./shape.js";
import { events } from "./sse.js";

// The delay until the server sends one.
const RETRY = 2;

/** The requests that open and resume a stream. */
export interface Source {
  /** The request that is sent until the id of the job is known. */
  readonly first: Call;
  /** The request after that, with the id of the job; null if the stream cannot be resumed. */
  readonly next: ((id: string) => Call) | null;
  /** The number of the iteration after which the stream starts. */
  readonly after?: number | undefined;
  /** The iteration from which an edit starts. */
  readonly from?: Iteration | undefined;
}

/**
 * The iterations of a job as they are computed, each once and in order: `for await (const iteration of stream)`.
 *
 * If the connection breaks or the server stops, the stream is reopened after the last event received. The delay is the
 * one requested by the server and grows until an iteration arrives. Nothing is read ahead of the loop: a slow loop
 * holds back the server. Leaving the loop closes the connection. The stream of an ephemeral edit cannot be resumed: it
 * throws `ConnectionLost` when its connection breaks.
 */
export class Stream<Item extends Iteration = Iteration> implements AsyncIterable<Item> {
  /** The state of the job when the connection was opened; null before that. */
  job: api.JobEvent | null = null;
  /** The end of the job; null until it is received. */
  end: api.EndEvent | null = null;
  readonly #connection: Connection;
  readonly #source: Source;

  /** Use the methods of `Client` and `Job`. */
  constructor(connection: Connection, source: Source) {
    this.#connection = connection;
    this.#source = source;
  }

  async *[Symbol.asyncIterator](): AsyncGenerator<Item, void, undefined> {
    let shape: Shape | null = null;
    const { from } = this.#source;
    let before: Iteration | null = from ?? null;
    for await (const { event, data } of this.events()) {
      if (event === "job") shape = data.knots === undefined && from !== undefined ? from.shape : shapeOf(data);
      if (event !== "iteration") continue;
      if (shape === null) throw new ProtocolError("the server sent an iteration before its job");
      before = iterationOf(data, shape, before);
      ({ shape } = before);
      yield before as Item;
    }
  }

  /** The events as the server writes them. Each connection begins with a `job` event. */
  async *events(): AsyncGenerator<api.EventLine, void, undefined> {
    const reading = new Reading(this.#connection.retries(), this.#source);
    for (;;) {
      try {
        for await (const event of reading.once(this.#connection)) {
          if (event.event === "job") this.job = event.data;
          if (event.event === "end") this.end = event.data;
          yield event;
          if (event.event === "end") return;
        }
        throw new ConnectionLost("the stream ended before the job");
      } catch (error) {
        if (!(error instanceof PiadError) || reading.cannotGoOn) throw error;
        await reading.wait(error);
      }
    }
  }
}

/** The position in a stream. */
class Reading {
  readonly #retries: Retries;
  readonly #source: Source;
  #id: string | null = null;
  #seen: number | null;
  /** The event id of that iteration: its number, possibly with a suffix. */
  #last: string | null;
  #retry = RETRY;

  constructor(retries: Retries, source: Source) {
    this.#retries = retries;
    this.#source = source;
    this.#seen = source.after ?? null;
    this.#last = this.#seen === null ? null : String(this.#seen);
  }

  /** The events of one connection, without those already received. */
  async *once(connection: Connection): AsyncGenerator<api.EventLine, void, undefined> {
    const { response, attempt } = await connection.stream(this.#call());
    try {
      for await (const piece of events(attempt.chunks(response))) {
        if ("retry" in piece) {
          this.#retry = piece.retry;
          continue;
        }
        this.#source.first.signal?.throwIfAborted();
        const event = eventOf(piece);
        if (event !== null && this.#isNew(event)) yield event;
      }
    } finally {
      attempt.end();
    }
  }

  /** The stream has started and cannot be resumed. */
  get cannotGoOn(): boolean {
    return this.#id !== null && this.#source.next === null;
  }

  wait(error: PiadError): Promise<void> {
    return this.#retries.wait(error, this.#source.first.signal, this.#retry);
  }

  #call(): Call {
    const { first, next } = this.#source;
    const call = this.#id === null || next === null ? first : next(this.#id);
    if (this.#last === null) return call;
    return { ...call, headers: { ...call.headers, "Last-Event-ID": this.#last } };
  }

  /** Returns true if the event is new, and marks it as seen. */
  #isNew(event: api.EventLine): boolean {
    if (event.event === "job") {
      this.#id = event.data.id;
      // The server was replaced by another version and sends all iterations again.
      if (event.data.resumed === "restarted") [this.#seen, this.#last] = [null, null];
    }
    if (event.event !== "iteration") return true;
    const k = event.data.iteration;
    if (this.#seen !== null && k <= this.#seen) return false;
    this.#seen = k;
    this.#last = String(event.id);
    this.#retries.reset();
    return true;
  }
}

/** Parses an event; null for kinds of later versions. */
function eventOf({ event, id, data }: EventSourceMessage): api.EventLine | null {
  switch (event) {
    case "job":
      return { event, data: parse<api.JobEvent>(data) };
    case "iteration": {
      const iteration = parse<api.IterationEvent>(data);
      const k = iteration.iteration;
      return { event, id: id === String(k) ? k : (id ?? ""), data: iteration };
    }
    case "end":
      return { event, id: "end", data: parse<api.EndEvent>(data) };
    default:
      return null;
  }
}
