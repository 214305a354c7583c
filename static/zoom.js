// Buttons for those who have no wheel: nearer, farther, the whole map.

import { does, perform, titleOf, watchActions } from "./actions.js";
import { zoom } from "./camera.js";
import { layer } from "./overlay.js";

const STEP = 1.6;
const BUTTONS = [
  ["zoom-in", "M12 5v14M5 12h14"],
  ["zoom-out", "M5 12h14"],
  ["fit", "M4 9V4h5M20 9V4h-5M4 15v5h5M20 15v5h-5"],
];

export function start() {
  const card = document.createElement("div");
  card.className = "scope-zoom scope-card";
  card.setAttribute("role", "group");
  card.setAttribute("aria-label", "Zoom");
  for (const [id, path] of BUTTONS) {
    const button = document.createElement("button");
    button.type = "button";
    button.className = "scope-button";
    button.innerHTML = `<svg viewBox="0 0 24 24" aria-hidden="true"><path d="${path}"/></svg>`;
    button.addEventListener("click", () => perform(id));
    watchActions(() => {
      button.title = titleOf(id);
      button.setAttribute("aria-label", button.title);
    });
    card.append(button);
  }
  layer.append(card);
  does("zoom-in", () => zoom(STEP));
  does("zoom-out", () => zoom(1 / STEP));
}
