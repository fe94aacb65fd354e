/** What scenarios need of the world; they run in Node and in a browser. */

import type { Client, ClientOptions } from "piad";

/** Servers and proxies, which are processes of the machine: known by their addresses. */
export interface Backstage {
  /** Starts a server that keeps its jobs, perhaps with a path that clients see it below, or a token that it asks for. */
  durable(basePath?: string, token?: string): Promise<string>;
  /** Sends SIGKILL: connections are not closed cleanly. */
  kill(server: string): Promise<void>;
  /** Starts a server again, with the same data at the same address. */
  restart(server: string): Promise<void>;
  /** Starts a proxy of a server. */
  proxy(server: string): Promise<string>;
  /** How many bytes have gone through a proxy to clients. */
  passed(proxy: string): Promise<number>;
  /** Breaks the connection off that brings the last of so many bytes. */
  cutAfter(proxy: string, bytes: number): Promise<void>;
  /** The next answer breaks off before its first byte has come. */
  loseAnswer(proxy: string): Promise<void>;
  /** An address at which nobody listens. */
  nowhere(): Promise<string>;
}

export interface World {
  /** A server without other users. */
  readonly url: string;
  readonly backstage: Backstage;
  /** A client of that server, or of another one. */
  client(options?: ClientOptions, url?: string): Client;
}

/** What is done and found, by its name. */
export type Scenarios = Readonly<Record<string, (world: World) => Promise<void>>>;
