/** Parses server-sent events (WHATWG HTML, section 9.2) from chunks of a body. */

import { type EventSourceMessage, createParser } from "eventsource-parser";

/** An event, or the number of seconds to wait before reconnecting. */
export type Piece = EventSourceMessage | { readonly retry: number };

/**
 * Parses events from the chunks of a stream. Chunks are read on demand, and only the events of one chunk are buffered.
 * An incomplete event at the end is dropped.
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
