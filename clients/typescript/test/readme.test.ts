/** The examples of the documentation compile and run. */

import assert from "node:assert/strict";
import { mkdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, describe, test } from "node:test";
import { fileURLToPath, pathToFileURL } from "node:url";

import ts from "typescript";

import { ROOT, Server } from "./server.js";

const PACKAGE = fileURLToPath(new URL("..", import.meta.url));
// Inside the package, so that `piad` resolves to it.
const DIRECTORY = join(PACKAGE, "build/readme");

interface Example {
  readonly section: string;
  readonly code: string;
  readonly file: string;
}

const guide = readFileSync(join(ROOT, "docs/reference/clients.md"), "utf8");
const examples = [
  ...examplesIn(readFileSync(join(PACKAGE, "README.md"), "utf8"), "readme"),
  ...examplesIn(guide.slice(guide.indexOf("## Written clients"), guide.indexOf("## Python without a package")), "clients"),
];

describe("the documentation", () => {
  const server = new Server(":memory:");
  before(async () => {
    await server.start();
    rmSync(DIRECTORY, { recursive: true, force: true });
    mkdirSync(DIRECTORY, { recursive: true });
    for (const { file, code } of examples) writeFileSync(file, code.replaceAll("http://127.0.0.1:8080", server.url));
    assert.deepEqual(compiled(examples.map(({ file }) => file)), []);
  });
  after(() => server.kill());

  for (const { section, file } of examples) {
    test(section, { timeout: 180_000 }, async (context) => {
      const said: unknown[] = [];
      context.mock.method(console, "log", (...values: unknown[]) => said.push(...values));
      await import(pathToFileURL(file.replace(/ts$/, "js")).href);
      assert.ok(!said.includes(undefined), String(said));
    });
  }
  test("has examples", () => assert.equal(examples.length, 7));
});

function examplesIn(text: string, name: string): Example[] {
  const found: Example[] = [];
  let section = "";
  for (const [, heading, code] of text.matchAll(/^## (.*?)$|```ts\n([\s\S]*?)```/gm)) {
    section = heading ?? section;
    if (code !== undefined) found.push({ section, code, file: join(DIRECTORY, `${name}${found.length}.ts`) });
  }
  return found;
}

/** Compiles files next to their sources and returns the errors. */
function compiled(files: string[]): string[] {
  const { config } = ts.readConfigFile(join(PACKAGE, "test/tsconfig.json"), ts.sys.readFile);
  const { options } = ts.parseJsonConfigFileContent(config, ts.sys, join(PACKAGE, "test"));
  const program = ts.createProgram(files, { ...options, rootDir: DIRECTORY, outDir: DIRECTORY, noUnusedLocals: false });
  const diagnostics = [...ts.getPreEmitDiagnostics(program), ...program.emit().diagnostics];
  return diagnostics.map(({ messageText }) => ts.flattenDiagnosticMessageText(messageText, "\n"));
}
