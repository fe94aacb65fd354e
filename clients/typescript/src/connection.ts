/** Requests with retries; responses as values or errors. */

import type * as api from "./api.js";
import { Attempt, type Fetch, type Sent } from "./attempt.js";
import { Patience, attemptsFor, retryAfter } from "./backoff.js";
import { ApiError, PiadError, type Problem, ProtocolError } from "./errors.js";
import { encoded } from "./json.js";

/** What can be a query parameter; lists are separated by commas. */
export type Parameters = Readonly<Record<string, string | number | boolean | readonly number[] | null | undefined>>;

/** A request. */
export interface Call {
  readonly method?: "GET" | "POST" | "DELETE";
  /** The path below the address of the server; it may have a query of its own. */
  readonly path: string;
  readonly query?: Parameters | undefined;
  /** What is sent as JSON. */
  readonly body?: unknown;
  /** What is sent as it is, instead. */
  readonly text?: { readonly type: string; readonly content: string | Blob };
  readonly headers?: Readonly<Record<string, string>>;
  readonly signal?: AbortSignal | undefined;
  /** A status of problems that is an answer, too. */
  readonly accepted?: number;
}

/** The answer to a request, whose body is read by who asked. */
export interface Answer {
  readonly response: Response;
  readonly attempt: Attempt;
}

/** What is the same for all requests to a server. */
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
 * The way to a server. Each request may be sent more than once: those that create something have a key by which the
 * server recognises them.
 */
export class Connection {
  readonly #settings: Settings;
  #hasAnswered = false;

  constructor(settings: Settings) {
    this.#settings = settings;
  }

  /** A count of failures, as many as this server is worth. */
  patience(): Patience {
    return new Patience(() => attemptsFor(this.#hasAnswered, this.#settings.attempts));
  }

  /** The longest time in seconds that the server may be asked to wait before it answers. */
  get longestWait(): number {
    return this.#settings.timeout / 2;
  }

  /** The object that is answered. */
  async json<T>(call: Call): Promise<T> {
    return this.request(call, async ({ response, attempt }) => parse<T>(await (await attempt.body(response)).text()));
  }

  /** What `read` makes of an answer that is not an error; it is read again when the connection breaks. */
  async request<T>(call: Call, read: (answer: Answer) => Promise<T>): Promise<T> {
    const patience = this.patience();
    const init = this.#init(call, "application/json");
    for (;;) {
      const attempt = new Attempt(call.signal, this.#settings.timeout);
      try {
        return await read({ response: await this.#send(attempt, call, init), attempt });
      } catch (error) {
        if (!(error instanceof PiadError)) throw error;
        await patience.wait(error, call.signal);
      } finally {
        attempt.end();
      }
    }
  }

  /** An event stream. Nothing is tried again; the attempt has to be ended. */
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

/** The address of a server, without a slash at the end. */
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

/** A value of the API from its JSON. */
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
