/** Server-sent events (WHATWG HTML, section 9.2) in the pieces of a body. */

import { type EventSourceMessage, createParser } from "eventsource-parser";

/** An event, or how many seconds to wait before connecting again. */
export type Piece = EventSourceMessage | { readonly retry: number };

/**
 * The events in the pieces of a stream, which are asked for one by one: while nobody takes events, nothing is
 * read, and what is kept is what one piece completes. An event that is cut off by the end is dropped.
 */
export async function* events(chunks: AsyncIterable<Uint8Array>): AsyncGenerator<Piece, void, undefined> {
  let complete: Piece[] = [];
  const parser = createParser({
    onEvent: (event) => complete.push(event),
    onRetry: (milliseconds) => complete.push({ retry: milliseconds / 1000 }),
  });
  const decoder = new TextDecoder();
  for await (const chunk of chunks) {
    parser.feed(decoder.decode(chunk, { stream: true }));
    yield* complete;
    complete = [];
  }
}
