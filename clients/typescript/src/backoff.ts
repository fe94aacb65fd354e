/** Delays and number of retries. */

import { ApiError, ConnectionLost, type PiadError } from "./errors.js";

const FIRST = 0.25;
const LONGEST = 30;

// If the server requests a longer delay, the error is thrown instead.
const LONGEST_DELAY = 60;

// Too many requests, and the statuses of overloaded servers and proxies.
const TRY_AGAIN = new Set([429, 502, 503, 504]);

// The number of attempts for a server that has never responded. One that has responded may be restarting.
const FIRST_CONTACT = 3;

/** Counts consecutive failures and waits between attempts. */
export class Retries {
  readonly #attempts: () => number;
  #failures = 0;

  /** `attempts` is the maximum number of attempts. */
  constructor(attempts: () => number) {
    this.#attempts = attempts;
  }

  /** Resets the count of failures after progress. */
  reset(): void {
    this.#failures = 0;
  }

  /** Waits after a failure, at least `atLeast` seconds; throws it if a retry is useless or no attempts are left. */
  async wait(error: PiadError, signal: AbortSignal | undefined, atLeast = 0): Promise<void> {
    this.#failures += 1;
    const asked = Math.max(atLeast, error instanceof ApiError ? (error.retryAfter ?? 0) : 0);
    if (!mayTryAgain(error) || this.#failures >= this.#attempts() || asked > LONGEST_DELAY) throw error;
    await sleep(delay(this.#failures, asked), signal);
  }
}

/** The maximum number of attempts for a server. */
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

/** Parses the Retry-After header, which may be a date, as seconds. */
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
