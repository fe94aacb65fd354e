/** Requests with retries; responses as values or errors. */

import type * as api from "./api.js";
import { Attempt, type Fetch, type Sent } from "./attempt.js";
import { Retries, attemptsFor, retryAfter } from "./backoff.js";
import { ApiError, PiadError, type Problem, ProtocolError } from "./errors.js";
import { encoded } from "./json.js";

/** Values of query parameters; lists are separated by commas. */
export type Parameters = Readonly<Record<string, string | number | boolean | readonly number[] | null | undefined>>;

/** A request. */
export interface Call {
  readonly method?: "GET" | "POST" | "DELETE";
  /** The path below the address of the server; it may contain a query. */
  readonly path: string;
  readonly query?: Parameters | undefined;
  /** A body that is sent as JSON. */
  readonly body?: unknown;
  /** A body that is sent unchanged. */
  readonly text?: { readonly type: string; readonly content: string | Blob };
  readonly headers?: Readonly<Record<string, string>>;
  readonly signal?: AbortSignal | undefined;
  /** An error status that counts as success. */
  readonly accepted?: number;
}

/** A response, whose body is read by the caller. */
export interface Answer {
  readonly response: Response;
  readonly attempt: Attempt;
}

/** Settings of all requests to a server. */
export interface Settings {
  readonly baseUrl: string;
  readonly attempts: number;
  readonly timeout: number;
  readonly headers: Headers;
  readonly fetch: Fetch;
}

// Servers send a comment every 15 seconds.
const QUIET_STREAM = 60;

/**
 * A connection to a server. Each request may be sent more than once: those that create something have a key by which
 * the server recognises them.
 */
export class Connection {
  readonly #settings: Settings;
  #hasAnswered = false;

  constructor(settings: Settings) {
    this.#settings = settings;
  }

  /** A counter of failures with the limit for this server. */
  retries(): Retries {
    return new Retries(() => attemptsFor(this.#hasAnswered, this.#settings.attempts));
  }

  /** The longest wait, in seconds, that may be requested from the server. */
  get longestWait(): number {
    return this.#settings.timeout / 2;
  }

  /** The JSON object of the response. */
  async json<T>(call: Call): Promise<T> {
    return this.request(call, async ({ response, attempt }) => parse<T>(await (await attempt.body(response)).text()));
  }

  /** Returns `read` of a successful response; after a broken connection the request is repeated. */
  async request<T>(call: Call, read: (answer: Answer) => Promise<T>): Promise<T> {
    const retries = this.retries();
    const init = this.#init(call, "application/json");
    for (;;) {
      const attempt = new Attempt(call.signal, this.#settings.timeout);
      try {
        return await read({ response: await this.#send(attempt, call, init), attempt });
      } catch (error) {
        if (!(error instanceof PiadError)) throw error;
        await retries.wait(error, call.signal);
      } finally {
        attempt.end();
      }
    }
  }

  /** Opens an event stream without retries; the attempt must be ended. */
  async stream(call: Call): Promise<Answer> {
    const attempt = new Attempt(call.signal, Math.max(this.#settings.timeout, QUIET_STREAM));
    try {
      const init = this.#init(call, "text/event-stream");
      return { response: await this.#send(attempt, call, init), attempt };
    } catch (error) {
      attempt.end();
      throw error;
    }
  }

  #init(call: Call, accept: string): Sent {
    const headers = new Headers(this.#settings.headers);
    headers.set("Accept", accept);
    for (const [name, value] of Object.entries(call.headers ?? {})) headers.set(name, value);
    if (call.text !== undefined) {
      headers.set("Content-Type", call.text.type);
      return { method: call.method ?? "GET", headers, body: call.text.content };
    }
    if (call.body === undefined) return { method: call.method ?? "GET", headers };
    headers.set("Content-Type", "application/json");
    return { method: call.method ?? "GET", headers, body: encoded(call.body) };
  }

  async #send(attempt: Attempt, call: Call, init: Sent): Promise<Response> {
    const url = `${this.#settings.baseUrl}${call.path}${search(call.query)}`;
    const response = await attempt.send(this.#settings.fetch, url, { ...init, cache: "no-store" });
    this.#hasAnswered = true;
    if (response.ok || response.status === call.accepted) return response;
    throw await refusal(response, attempt);
  }
}

/** The address of a server, without a trailing slash. */
export function serverUrl(text: string | URL): string {
  const base = (globalThis as { location?: { href: string } }).location?.href;
  const url = new URL(text, base);
  if (url.protocol !== "http:" && url.protocol !== "https:") {
    throw new TypeError(`"${text}" is not the URL of a server, which begins with http:// or https://`);
  }
  return `${url.origin}${url.pathname.replace(/\/+$/, "")}`;
}

function search(query: Parameters | undefined): string {
  const given = Object.entries(query ?? {}).filter(([, value]) => value !== undefined && value !== null);
  return given.length === 0 ? "" : `?${new URLSearchParams(given.map(([name, value]) => [name, String(value)]))}`;
}

/** Parses JSON of the API. */
export function parse<T>(text: string): T {
  try {
    return JSON.parse(text) as T;
  } catch (cause) {
    throw new ProtocolError("the server did not answer JSON", { cause });
  }
}

/** The problem in a response; for responses of proxies it is made from the status. */
async function refusal(response: Response, attempt: Attempt): Promise<ApiError> {
  const text = await (await attempt.body(response)).text();
  const named = response.headers.get("Content-Type")?.startsWith("application/problem+json") === true;
  const problem: Problem = named
    ? parse<api.Problem>(text)
    : { type: "about:blank", title: response.statusText, status: response.status, detail: text.slice(0, 1000) };
  return new ApiError(problem, retryAfter(response.headers));
}
