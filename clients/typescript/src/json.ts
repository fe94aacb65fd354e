/** Bodies of requests as JSON. */

/** Encodes a body as JSON; a `RangeError` names the first number that is not finite. */
export function encoded(body: unknown): string {
  const text = JSON.stringify(body);
  // `JSON.stringify` writes null for a number that is not finite, and servers read null as absent.
  const found = text.includes("null") ? notFinite(body, "") : undefined;
  if (found !== undefined) throw new RangeError(`${found}: numbers must be finite`);
  return text;
}

/** Describes a number that is NaN or infinite with its location: `curve.points[3][1] is NaN`. */
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
