/** The published package. */

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, readdirSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";

import * as piad from "piad";
import ts from "typescript";

import { ROOT } from "./server.js";

const PACKAGE = fileURLToPath(new URL("..", import.meta.url));
const about = JSON.parse(readFileSync(join(PACKAGE, "package.json"), "utf8"));

test("the package has what is needed and nothing else", () => {
  const answer = execFileSync("npm", ["pack", "--dry-run", "--json", "--ignore-scripts"], { cwd: PACKAGE, encoding: "utf8" });
  const [packed] = JSON.parse(answer) as { name: string; size: number; files: { path: string }[] }[];
  const modules = readdirSync(join(PACKAGE, "src")).map((file) => file.replace(/\.ts$/, ""));
  const expected = [
    ...modules.flatMap((module) => [`dist/${module}.js`, `dist/${module}.d.ts`]),
    ...["LICENSE-APACHE", "LICENSE-MIT", "README.md", "package.json"],
  ];
  assert.deepEqual(packed?.files.map(({ path }) => path).sort(), expected.sort());
  assert.equal(packed?.name, "piad");
  assert.ok(packed.size < 80_000, `${packed.size} bytes`);
});

test("packing as the guide says leaves nothing here", () => {
  const guide = readFileSync(join(PACKAGE, "README.md"), "utf8");
  const [pack] = /npm pack [^)\n]*/.exec(guide) ?? assert.fail("the guide packs it");
  const folder = mkdtempSync(join(tmpdir(), "piad-"));
  const before = readdirSync(PACKAGE);
  try {
    const elsewhere = pack.replace("../../../fit", folder);
    assert.notEqual(elsewhere, pack);
    execFileSync("sh", ["-c", `${elsewhere} --ignore-scripts`], { cwd: PACKAGE, stdio: "ignore" });
    assert.deepEqual(readdirSync(PACKAGE), before);
    assert.deepEqual(readdirSync(folder), [`piad-${about.version}.tgz`]);
  } finally {
    rmSync(folder, { recursive: true });
  }
});

test("packing as the guide says leaves nothing here", () => {
  const guide = readFileSync(join(PACKAGE, "README.md"), "utf8");
  const [pack] = /npm pack [^)\n]*/.exec(guide) ?? assert.fail("the guide packs it");
  const folder = mkdtempSync(join(tmpdir(), "piad-"));
  const before = readdirSync(PACKAGE);
  try {
    const elsewhere = pack.replace("../../../fit", folder);
    assert.notEqual(elsewhere, pack);
    execFileSync("sh", ["-c", `${elsewhere} --ignore-scripts`], { cwd: PACKAGE, stdio: "ignore" });
    assert.deepEqual(readdirSync(PACKAGE), before);
    assert.deepEqual(readdirSync(folder), [`piad-${about.version}.tgz`]);
  } finally {
    rmSync(folder, { recursive: true });
  }
});

test("what it is agrees with the server", () => {
  const cargo = readFileSync(join(ROOT, "Cargo.toml"), "utf8");
  const field = (name: string) => new RegExp(`^${name} = "(.*)"$`, "m").exec(cargo)?.[1];
  assert.deepEqual([about.version, about.license], [field("version"), field("license")]);
  assert.deepEqual(Object.keys(about.dependencies), ["eventsource-parser"]);
  for (const more of ["peerDependencies", "optionalDependencies", "bundleDependencies", "bundledDependencies"]) {
    assert.equal(about[more], undefined);
  }
});

test("sources and tests are compiled strictly", () => {
  for (const file of ["tsconfig.json", "test/tsconfig.json"]) {
    const { options } = ts.getParsedCommandLineOfConfigFile(join(PACKAGE, file), {}, {
      ...ts.sys,
      onUnRecoverableConfigFileDiagnostic: ({ messageText }) => assert.fail(String(messageText)),
    })!;
    const { strict, noImplicitAny, strictNullChecks, noUncheckedIndexedAccess } = options;
    assert.deepEqual([strict, noImplicitAny ?? true, strictNullChecks ?? true, noUncheckedIndexedAccess], [true, true, true, true], file);
  }
});

test("its types need no more than what is there in Node, and in browsers", () => {
  const common = { strict: true, noEmit: true, target: ts.ScriptTarget.ES2022 };
  const places: ts.CompilerOptions[] = [
    { lib: ["lib.es2022.d.ts"], types: ["node"], module: ts.ModuleKind.NodeNext },
    { lib: ["lib.es2022.d.ts", "lib.dom.d.ts"], types: [], module: ts.ModuleKind.ESNext, moduleResolution: ts.ModuleResolutionKind.Bundler },
  ];
  for (const place of places) {
    const program = ts.createProgram([join(PACKAGE, "dist/index.d.ts")], { ...common, ...place });
    const wrong = ts.getPreEmitDiagnostics(program).map(({ messageText }) => ts.flattenDiagnosticMessageText(messageText, "\n"));
    assert.deepEqual(wrong, []);
  }
});

test("no registry is named in the lock file", () => {
  assert.ok(!readFileSync(join(PACKAGE, "package-lock.json"), "utf8").includes("resolved"));
});

test("exports", () => {
  const classes = ["ApiError", "Batch", "Client", "ConnectionLost", "Job", "JobFailed", "PiadError", "ProtocolError", "Stream"];
  assert.deepEqual(Object.keys(piad).sort(), classes);
});
