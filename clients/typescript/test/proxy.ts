/** A proxy that counts bytes and breaks connections. */

import { once } from "node:events";
import { type AddressInfo, type Server, type Socket, connect, createServer } from "node:net";

export class Proxy {
  /** The number of bytes sent to clients. */
  passed = 0;
  readonly #target: URL;
  readonly #open = new Set<Socket>();
  readonly #server: Server;
  #losing = false;
  #left = Infinity;

  constructor(target: string) {
    this.#target = new URL(target);
    this.#server = createServer((client) => this.#serve(client));
  }

  async start(): Promise<this> {
    this.#server.listen(0, "127.0.0.1");
    await once(this.#server, "listening");
    return this;
  }

  get url(): string {
    return `http://127.0.0.1:${(this.#server.address() as AddressInfo).port}`;
  }

  /** Breaks the connection before the first byte of the next response. */
  loseAnswer(): void {
    this.#losing = true;
  }

  /** Breaks the connection after this number of bytes. */
  cutAfter(bytes: number): void {
    this.#left = bytes;
  }

  stop(): void {
    for (const socket of this.#open) socket.destroy();
    this.#server.close();
  }

  #serve(client: Socket): void {
    const server = connect(Number(this.#target.port), this.#target.hostname);
    for (const [socket, other] of [[client, server], [server, client]] as const) {
      this.#open.add(socket);
      socket.on("error", () => socket.destroy());
      socket.on("close", () => {
        this.#open.delete(socket);
        other.destroy();
      });
    }
    client.pipe(server);
    // Reads from the server only as fast as the client reads.
    server.on("data", (chunk) => {
      if (this.#isLost(chunk)) return void client.destroy();
      this.passed += chunk.length;
      this.#left -= chunk.length;
      if (this.#left < 0) return this.#cut(client, server, chunk);
      if (client.write(chunk)) return;
      server.pause();
      client.once("drain", () => server.resume());
    });
    server.on("end", () => client.end());
  }

  /** Browsers discard unread bytes when a connection breaks, so they get time to read. */
  #cut(client: Socket, server: Socket, chunk: Buffer): void {
    server.pause();
    client.write(chunk.subarray(0, chunk.length + this.#left));
    this.#left = Infinity;
    setTimeout(() => client.end(), 500);
  }

  /** True if this response is to be lost; preflights are not. */
  #isLost(chunk: Buffer): boolean {
    const lost = this.#losing && !/^access-control-allow-methods/im.test(chunk.toString("latin1"));
    if (lost) this.#losing = false;
    return lost;
  }
}
