/** Requests that end with the caller's signal, or when the server is silent for too long. */

import { ConnectionLost } from "./errors.js";

// Bytes per second: servers reject bodies that arrive more slowly.
const SLOWEST_BODY = 16 * 1024;

/** A function like the global `fetch`. */
export type Fetch = (url: string, init: RequestInit) => Promise<Response>;

/** The request. */
export interface Sent extends RequestInit {
  readonly body?: string | Blob;
}

/** One request and its answer. */
export class Attempt {
  readonly #controller = new AbortController();
  readonly #signal: AbortSignal | undefined;
  readonly #maxSilence: number;
  #silent = false;

  /** `maxSilence` is the longest silence of the server in seconds. */
  constructor(signal: AbortSignal | undefined, maxSilence: number) {
    this.#signal = signal;
    this.#maxSilence = maxSilence;
    signal?.addEventListener("abort", this.#abort, { once: true });
  }

  /** The head of the response. `fetch` does not report upload progress, so large bodies get more time. */
  async send(fetch: Fetch, url: string, init: Sent): Promise<Response> {
    const seconds = this.#maxSilence + sizeOf(init.body) / SLOWEST_BODY;
    return this.#listen(url, seconds, () => fetch(url, { ...init, signal: this.#controller.signal }));
  }

  /** The body of the response. Chunks are read on demand, so a slow consumer holds back the server. */
  async *chunks(response: Response): AsyncGenerator<Uint8Array, void, undefined> {
    const reader = response.body?.getReader();
    while (reader !== undefined) {
      const { done, value } = await this.#listen(response.url, this.#maxSilence, () => reader.read());
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

  /** Closes the connection, unless it can be reused. */
  end(): void {
    this.#signal?.removeEventListener("abort", this.#abort);
    this.#controller.abort();
  }

  readonly #abort = (): void => this.#controller.abort(this.#signal?.reason);

  /** Waits for the server, with this limit of its silence in seconds. */
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
    const why = this.#silent ? `more than ${this.#maxSilence} s of silence` : reason(cause);
    return new ConnectionLost(`lost the connection to ${url}: ${why}`, { cause });
  }
}

/** The cause of a broken connection, which Node wraps in another error. */
function reason(error: unknown): string {
  if (!(error instanceof Error)) return String(error);
  const { cause } = error;
  if (!(cause instanceof Error)) return error.message;
  return `${error.message}: ${cause.message || (cause as { code?: string }).code}`;
}

/** The approximate size of a body in bytes. */
function sizeOf(body: Sent["body"]): number {
  if (body === undefined) return 0;
  return typeof body === "string" ? body.length : body.size;
}
