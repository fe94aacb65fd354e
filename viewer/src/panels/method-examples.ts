/** Jobs that show what the methods are for. */

import type { api } from "piad";

export interface MethodExample {
  readonly name: string;
  /** What there is to see. */
  readonly about: string;
  readonly request: () => api.JobRequest;
}

const round = (value: number): number => Number(value.toFixed(5));
const numbers = (count: number): number[] => Array.from({ length: count }, (_, i) => i);

/** Numbers that look like chance and are the same each time. */
function chance(seed: number): () => number {
  let state = seed;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32 - 0.5;
  };
}

function helix(): number[][] {
  return numbers(48).map((i) => {
    const turn = (i / 47) * 6 * Math.PI;
    return [Math.cos(turn), Math.sin(turn), turn / 6].map(round);
  });
}

function circle(): number[][] {
  return numbers(12).map((i) => [Math.cos((i / 6) * Math.PI), Math.sin((i / 6) * Math.PI)].map(round));
}

/** The surface that programs for matrices show first. */
function peaks(): number[][][] {
  const side = numbers(25).map((i) => (i - 12) / 4);
  const height = (x: number, y: number) =>
    3 * (1 - x) ** 2 * Math.exp(-x * x - (y + 1) ** 2) - 10 * (x / 5 - x ** 3 - y ** 5) * Math.exp(-x * x - y * y) - Math.exp(-((x + 1) ** 2) - y * y) / 3;
  return side.map((x) => side.map((y) => [x, y, height(x, y) / 3].map(round)));
}

/** Four hundred points of a scanner that trembles. */
function scan(): number[][] {
  const tremble = chance(7);
  return numbers(400).map((i) => {
    const x = i / 40;
    return [x + 0.01 * tremble(), Math.sin(x) + 0.4 * Math.sin(2.7 * x) + 0.12 * tremble()].map(round);
  });
}

/** A scanned saddle, on a grid with noise. */
function saddle(): number[][][] {
  const tremble = chance(11);
  const side = numbers(41).map((i) => (i - 20) / 20);
  return side.map((x) => side.map((y) => [x, y, x * x - y * y + 0.05 * tremble()].map(round)));
}

export const METHOD_EXAMPLES: readonly MethodExample[] = [
  { name: "Helix", about: "48 points in space, with Chebyshev's momentum", request: () => ({ name: "Helix", curve: { points: helix() }, method: { kind: "chebyshev" } }) },
  { name: "Circle", about: "12 points, closed without a seam", request: () => ({ name: "Circle", curve: { points: circle(), closed: true } }) },
  { name: "Peaks", about: "A grid of 25 × 25, the best relaxation", request: () => ({ name: "Peaks", surface: { points: peaks() }, method: { kind: "weighted", omega: "auto" } }) },
  { name: "Noisy scan", about: "400 points, 18 control points, least squares", request: () => ({ name: "Noisy scan", curve: { points: scan() }, method: { kind: "least_squares", control_points: 18 }, stop: { max_iterations: 300 } }) },
  { name: "As few as needed", about: "The same, within 0.12 of each point", request: () => ({ name: "As few as needed", curve: { points: scan() }, method: { kind: "least_squares", control_points: "auto" }, stop: { tolerance: 0.12 } }) },
  { name: "Noisy saddle", about: "1681 points, a net of 7 × 7", request: () => ({ name: "Noisy saddle", surface: { points: saddle() }, method: { kind: "least_squares", control_points: 7 }, stop: { max_iterations: 300 } }) },
];
