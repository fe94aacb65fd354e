/** Servers and proxies, identified by their addresses. */

import { Proxy } from "./proxy.js";
import { Server } from "./server.js";
import type { Environment } from "./world.js";

export class LocalEnvironment implements Environment {
  readonly #servers = new Map<string, Server>();
  readonly #proxies = new Map<string, Proxy>();

  durable = async (basePath = "/", token = ""): Promise<string> => {
    const server = await new Server(undefined, basePath, token).start();
    this.#servers.set(server.url, server);
    return server.url;
  };

  kill = async (url: string): Promise<void> => this.#servers.get(url)?.kill();

  restart = async (url: string): Promise<void> => {
    await this.#servers.get(url)?.start();
  };

  proxy = async (url: string): Promise<string> => {
    const proxy = await new Proxy(url).start();
    this.#proxies.set(proxy.url, proxy);
    return proxy.url;
  };

  passed = async (url: string): Promise<number> => this.#proxies.get(url)?.passed ?? 0;

  cutAfter = async (url: string, bytes: number): Promise<void> => this.#proxies.get(url)?.cutAfter(bytes);

  loseAnswer = async (url: string): Promise<void> => this.#proxies.get(url)?.loseAnswer();

  nowhere = async (): Promise<string> => {
    const proxy = await new Proxy("http://127.0.0.1:1").start();
    const { url } = proxy;
    proxy.stop();
    return url;
  };

  /** Stops all servers and proxies. */
  async clear(): Promise<void> {
    for (const proxy of this.#proxies.values()) proxy.stop();
    for (const server of this.#servers.values()) await server.remove();
  }
}
