/** Triangles of small polygons. */

type Place = readonly [x: number, y: number];

export type PlaceOf = (vertex: number) => Place;

/**
 * Divides a polygon into triangles, counter-clockwise as it is: three of its vertices each. Holes are clockwise. Ears are
 * cut off one by one, which takes the square of the number of vertices.
 */
export function trianglesOf(around: readonly number[], holes: readonly (readonly number[])[], placeOf: PlaceOf): number[] {
  const ring = holes.reduce((outer, hole) => joined(outer, hole, placeOf), around);
  const left = ring.map((vertex) => ({ vertex, place: placeOf(vertex) }));
  const triangles: number[] = [];
  while (left.length >= 3) {
    const count = left.length;
    const places = left.map(({ place }) => place);
    const corner = (i: number) => [places[(i + count - 1) % count]!, places[i]!, places[(i + 1) % count]!] as const;
    // Where rounding leaves no ear, the flattest corner takes its place.
    let best = places.findIndex((_, i) => isEar(corner(i), places));
    if (best < 0) best = places.reduce((flat, _, i) => (Math.abs(areaOf(...corner(i))) < Math.abs(areaOf(...corner(flat))) ? i : flat), 0);
    if (areaOf(...corner(best)) > 0) triangles.push(left[(best + count - 1) % count]!.vertex, left[best]!.vertex, left[(best + 1) % count]!.vertex);
    left.splice(best, 1);
  }
  return triangles;
}

/** True if a vertex is inside a polygon. */
export function contains(around: readonly number[], vertex: number, placeOf: PlaceOf): boolean {
  const [x, y] = placeOf(vertex);
  let isInside = false;
  around.forEach((from, k) => {
    const [[ax, ay], [bx, by]] = [placeOf(from), placeOf(around[(k + 1) % around.length]!)];
    if (ay > y !== by > y && x < ax + ((y - ay) / (by - ay)) * (bx - ax)) isInside = !isInside;
  });
  return isInside;
}

/** One ring of a polygon and a hole, with a way there and back between the vertices that are nearest to each other. */
function joined(outer: readonly number[], hole: readonly number[], placeOf: PlaceOf): number[] {
  let nearest = Infinity;
  let [from, to] = [0, 0];
  outer.forEach((a, i) =>
    hole.forEach((b, j) => {
      const [[ax, ay], [bx, by]] = [placeOf(a), placeOf(b)];
      const apart = Math.hypot(ax - bx, ay - by);
      if (apart < nearest) [nearest, from, to] = [apart, i, j];
    }),
  );
  return [...outer.slice(0, from + 1), ...hole.slice(to), ...hole.slice(0, to + 1), ...outer.slice(from)];
}

/** True if a corner turns to the left and no other place is within its triangle. */
function isEar(corner: readonly [Place, Place, Place], places: readonly Place[]): boolean {
  if (!(areaOf(...corner) > 0)) return false;
  const [a, b, c] = corner;
  const isCorner = ([x, y]: Place) => corner.some(([cx, cy]) => cx === x && cy === y);
  return !places.some((place) => areaOf(a, b, place) >= 0 && areaOf(b, c, place) >= 0 && areaOf(c, a, place) >= 0 && !isCorner(place));
}

/** Twice the area of a triangle; positive if it is counter-clockwise. */
function areaOf([ax, ay]: Place, [bx, by]: Place, [cx, cy]: Place): number {
  return (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
}
