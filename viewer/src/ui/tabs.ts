/** Panels of which one is seen. */

/** Makes the `section`s in an element panels that the buttons in its `nav` choose. */
export function tabs(root: HTMLElement): void {
  const buttons = [...root.querySelectorAll<HTMLButtonElement>("[role=tab]")];
  const panelOf = (button: HTMLElement) => document.getElementById(button.getAttribute("aria-controls") ?? "");
  const choose = (chosen: HTMLButtonElement) => {
    for (const button of buttons) {
      const on = button === chosen;
      button.setAttribute("aria-selected", String(on));
      button.tabIndex = on ? 0 : -1;
      panelOf(button)?.toggleAttribute("hidden", !on);
    }
  };
  buttons.forEach((button, i) => {
    button.addEventListener("click", () => choose(button));
    button.addEventListener("keydown", ({ key }) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[key];
      const next = step === undefined ? undefined : buttons[(i + step + buttons.length) % buttons.length];
      if (next === undefined) return;
      choose(next);
      next.focus();
    });
  });
  const [first] = buttons;
  if (first !== undefined) choose(first);
}
