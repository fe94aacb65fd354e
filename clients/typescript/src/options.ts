/** What can be asked for beside the job itself. */

import type * as api from "./api.js";
import type { Iteration } from "./iteration.js";

/** Of every request. */
export interface Cancellable {
  /** Ends the request, waiting for another attempt included; its reason is thrown. */
  readonly signal?: AbortSignal | undefined;
}

/** Of requests that make something. */
export interface Repeatable extends Cancellable {
  /**
   * By which the server recognises the request when it is sent again. A random one is the default; programs
   * that may themselves start again give their own.
   */
  readonly idempotencyKey?: string | undefined;
}

/** Of requests for a new job. */
export interface Creation extends Repeatable {
  /** How many seconds the server may wait for the end of the job before it answers. */
  readonly wait?: number | undefined;
}

/** As query parameters, but for the number of samples, which may be a number. */
type Plain<Query> = { readonly [Name in keyof Query]?: (Name extends "samples" ? api.Samples : Query[Name]) | undefined };

/** How a stream shows a job: see docs/STREAMS.md of the server. What is not given is as the job says. */
export interface Showing<View extends api.View = api.View>
  extends Omit<Plain<api.Query<"watchJob">>, "on_disconnect" | "view">, Cancellable {
  readonly view?: View | undefined;
}

/** Of the stream of a job that is there. */
export interface Watching<View extends api.View = api.View> extends Showing<View> {
  /** The number of the iteration after which it begins. */
  readonly after?: number | undefined;
}

/** Of the stream of a new job. */
export interface Making<View extends api.View = api.View> extends Showing<View>, Repeatable {
  /** Whether the job is cancelled when the connection breaks or the loop is left. */
  readonly on_disconnect?: api.OnDisconnect | undefined;
}

/** Of the stream of an edit. */
export interface Editing<View extends api.View = api.View> extends Making<View> {
  /**
   * The iteration that the edit starts from, if it is at hand: what it knows of knots need not be described again
   * (`describe: "none"`), and the changes of an ephemeral edit (`changed: true`) are applied to it.
   */
  readonly from?: Iteration | undefined;
}

/** How one iteration is shown. */
export interface Looking<View extends api.View = api.View>
  extends Omit<Plain<api.Query<"getIteration">>, "view">, Cancellable {
  readonly view?: View | undefined;
}

/** Which iteration's shape is measured, and at which samples. */
export interface Measuring extends Plain<api.Query<"getShape">>, Cancellable {}

/** What a stream asks for; numbers travel as base64 unless the job says how, or other choices forbid it. */
export function shown(options: Editing, job: api.StreamDefaults | null | undefined) {
  const { signal: _, idempotencyKey: __, after: ___, from: ____, ...query } = options as Editing & Watching;
  const decimal = query.encoding ?? query.digits ?? query.changed ?? (query.view === "errors" || null);
  return decimal === null && job == null ? { ...query, encoding: "base64" as const } : query;
}

/** A key that nobody else has. Pages without TLS have no `randomUUID`. */
export function key(): string {
  return Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, "0")).join("");
}

/** The headers of a request that makes something. */
export function creating(options: Creation, longest: number): Record<string, string> {
  const headers: Record<string, string> = { "Idempotency-Key": options.idempotencyKey ?? key() };
  const wait = Math.floor(Math.min(options.wait ?? 0, longest));
  if (wait >= 1) headers["Prefer"] = `wait=${wait}`;
  return headers;
}
