// Makes dist/ from src/, the same bytes from the same sources. With --check it only compares.

import { mkdir, readFile, readdir, rm, writeFile } from "node:fs/promises";
import { gzipSync } from "node:zlib";

import { build } from "esbuild";

import { lean } from "./lean.mjs";

// What the page may weigh in all, in bytes as servers send them.
const LIMIT = 200_000;

const here = (path) => new URL(path, import.meta.url);
const { outputFiles, metafile } = await build({
  absWorkingDir: here(".").pathname,
  entryPoints: { first: "src/first.ts", app: "src/main.ts" },
  outdir: "dist",
  bundle: true,
  // What several scripts use is in scripts of their own, so that they share what they know.
  splitting: true,
  chunkNames: "[name]-[hash]",
  format: "esm",
  target: "es2022",
  minify: true,
  legalComments: "none",
  charset: "utf8",
  plugins: [lean],
  tsconfig: "tsconfig.json",
  metafile: true,
  write: false,
});

const last = (path) => path.split("/").at(-1);
const scripts = Object.entries(metafile.outputs);

/** The scripts of their own that need a script from the beginning. */
const users = (path) => scripts.filter(([, { entryPoint, imports }]) => entryPoint && imports.some((one) => one.path === path && one.kind === "import-statement")).map(([user]) => nameOf(user));

/** What a script is called: what is shared by those who share it. */
function nameOf(path) {
  const name = last(path).replace(/-[A-Z0-9]{8}\./, ".");
  return name === "chunk.js" ? `${users(path).map((user) => user.replace(".js", "")).sort().join("-")}.js` : name;
}

const names = new Map(scripts.map(([path]) => [last(path), nameOf(path)]));
const plain = (text) => [...names].reduce((text, [hashed, name]) => text.replaceAll(hashed, name), text);
const files = new Map(outputFiles.map(({ path, text }) => [names.get(last(path)), Buffer.from(plain(text))]));
if (files.size !== outputFiles.length) throw new Error(`two scripts have one name: ${[...names.values()].join(", ")}`);

// The browser asks for these before it has read those that need them.
const early = scripts.map(([path]) => path).filter((path) => users(path).includes("app.js"));
const preload = early.map((path) => `<link rel="modulepreload" href="viewer/${nameOf(path)}">`).join("\n");
files.set("index.html", Buffer.from((await readFile(here("src/index.html"), "utf8")).replace("<!-- preload -->", preload)));

const weight = [...files.values()].reduce((sum, bytes) => sum + gzipSync(bytes, { level: 9 }).length, 0);
if (weight > LIMIT) {
  console.error(`the page weighs ${weight} bytes in gzip, which is more than ${LIMIT}`);
  process.exit(1);
}

if (process.argv.includes("--check")) {
  const left = (await readdir(here("dist/"))).filter((name) => !files.has(name));
  if (left.length > 0) {
    console.error(`viewer/dist/${left[0]} is not made from viewer/src any more: make viewer`);
    process.exit(1);
  }
  for (const [name, bytes] of files) {
    const old = await readFile(here(`dist/${name}`)).catch(() => null);
    if (old === null || !old.equals(bytes)) {
      console.error(`viewer/dist/${name} is not made from viewer/src as it is: make viewer`);
      process.exit(1);
    }
  }
} else {
  await rm(here("dist/"), { recursive: true, force: true });
  await mkdir(here("dist/"));
  for (const [name, bytes] of files) await writeFile(here(`dist/${name}`), bytes);
  console.log(`viewer/dist: ${weight} bytes in gzip`);
}
