/** Numbers as they are read. */

/** Two or three digits that matter, with a real minus sign and a power of ten where it is shorter. */
export function short(value: number | null | undefined, digits = 3): string {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (!Number.isFinite(value)) return "∞";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-3) {
    const [lead = "", power = "0"] = value.toExponential(digits - 1).split("e");
    return `${minus(lead.replace(/\.?0+$/, ""))}·10${superscript(Number(power))}`;
  }
  return minus(String(Number(value.toPrecision(digits + (size >= 1 ? 1 : 0)))));
}

/** The name of a coordinate of points with this number of coordinates. */
export function axisName(axis: number, dimension: number): string {
  return (dimension > 3 ? undefined : "xyz"[axis]) ?? `x${axis + 1}`;
}

/** How long ago a time is: "12 s ago", "3 min ago". */
export function ago(time: string, now = Date.now()): string {
  const seconds = Math.max(0, Math.round((now - Date.parse(time)) / 1000));
  const steps = [[60, "s"], [60, "min"], [24, "h"]] as const;
  let value = seconds;
  for (const [most, unit] of steps) {
    if (value < most) return `${value} ${unit} ago`;
    value = Math.floor(value / most);
  }
  return `${value} ${value === 1 ? "day" : "days"} ago`;
}

/** The name of a data point, counted from 1: "7", or "row 2, column 3" of a surface. */
export function placeName(place: number | readonly number[]): string {
  return typeof place === "number" ? String(place + 1) : `row ${place[0]! + 1}, column ${place[1]! + 1}`;
}

/** A count, with thin spaces between thousands. */
export function count(value: number): string {
  return String(value).replace(/\B(?=(\d{3})+$)/g, "\u202f");
}

export function superscript(power: number): string {
  return [...String(power)].map((sign) => (sign === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(sign)])).join("");
}

function minus(text: string): string {
  return text.replace("-", "−");
}
