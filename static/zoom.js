// Buttons for those who have no wheel: nearer, farther, the whole map.

import { zoom } from "./camera.js";
import { send } from "./channel.js";
import { layer } from "./overlay.js";

const STEP = 1.6;
const BUTTONS = [
  ["Zoom in (+)", "M12 5v14M5 12h14", () => zoom(STEP)],
  ["Zoom out (−)", "M5 12h14", () => zoom(1 / STEP)],
  ["Show the whole map (F)", "M4 9V4h5M20 9V4h-5M4 15v5h5M20 15v5h-5", () => send("key", "f")],
];

/** Zoom by a key, if it is one for that: +, = or −. */
export function zoomBy(key) {
  if (!["+", "=", "-"].includes(key)) return false;
  zoom(key === "-" ? 1 / STEP : STEP);
  return true;
}

export function start() {
  const card = document.createElement("div");
  card.className = "scope-zoom scope-card";
  card.setAttribute("role", "group");
  card.setAttribute("aria-label", "Zoom");
  for (const [label, path, act] of BUTTONS) {
    const button = document.createElement("button");
    button.type = "button";
    button.className = "scope-button";
    button.title = label;
    button.setAttribute("aria-label", label);
    button.innerHTML = `<svg viewBox="0 0 24 24" aria-hidden="true"><path d="${path}"/></svg>`;
    button.addEventListener("click", act);
    card.append(button);
  }
  layer.append(card);
}
