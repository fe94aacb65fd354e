/** Requests that end with their caller's signal, or when the server is silent for too long. */

import { ConnectionLost } from "./errors.js";

// Bytes in a second: servers give bodies up that come more slowly.
const SLOWEST_BODY = 16 * 1024;

/** A function like the global `fetch`. */
export type Fetch = (url: string, init: RequestInit) => Promise<Response>;

/** What is sent. */
export interface Sent extends RequestInit {
  readonly body?: string | Blob;
}

/** One request and its answer. */
export class Attempt {
  readonly #controller = new AbortController();
  readonly #signal: AbortSignal | undefined;
  readonly #patience: number;
  #silent = false;

  /** `patience` is how many seconds the server may be silent. */
  constructor(signal: AbortSignal | undefined, patience: number) {
    this.#signal = signal;
    this.#patience = patience;
    signal?.addEventListener("abort", this.#abort, { once: true });
  }

  /** The beginning of the answer. Nobody tells how much of a body has gone: large ones have longer. */
  async send(fetch: Fetch, url: string, init: Sent): Promise<Response> {
    const seconds = this.#patience + sizeOf(init.body) / SLOWEST_BODY;
    return this.#listen(url, seconds, () => fetch(url, { ...init, signal: this.#controller.signal }));
  }

  /** The body of the answer, each piece when it is asked for: who asks for no more stops the server. */
  async *chunks(response: Response): AsyncGenerator<Uint8Array, void, undefined> {
    const reader = response.body?.getReader();
    while (reader !== undefined) {
      const { done, value } = await this.#listen(response.url, this.#patience, () => reader.read());
      if (done) return;
      yield value;
    }
  }

  /** The whole body. */
  async body(response: Response): Promise<Blob> {
    const parts: BlobPart[] = [];
    for await (const chunk of this.chunks(response)) parts.push(chunk as Uint8Array<ArrayBuffer>);
    return new Blob(parts, { type: response.headers.get("Content-Type") ?? "" });
  }

  /** Closes the connection, unless it is free for another request. */
  end(): void {
    this.#signal?.removeEventListener("abort", this.#abort);
    this.#controller.abort();
  }

  readonly #abort = (): void => this.#controller.abort(this.#signal?.reason);

  /** Waits for the server, which may be silent for so many seconds. */
  async #listen<T>(url: string, seconds: number, next: () => Promise<T>): Promise<T> {
    this.#signal?.throwIfAborted();
    const timer = setTimeout(this.#giveUp, seconds * 1000);
    try {
      return await next();
    } catch (error) {
      this.#signal?.throwIfAborted();
      throw this.#lost(url, error);
    } finally {
      clearTimeout(timer);
    }
  }

  readonly #giveUp = (): void => {
    this.#silent = true;
    this.#controller.abort();
  };

  #lost(url: string, cause: unknown): ConnectionLost {
    const why = this.#silent ? `more than ${this.#patience} s of silence` : reason(cause);
    return new ConnectionLost(`lost the connection to ${url}: ${why}`, { cause });
  }
}

/** What broke the connection; Node has an error behind the one that it throws. */
function reason(error: unknown): string {
  if (!(error instanceof Error)) return String(error);
  const { cause } = error;
  if (!(cause instanceof Error)) return error.message;
  return `${error.message}: ${cause.message || (cause as { code?: string }).code}`;
}

/** About how many bytes a body has. */
function sizeOf(body: Sent["body"]): number {
  if (body === undefined) return 0;
  return typeof body === "string" ? body.length : body.size;
}
