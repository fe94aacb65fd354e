/** Bodies of requests as JSON. */

/** A body as JSON; a `RangeError` names the first number in it that JSON does not have. */
export function encoded(body: unknown): string {
  const text = JSON.stringify(body);
  // JSON has null where a number is not finite, and servers read null as "not given".
  const found = text.includes("null") ? notFinite(body, "") : undefined;
  if (found !== undefined) throw new RangeError(`${found}: numbers must be finite`);
  return text;
}

/** A number that is NaN or infinite, and where it is: `curve.points[3][1] is NaN`. */
function notFinite(value: unknown, path: string): string | undefined {
  if (typeof value === "number") return Number.isFinite(value) ? undefined : `${path} is ${value}`;
  if (typeof value !== "object" || value === null) return undefined;
  const place = Array.isArray(value)
    ? (key: string) => `${path}[${key}]`
    : (key: string) => (path === "" ? key : `${path}.${key}`);
  for (const [key, part] of Object.entries(value)) {
    const found = notFinite(part, place(key));
    if (found !== undefined) return found;
  }
  return undefined;
}
