// Measures decoding of differences in nanoseconds per number: `npm run build && node bench/deltas.mjs`. Takes five
// seconds.
//
// The curves have 10,000 and 100,000 points in space, with differences of 2, 4 and 8 bits. If the engine has no
// `Uint8Array.fromBase64` (browsers since 2025), `native` uses the base64 of Node.

if (process.argv[2] === "native") Uint8Array.fromBase64 ??= (text) => new Uint8Array(Buffer.from(text, "base64"));
const { moved } = await import("../dist/arrays.js");

const BLOCK = 256;

/** Integers of magnitude up to 2ᵇ⁻¹, in blocks of this width. */
function packed(places, dimension, width) {
  const bytes = [];
  let seed = 1;
  for (let coordinate = 0; coordinate < dimension; coordinate++) {
    for (let start = 0; start < places; start += BLOCK) {
      const count = Math.min(BLOCK, places - start);
      const block = new Uint8Array(1 + Math.ceil((count * width) / 8));
      block[0] = width;
      for (let bit = 0; bit < count * width; bit++) {
        seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
        block[1 + (bit >> 3)] |= (seed >>> 31) << (bit & 7);
      }
      bytes.push(block);
    }
  }
  return Buffer.concat(bytes).toString("base64");
}

function median(seconds) {
  return seconds.sort((a, b) => a - b)[seconds.length >> 1];
}

/** The median time of reading an event, in seconds. */
function reading(places, width, times) {
  const text = packed(places, 3, width);
  let points = { data: new Float64Array(3 * places), shape: [places, 3] };
  const seconds = Array.from({ length: times }, () => {
    const begin = performance.now();
    points = moved(points, 2 ** -10, text, 3);
    return (performance.now() - begin) / 1000;
  });
  return median(seconds);
}

// Warms up the compiler.
for (const width of [2, 4, 8]) reading(10_000, width, 100);
console.log("| points | bits | ns a number |\n|---|---|---|");
for (const places of [10_000, 100_000]) {
  for (const width of [2, 4, 8]) {
    console.log(`| ${places} | ${width} | ${((reading(places, width, 2_000_000 / places) / places / 3) * 1e9).toFixed(1)} |`);
  }
}
