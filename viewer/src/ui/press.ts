/** Nothing moves under a pressed pointer: what changes the layout waits until the pointer is released. */

const waiting = new Set<() => void>();
let isPressed = false;
let timer = 0;

/** Calls at once, or when the pointer that is pressed has been released and its click has been handled. */
export function whenReleased(change: () => void): void {
  if (isPressed) waiting.add(change);
  else change();
}

function press(event: MouseEvent): void {
  // The list of a select takes the pointer: its release is not reported.
  if (event.button !== 0 || event.target instanceof HTMLSelectElement) return;
  clearTimeout(timer);
  isPressed = true;
}

function release(): void {
  if (!isPressed) return;
  clearTimeout(timer);
  // The click comes after the release, in the same task.
  timer = window.setTimeout(() => {
    isPressed = false;
    const changes = [...waiting];
    waiting.clear();
    for (const change of changes) change();
  });
}

// Of a touch, the browser makes a press of a mouse when it has ended, which moves the focus.
for (const type of ["pointerdown", "mousedown"] as const) addEventListener(type, press, { capture: true });
for (const type of ["pointerup", "pointercancel", "mouseup", "blur"] as const) addEventListener(type, release, { capture: true });
addEventListener("pointermove", ({ buttons }) => buttons === 0 && release(), { capture: true });
