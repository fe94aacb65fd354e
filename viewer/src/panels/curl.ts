/** Requests as lines of a shell. */

// Linux takes no argument longer than 131072 bytes.
const LONGEST = 100_000;

/** A word of a POSIX shell. */
export function quoted(word: string): string {
  return /^[\w@%+=:,./-]+$/.test(word) ? word : `'${word.replace(/'/g, "'\\''")}'`;
}

/** The request for a job as a command; null for `body` when it is too long to be written there. */
export function curl(url: string, body: string): { command: string; file: boolean } {
  const file = new TextEncoder().encode(body).length > LONGEST;
  const data = file ? "--data-binary @job.json" : `--data-raw ${quoted(body)}`;
  return { command: `curl ${quoted(url)} -H 'Content-Type: application/json' ${data}`, file };
}
