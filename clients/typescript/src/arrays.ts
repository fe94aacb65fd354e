/** Arrays of numbers, from lists or base64. */

import type * as api from "./api.js";
import { ProtocolError } from "./errors.js";

/** Numbers in rows, the last index running fastest. */
export interface Tensor {
  /** 64 bits each, or 32 where they were asked for (`encoding: "base64_f32"`) and suffice. NaN is a number that is not there. */
  readonly data: Float64Array | Float32Array;
  /** `[102, 3]` for the points of a curve, `[8, 9, 3]` for those of a surface; their weights have the same without the last number. */
  readonly shape: readonly number[];
}

type Nested = readonly (number | null)[] | readonly Nested[];

/** Nested lists or base64 as numbers. Lists say themselves what their shape is. */
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

/** Little-endian numbers, as all engines that run JavaScript have them. */
function fromBase64(text: string, encoding: api.BinaryEncoding | undefined): Float64Array | Float32Array {
  const bytes = bytesOf(text);
  const Kind = encoding === "base64_f32" ? Float32Array : Float64Array;
  if (bytes.length % Kind.BYTES_PER_ELEMENT !== 0) throw new ProtocolError("the server sent a part of a number");
  return new Kind(bytes.buffer, 0, bytes.length / Kind.BYTES_PER_ELEMENT);
}

// Of newer engines, and many times as fast as the way below.
const native = (Uint8Array as { fromBase64?: (text: string) => Uint8Array<ArrayBuffer> }).fromBase64;

/** The bytes of base64, at the beginning of their buffer. */
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

/** A copy that can be written to. */
export function copy({ data, shape }: Tensor): Tensor {
  return { data: data.slice(), shape };
}
