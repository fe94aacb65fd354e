/** From the text of a file to a request. Jobs are what the API speaks; files of points are read by the server. */

import type { Problem, api } from "piad";

import { authorized } from "../http.js";
import type { InputFile } from "./drop.js";
import { type Fields, type Json, at, isFields } from "./pointer.js";

/** How a file is read, as parameters of the API. */
export interface Reading {
  readonly part?: string;
  readonly columns?: string;
  readonly "curve.order"?: "given";
  readonly "surface.sections"?: "true" | "false";
}

/** The parts of a file with several curves. */
export interface Parts {
  readonly count: number;
  readonly names: readonly string[];
}

/** What a file says. */
export interface ParsedInput {
  readonly request: Fields;
  /** What was found out about the file, in words. */
  readonly notices: readonly string[];
  /** Null of a file with one part. */
  readonly parts: Parts | null;
}

/** Where a file is wrong. */
export interface Fault {
  readonly detail: string;
  /** From 1; null where it is no line that is wrong. */
  readonly line: number | null;
  readonly column: number | null;
}

/** A file that could not be read, and why. */
export class InputError extends Error {
  readonly faults: readonly Fault[];
  readonly text: string;

  constructor(text: string, faults: readonly Fault[]) {
    super(faults[0]?.detail ?? "The file could not be read.");
    this.text = text;
    this.faults = faults;
  }
}

/** Reads a file, or its text where there is no file. `name` is that of the file without its ending, for the job. */
export async function parseInput({ text, bytes }: InputFile, name: string | null, reading: Reading, signal: AbortSignal): Promise<ParsedInput> {
  const value = /^\s*[[{]/.test(text) ? parsed(text) : null;
  const { request, notices, parts } = isFields(value) && !("type" in value) ? job(value, text) : await byServer(text, bytes, reading, signal);
  // What a file calls itself goes before how the file is called.
  const title = name === null || (parts === null && reading.part === undefined) ? name : `${name} ${reading.part ?? "1"}`;
  return { request: title === null || "name" in request ? request : { name: title, ...request }, notices, parts };
}

function parsed(text: string): Json {
  try {
    return JSON.parse(text) as Json;
  } catch (error) {
    throw new InputError(text, [{ detail: `This is not JSON: ${message(error)}.`, ...placeOf(text, message(error)) }]);
  }
}

/** A whole job, or an object with points. */
function job(value: Fields, text: string): ParsedInput {
  const request = "points" in value && !("curve" in value) && !("surface" in value) ? geometry(value["points"]!) : value;
  if ("curve" in request || "surface" in request) return { request, notices: [], parts: null };
  throw new InputError(text, [{ detail: "A job has a curve or a surface, and there is neither.", line: null, column: null }]);
}

/** Rows of rows are a surface. */
function geometry(points: Json): Fields {
  const first = Array.isArray(points) ? (points[0] as Json) : null;
  const grid = Array.isArray(first) && first.some((part) => Array.isArray(part));
  return grid ? { surface: { points } } : { curve: { points } };
}

/** Where a parser of JSON stopped, which engines say in their own words. */
function placeOf(text: string, words: string): { line: number | null; column: number | null } {
  const lined = /line (\d+) column (\d+)/.exec(words);
  if (lined !== null) return { line: Number(lined[1]), column: Number(lined[2]) };
  const position = /position (\d+)/.exec(words)?.[1];
  const end = /end of (JSON|data)|Unexpected end/i.test(words) ? text.length : null;
  const found = position === undefined ? end : Number(position);
  if (found === null) return { line: null, column: null };
  const before = text.slice(0, found).split("\n");
  return { line: before.length, column: (before.at(-1)?.length ?? 0) + 1 };
}

async function byServer(text: string, bytes: Blob | undefined, reading: Reading, signal: AbortSignal): Promise<ParsedInput> {
  const headers = { "Content-Type": bytes === undefined ? "text/plain; charset=utf-8" : "application/octet-stream", Accept: "application/json, application/problem+json" };
  const sent = (await bytes?.arrayBuffer()) ?? text;
  const post = async (reading: Reading): Promise<{ response: Response; body: Json }> => {
    const query = new URLSearchParams(reading as Record<string, string>);
    const response = await authorized(new URL(`v1/points${query.size > 0 ? `?${query}` : ""}`, document.baseURI), { method: "POST", headers, body: sent, signal });
    return { response, body: (await response.json().catch(() => null)) as Json };
  };
  let { response, body } = await post(reading);
  // Of several parts the first one is shown, and the others can be chosen.
  const parts = reading.part === undefined ? severalOf(body) : null;
  if (parts !== null) ({ response, body } = await post({ ...reading, part: "1" }));
  if (response.ok && isFields(body)) {
    const { notices, ...request } = body;
    return { request, notices: Array.isArray(notices) ? notices.map(sentence) : [], parts };
  }
  if (response.status === 404 || response.status === 405) {
    throw new InputError(text, [{ detail: "This server reads points as JSON only.", line: null, column: null }]);
  }
  // Points that are read, and of which no curve can be made.
  if (response.status === 422 && isFields(body) && body["errors"] === undefined) {
    const scan = scanOf((await post({ ...reading, "curve.order": "given" })).body);
    if (scan !== null) return scan;
  }
  throw new InputError(text, faultsOf(body as Partial<Problem> | null, response.status));
}

/** The parts of a file of which none was chosen; null if there is one. */
function severalOf(body: Json): Parts | null {
  const errors = at(body, "/errors");
  const error = Array.isArray(errors) ? errors.find((one: Json) => at(one, "/parameter") === "part") : undefined;
  const [, count, names = ""] = /has (\d+) parts[^;]*(?:; there are (.*))?$/s.exec(String(at(error, "/detail") ?? "")) ?? [];
  return count === undefined ? null : { count: Number(count), names: [...names.matchAll(/"([^"]*)"/g)].map(([, name = ""]) => name) };
}

/** Points in space without an order along a curve, as those of a surface near them; null if they are something else. */
function scanOf(body: Json): ParsedInput | null {
  const points = at(body, "/curve/points");
  if (!isFields(body) || !Array.isArray(points) || !points.every((point) => Array.isArray(point) && point.length === 3)) return null;
  const { curve: _, notices: __, ...rest } = body;
  return { request: { ...rest, surface: { scattered: points } }, notices: ["The points have no order along a curve: they are taken as scattered points of a surface."], parts: null };
}

/** What a problem object says about lines. */
function faultsOf(problem: Partial<Problem> | null, status: number): Fault[] {
  const errors = (problem?.errors ?? []) as readonly (api.FieldError & { line?: number; column?: number })[];
  const faults = errors.map(({ detail, line, column }) => {
    const said = /\blines? (\d+)(?:,? column (\d+))?/.exec(detail);
    return { detail, line: line ?? numberOf(said?.[1]), column: column ?? numberOf(said?.[2]) };
  });
  if (faults.length > 0) return faults;
  const detail = problem?.detail ?? `The server answered ${status}.`;
  return [{ detail, line: numberOf(/\bline (\d+)/.exec(detail)?.[1]), column: null }];
}

function numberOf(text: string | undefined): number | null {
  return text === undefined ? null : Number(text);
}

function sentence(notice: unknown): string {
  if (typeof notice === "string") return notice;
  return isFields(notice) ? String(notice["detail"] ?? JSON.stringify(notice)) : String(notice);
}

function message(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}
