/** Arrays of numbers, from lists or base64. */

import type * as api from "./api.js";
import { ProtocolError } from "./errors.js";

/** Numbers in row-major order. */
export interface Tensor {
  /**
   * 64-bit numbers, or 32-bit where requested (`encoding: "base64_f32"`) and sufficient. NaN marks a missing number.
   */
  readonly data: Float64Array | Float32Array;
  /** `[102, 3]` for the points of a curve, `[8, 9, 3]` for those of a surface; weights lack the last axis. */
  readonly shape: readonly number[];
}

type Nested = readonly (number | null)[] | readonly Nested[];

/** Decodes nested lists, which determine the shape, or base64. */
export function tensor(value: Nested | string, shape: readonly number[], encoding: api.BinaryEncoding | undefined): Tensor {
  if (typeof value !== "string") return fromLists(value);
  const data = fromBase64(value, encoding);
  const count = shape.reduce((product, length) => product * length, 1);
  if (data.length !== count) throw new ProtocolError(`the server sent ${data.length} numbers instead of ${count}`);
  return { data, shape };
}

/** A list or base64 as 64-bit numbers. */
export function line(value: readonly number[] | string, encoding: api.BinaryEncoding | undefined = "base64"): Float64Array {
  return Float64Array.from(typeof value === "string" ? fromBase64(value, encoding) : value);
}

function fromLists(value: Nested): Tensor {
  const shape: number[] = [];
  for (let list: Nested | number | null | undefined = value; Array.isArray(list); list = list[0]) shape.push(list.length);
  const data = new Float64Array(shape.reduce((product, length) => product * length, 1));
  let at = 0;
  const fill = (list: Nested) => {
    for (const part of list) {
      if (typeof part === "object" && part !== null) fill(part);
      else data[at++] = part ?? NaN;
    }
  };
  fill(value);
  return { data, shape };
}

/** Assumes a little-endian machine, as all JavaScript engines run on. */
function fromBase64(text: string, encoding: api.BinaryEncoding | undefined): Float64Array | Float32Array {
  const bytes = bytesOf(text);
  const Kind = encoding === "base64_f32" ? Float32Array : Float64Array;
  if (bytes.length % Kind.BYTES_PER_ELEMENT !== 0) throw new ProtocolError("the server sent a part of a number");
  return new Kind(bytes.buffer, 0, bytes.length / Kind.BYTES_PER_ELEMENT);
}

// Newer engines have this, which is many times faster than the code below.
const native = (Uint8Array as { fromBase64?: (text: string) => Uint8Array<ArrayBuffer> }).fromBase64;

/** Decodes base64 to bytes, at the start of their buffer. */
function bytesOf(text: string): Uint8Array<ArrayBuffer> {
  try {
    if (native !== undefined) return native.call(Uint8Array, text);
    const letters = atob(text);
    const bytes = new Uint8Array(letters.length);
    for (let i = 0; i < bytes.length; i++) bytes[i] = letters.charCodeAt(i);
    return bytes;
  } catch (cause) {
    throw new ProtocolError("the server sent something else than base64", { cause });
  }
}

// The number of consecutive integers with the same width.
const BLOCK = 256;

/**
 * Adds `step` times the packed integers to an array; `dimension` is the length of its last axis, 1 for weights.
 */
export function moved({ data, shape }: Tensor, step: number, text: string, dimension: number): Tensor {
  const bytes = bytesOf(text);
  // A number may start in the last byte.
  const padded = new Uint8Array(bytes.length + 8);
  padded.set(bytes);
  const view = new DataView(padded.buffer);
  const to = new Float64Array(data.length);
  // Six times faster than the constructor.
  to.set(data);
  let at = 0;
  for (let coordinate = 0; coordinate < dimension; coordinate++) {
    for (let start = coordinate; start < to.length; start += BLOCK * dimension) {
      const end = Math.min(start + BLOCK * dimension, to.length);
      const count = Math.ceil((end - start) / dimension);
      const width = padded[at] ?? 0;
      const next = at + 1 + Math.ceil((count * width) / 8);
      if (width > 32 || at >= bytes.length || next > bytes.length) {
        throw new ProtocolError("the server sent packed numbers that are cut off or too wide");
      }
      if (width > 0) move(to, start, end, dimension, step, view, at + 1, width);
      at = next;
    }
  }
  if (at !== bytes.length) throw new ProtocolError("the server sent more packed numbers than there are");
  return { data: to, shape };
}

// A number of up to this many bits lies within four bytes, at any bit offset.
const NARROW = 25;

/** Adds the differences of a block. */
function move(to: Float64Array, start: number, end: number, dimension: number, step: number, view: DataView, at: number, width: number) {
  if (width > NARROW) return moveWide(to, start, end, dimension, step, view, at, width);
  const mask = (1 << width) - 1;
  let bit = 0;
  for (let i = start; i < end; i += dimension) {
    const bits = (view.getInt32(at + (bit >>> 3), true) >>> (bit & 7)) & mask;
    to[i]! += step * ((bits >>> 1) ^ -(bits & 1));
    bit += width;
  }
}

function moveWide(to: Float64Array, start: number, end: number, dimension: number, step: number, view: DataView, at: number, width: number) {
  const mask = width === 32 ? -1 : (1 << width) - 1;
  let bit = 0;
  for (let i = start; i < end; i += dimension) {
    const byte = at + (bit >>> 3);
    const shift = bit & 7;
    let bits = view.getUint32(byte, true) >>> shift;
    if (shift + width > 32) bits |= view.getUint8(byte + 4) << (32 - shift);
    bits &= mask;
    to[i]! += step * ((bits >>> 1) ^ -(bits & 1));
    bit += width;
  }
}

/** A writable copy. */
export function copy({ data, shape }: Tensor): Tensor {
  return { data: data.slice(), shape };
}
