/** What went wrong, as a sentence. */

import { ApiError, ConnectionLost } from "piad";

/** In the words of the server where it has said it. */
export function sentence(error: unknown): string {
  if (error instanceof ApiError) return error.detail;
  if (error instanceof ConnectionLost) return "The server cannot be reached.";
  return error instanceof Error ? error.message : String(error);
}
