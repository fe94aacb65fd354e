/** What went wrong, as a sentence. */

import { ApiError, ConnectionLost } from "piad";

/** In the words of the server where it has said it. */
export function sentence(error: unknown): string {
  if (error instanceof ApiError) return error.detail;
  if (error instanceof ConnectionLost) return "The server cannot be reached.";
  return error instanceof Error ? error.message : String(error);
}

/** A sentence of the server, which counts points from 0, with points that are counted from 1, and settings named as on the page. */
export function fromOne(words: string): string {
  return words.replace(/"robust": true\b/, "“Leave out outliers”").replace(/\b(points?|rows?|columns?) (\d+)/gi, (_, what: string, number: string) => `${what} ${Number(number) + 1}`);
}
