/** The part of the viewport that a fit has. */

/** A part of the canvas, in pixels of the page from its upper left corner. */
export interface Cell {
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
}
