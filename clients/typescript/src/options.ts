/** Options of requests. */

import type * as api from "./api.js";
import type { Iteration } from "./iteration.js";

/** Options of each request. */
export interface Cancellable {
  /** Ends the request, also while it waits for a retry; its reason is thrown. */
  readonly signal?: AbortSignal | undefined;
}

/** Options of requests that create something. */
export interface Repeatable extends Cancellable {
  /**
   * The key by which the server recognises a retry. Random by default; programs that may themselves restart should set
   * it.
   */
  readonly idempotencyKey?: string | undefined;
}

/** Options of requests for a new job. */
export interface Creation extends Repeatable {
  /** How many seconds the server may wait for the end of the job before it responds. */
  readonly wait?: number | undefined;
}

/** The query parameters, with `samples` also as a number. */
type Plain<Query> = { readonly [Name in keyof Query]?: (Name extends "samples" ? api.Samples : Query[Name]) | undefined };

/** Stream settings: see docs/reference/events.md. Omitted ones are those of the job. */
export interface Showing<View extends api.View = api.View>
  extends Omit<Plain<api.Query<"watchJob">>, "on_disconnect" | "view">, Cancellable {
  readonly view?: View | undefined;
}

/** Options of the stream of an existing job. */
export interface Watching<View extends api.View = api.View> extends Showing<View> {
  /** The number of the iteration after which the stream starts. */
  readonly after?: number | undefined;
}

/** Options of the stream of a new job. */
export interface Making<View extends api.View = api.View> extends Showing<View>, Repeatable {
  /** Cancels the job if the connection breaks or the loop is left. */
  readonly on_disconnect?: api.OnDisconnect | undefined;
}

/** Options of the stream of an edit. */
export interface Editing<View extends api.View = api.View> extends Making<View> {
  /**
   * The iteration that the edit starts from, if available: its knots need not be sent again (`describe: "none"`), and
   * the changes of an ephemeral edit (`changed: true`) are applied to it.
   */
  readonly from?: Iteration | undefined;
}

/** Options for a single iteration. */
export interface Looking<View extends api.View = api.View>
  extends Omit<Plain<api.Query<"getIteration">>, "view">, Cancellable {
  readonly view?: View | undefined;
}

/** Options for the shape of an iteration. */
export interface Measuring extends Plain<api.Query<"getShape">>, Cancellable {}

/** The query of a stream; numbers are sent as base64 unless the job or other options exclude it. */
export function shown(options: Editing, job: api.StreamDefaults | null | undefined) {
  const { signal: _, idempotencyKey: __, after: ___, from: ____, ...query } = options as Editing & Watching;
  const decimal = query.encoding ?? query.digits ?? query.changed ?? (query.view === "errors" || null);
  return decimal === null && job == null ? { ...query, encoding: "base64" as const } : query;
}

/** A unique key. Pages without TLS have no `randomUUID`. */
export function key(): string {
  return Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, "0")).join("");
}

/** The headers of a request that creates something. */
export function creating(options: Creation, longest: number): Record<string, string> {
  const headers: Record<string, string> = { "Idempotency-Key": options.idempotencyKey ?? key() };
  const wait = Math.floor(Math.min(options.wait ?? 0, longest));
  if (wait >= 1) headers["Prefer"] = `wait=${wait}`;
  return headers;
}
