/** The environment of scenarios, in Node or a browser. */

import type { Client, ClientOptions } from "piad";

/** Servers and proxies, identified by their addresses. */
export interface Environment {
  /** Starts a server that stores its jobs, optionally with a base path or a required token. */
  durable(basePath?: string, token?: string): Promise<string>;
  /** Sends SIGKILL: connections are not closed cleanly. */
  kill(server: string): Promise<void>;
  /** Restarts a server with the same data at the same address. */
  restart(server: string): Promise<void>;
  /** Starts a proxy of a server. */
  proxy(server: string): Promise<string>;
  /** The number of bytes sent to clients through a proxy. */
  passed(proxy: string): Promise<number>;
  /** Breaks the connection after this number of bytes. */
  cutAfter(proxy: string, bytes: number): Promise<void>;
  /** Breaks the connection before the first byte of the next response. */
  loseAnswer(proxy: string): Promise<void>;
  /** An address without a server. */
  nowhere(): Promise<string>;
}

export interface World {
  /** A server without other users. */
  readonly url: string;
  readonly environment: Environment;
  /** A client of that server, or of another one. */
  client(options?: ClientOptions, url?: string): Client;
}

/** The scenarios by name. */
export type Scenarios = Readonly<Record<string, (world: World) => Promise<void>>>;
