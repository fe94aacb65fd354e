/** Real servers on free ports. */

import { type ChildProcess, spawn } from "node:child_process";
import { once } from "node:events";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";

export const ROOT = fileURLToPath(new URL("../../..", import.meta.url));
const PROGRAM = process.env["PIAD_PROGRAM"] ?? join(ROOT, "target/debug/piad");

/** A server that can be killed and restarted with the same data at the same address. */
export class Server {
  #address = "127.0.0.1:0";
  #process: ChildProcess | undefined;
  readonly #data: string;
  readonly #temporary: boolean;

  readonly #basePath: string;
  readonly #token: string;

  /** `data` is the directory of jobs, by default a temporary one. With a token, the server requires it. */
  constructor(data?: string, basePath = "/", token = "") {
    this.#basePath = basePath;
    this.#token = token;
    this.#temporary = data === undefined;
    this.#data = data ?? mkdtempSync(join(tmpdir(), "piad-typescript-"));
  }

  get url(): string {
    return `http://${this.#address}`;
  }

  async start(): Promise<this> {
    const flags = ["--listen", this.#address, "--store", this.#data, "--log-format", "json", "--cors-origin", "*", "--base-path", this.#basePath];
    const env = { ...process.env, PIAD_TOKEN: this.#token };
    const child = spawn(PROGRAM, flags, { env, stdio: ["ignore", "ignore", "pipe"] });
    this.#process = child;
    const log: string[] = [];
    // Reads all lines: a full pipe would block the server.
    const lines = createInterface({ input: child.stderr });
    this.#address = await new Promise<string>((resolve, reject) => {
      lines.on("line", (line) => {
        log.push(line);
        const found = /listening on http:\/\/([^\s"/]+)/.exec(line)?.[1];
        if (found !== undefined) resolve(found);
      });
      child.on("error", reject);
      child.on("exit", () => reject(new Error(`${PROGRAM} has not started: ${log.join("\n")}`)));
    });
    return this;
  }

  /** Sends SIGKILL: connections are not closed cleanly. */
  async kill(): Promise<void> {
    const child = this.#process;
    if (child === undefined || child.exitCode !== null || child.signalCode !== null) return;
    child.kill("SIGKILL");
    await once(child, "exit");
  }

  /** Kills the server and deletes its data. */
  async remove(): Promise<void> {
    await this.kill();
    if (this.#temporary) rmSync(this.#data, { recursive: true, force: true });
  }
}
