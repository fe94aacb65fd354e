/** Assertions, for Node and browsers. */

/** Fails unless the condition holds. */
export function ok(condition: unknown, message = "it does not hold"): asserts condition {
  if (!condition) throw new Error(message);
}

/** Fails unless both are equal, to the last bit of each number. */
export function equal(actual: unknown, expected: unknown, message = "they differ"): void {
  if (!same(actual, expected)) throw new Error(`${message}: ${show(actual)} instead of ${show(expected)}`);
}

/** Returns the error of this class with which a promise rejects. */
export async function refused<T extends Error>(promise: Promise<unknown>, kind: abstract new (...args: never[]) => T): Promise<T> {
  const error = await promise.then(
    () => new Error("nothing went wrong"),
    (error: unknown) => error,
  );
  if (error instanceof kind) return error;
  throw error;
}

/** All items of a stream. */
export async function all<T>(items: AsyncIterable<T>): Promise<T[]> {
  const list: T[] = [];
  for await (const item of items) list.push(item);
  return list;
}

/** Returns the first item of a stream and closes it. */
export async function first<T>(items: AsyncIterable<T>): Promise<T> {
  for await (const item of items) return item;
  throw new Error("there is none");
}

export function sleep(seconds: number): Promise<void> {
  return new Promise((resolve) => setTimeout(resolve, seconds * 1000));
}

function same(a: unknown, b: unknown): boolean {
  if (Object.is(a, b)) return true;
  if (typeof a !== "object" || typeof b !== "object" || a === null || b === null) return false;
  if (a.constructor !== b.constructor) return false;
  const [mine, theirs] = [Object.entries(a), new Map(Object.entries(b))];
  return mine.length === theirs.size && mine.every(([key, value]) => theirs.has(key) && same(value, theirs.get(key)));
}

function show(value: unknown): string {
  return (JSON.stringify(value) ?? String(value)).slice(0, 300);
}
