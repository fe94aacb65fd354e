/** The event stream of a job, across connections. */

import type { EventSourceMessage } from "eventsource-parser";

import type * as api from "./api.js";
import type { Patience } from "./backoff.js";
import { type Call, type Connection, parse } from "./connection.js";
import { ConnectionLost, PiadError, ProtocolError } from "./errors.js";
import { type Iteration, iterationOf } from "./iteration.js";
import { type Shape, shapeOf } from "./shape.js";
import { events } from "./sse.js";

// As long as the server has not said how long to wait.
const RETRY = 2;

/** Where a stream begins, and where it goes on. */
export interface Source {
  /** The request that is sent until the job is known. */
  readonly first: Call;
  /** The one after that, with the id of the job; null where there is no job to go on with. */
  readonly next: ((id: string) => Call) | null;
  /** The number of the iteration after which it begins. */
  readonly after?: number | undefined;
  /** The iteration that an edit starts from. */
  readonly from?: Iteration | undefined;
}

/**
 * The iterations of a job as they are computed, each once and in order: `for await (const iteration of stream)`.
 *
 * Whenever the connection breaks or the server stops it is opened again after the last event that arrived.
 * The waiting time is the one that the server asks for, and grows as long as no iteration arrives. Nothing is
 * read ahead of the loop: while its body is slow, the server waits. A loop that is left closes the connection.
 * The stream of an ephemeral edit cannot go on: it throws `ConnectionLost` when its connection breaks.
 */
export class Stream<Item extends Iteration = Iteration> implements AsyncIterable<Item> {
  /** What was said of the job when the connection was made; null before that. */
  job: api.JobEvent | null = null;
  /** How the job ended; null as long as that is not known. */
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

  /** The events as the server writes them. The `job` event comes with every connection. */
  async *events(): AsyncGenerator<api.EventLine, void, undefined> {
    const reading = new Reading(this.#connection.patience(), this.#source);
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

/** How far a stream has been read. */
class Reading {
  readonly #patience: Patience;
  readonly #source: Source;
  #id: string | null = null;
  #seen: number | null;
  /** The id of that iteration: its number, unless the server has said more. */
  #last: string | null;
  #retry = RETRY;

  constructor(patience: Patience, source: Source) {
    this.#patience = patience;
    this.#source = source;
    this.#seen = source.after ?? null;
    this.#last = this.#seen === null ? null : String(this.#seen);
  }

  /** The events of one connection, without those that are known. */
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

  /** It has begun, and there is no job to go on with. */
  get cannotGoOn(): boolean {
    return this.#id !== null && this.#source.next === null;
  }

  wait(error: PiadError): Promise<void> {
    return this.#patience.wait(error, this.#source.first.signal, this.#retry);
  }

  #call(): Call {
    const { first, next } = this.#source;
    const call = this.#id === null || next === null ? first : next(this.#id);
    if (this.#last === null) return call;
    return { ...call, headers: { ...call.headers, "Last-Event-ID": this.#last } };
  }

  /** Whether the event has not been seen, which it has been now. */
  #isNew(event: api.EventLine): boolean {
    if (event.event === "job") {
      this.#id = event.data.id;
      // What follows are all iterations again, of another version of the server.
      if (event.data.resumed === "restarted") [this.#seen, this.#last] = [null, null];
    }
    if (event.event !== "iteration") return true;
    const k = event.data.iteration;
    if (this.#seen !== null && k <= this.#seen) return false;
    this.#seen = k;
    this.#last = String(event.id);
    this.#patience.reset();
    return true;
  }
}

/** An event, or null where it is of a kind that later versions may have. */
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
