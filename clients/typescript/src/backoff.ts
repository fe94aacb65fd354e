/** How long to wait before trying again, and how often. */

import { ApiError, ConnectionLost, type PiadError } from "./errors.js";

const FIRST = 0.25;
const LONGEST = 30;

// Servers that ask for more are not waited for: the caller is told.
const MOST_PATIENT = 60;

// Too many requests, and the statuses of overloaded servers and proxies.
const TRY_AGAIN = new Set([429, 502, 503, 504]);

// How often a server is tried that has never answered. One that has may be starting again.
const FIRST_CONTACT = 3;

/** Counts failures in a row and waits between them. */
export class Patience {
  readonly #attempts: () => number;
  #failures = 0;

  /** `attempts` says how often something is tried, at most. */
  constructor(attempts: () => number) {
    this.#attempts = attempts;
  }

  /** Something has been achieved: the failures before do not count any more. */
  reset(): void {
    this.#failures = 0;
  }

  /** Waits after a failure, `atLeast` so many seconds; throws it if trying again is of no use, or has been of none. */
  async wait(error: PiadError, signal: AbortSignal | undefined, atLeast = 0): Promise<void> {
    this.#failures += 1;
    const asked = Math.max(atLeast, error instanceof ApiError ? (error.retryAfter ?? 0) : 0);
    if (!mayTryAgain(error) || this.#failures >= this.#attempts() || asked > MOST_PATIENT) throw error;
    await sleep(delay(this.#failures, asked), signal);
  }
}

/** How often a server is tried at all. */
export function attemptsFor(hasAnswered: boolean, attempts: number): number {
  return hasAnswered ? attempts : Math.min(attempts, FIRST_CONTACT);
}

function mayTryAgain(error: PiadError): boolean {
  return error instanceof ConnectionLost || (error instanceof ApiError && TRY_AGAIN.has(error.status));
}

/**
 * The seconds to wait after this number of consecutive failures. The delay doubles each time, with up to 50% random
 * jitter so that clients do not all reconnect at once.
 */
function delay(failures: number, atLeast: number): number {
  const doubled = Math.min(Math.max(atLeast, FIRST) * 2 ** (failures - 1), LONGEST);
  return Math.max(doubled, atLeast) * (1 + Math.random() / 2);
}

/** The seconds in the Retry-After header, which may be a date. */
export function retryAfter(headers: Headers): number | null {
  const value = headers.get("Retry-After");
  if (value === null) return null;
  const seconds = /^\d+$/.test(value) ? Number(value) : (Date.parse(value) - Date.now()) / 1000;
  return Number.isNaN(seconds) ? null : Math.max(0, seconds);
}

async function sleep(seconds: number, signal: AbortSignal | undefined): Promise<void> {
  signal?.throwIfAborted();
  await new Promise<void>((resolve, reject) => {
    const aborted = () => {
      clearTimeout(timer);
      reject(signal?.reason);
    };
    const timer = setTimeout(() => {
      signal?.removeEventListener("abort", aborted);
      resolve();
    }, seconds * 1000);
    signal?.addEventListener("abort", aborted, { once: true });
  });
}
