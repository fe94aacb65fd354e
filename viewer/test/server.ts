/** Real servers on free ports. */

import { type ChildProcess, spawn } from "node:child_process";
import { once } from "node:events";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";

const ROOT = fileURLToPath(new URL("../..", import.meta.url));
const PROGRAM = process.env["PIAD_PROGRAM"] ?? join(ROOT, "target/debug/piad");

/** A server that keeps its jobs in memory, or in a directory. */
export class Server {
  readonly #directory: string;
  readonly #basePath: string;
  readonly #token: string;
  #address = "127.0.0.1:0";
  #process: ChildProcess | undefined;

  /** With a token it asks for that one. */
  constructor(directory = ":memory:", basePath = "/", token = "") {
    this.#directory = directory;
    this.#basePath = basePath;
    this.#token = token;
  }

  get url(): string {
    return `http://${this.#address}/`;
  }

  async start(): Promise<this> {
    const flags = ["--listen", this.#address, "--store", this.#directory, "--log-format", "json", "--base-path", this.#basePath];
    const child = spawn(PROGRAM, flags, { stdio: ["ignore", "ignore", "pipe"], env: { ...process.env, PIAD_TOKEN: this.#token } });
    this.#process = child;
    const log: string[] = [];
    // All lines are read: a full pipe would stop the server.
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

  async stop(): Promise<void> {
    const child = this.#process;
    if (child === undefined || child.exitCode !== null || child.signalCode !== null) return;
    child.kill("SIGKILL");
    await once(child, "exit");
  }

  /** A job of the server, which answers as JSON. */
  async job(request: unknown): Promise<{ id: string; state: string }> {
    const headers = { "Content-Type": "application/json", Prefer: "wait=10" };
    const response = await fetch(`${this.url}v1/jobs`, { method: "POST", headers, body: JSON.stringify(request) });
    return (await response.json()) as { id: string; state: string };
  }

  async get<T>(path: string): Promise<T> {
    return (await (await fetch(`${this.url}${path}`)).json()) as T;
  }
}
