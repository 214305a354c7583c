// Shift and the mouse in the map: a click adds to what is selected or takes away from it, a drag draws a box around
// what is to be selected.

import { worldAt } from "./camera.js";
import { send, viewer } from "./channel.js";
import { layer } from "./overlay.js";

const CLICK_PIXELS = 4;

const box = document.createElement("div");
let down = null;

const isClick = (event) => Math.hypot(event.clientX - down.clientX, event.clientY - down.clientY) <= CLICK_PIXELS;

function begin(event) {
  if (!event.shiftKey || event.target !== viewer()?.canvas || event.button !== 0 || !event.isPrimary) return;
  event.stopImmediatePropagation(); // the map would move
  event.preventDefault();
  document.activeElement?.blur();
  down = event;
}

function draw(event) {
  if (!down || event.pointerId !== down.pointerId) return;
  event.stopImmediatePropagation();
  box.hidden = isClick(event);
  const frame = layer.getBoundingClientRect();
  Object.assign(box.style, {
    left: `${Math.min(down.clientX, event.clientX) - frame.left}px`,
    top: `${Math.min(down.clientY, event.clientY) - frame.top}px`,
    width: `${Math.abs(event.clientX - down.clientX)}px`,
    height: `${Math.abs(event.clientY - down.clientY)}px`,
  });
}

// The corners go round: the map may be turned, so that two of them would not say what the box is.
function end(event) {
  if (!down || event.pointerId !== down.pointerId) return;
  event.stopImmediatePropagation();
  if (isClick(event)) send("add", worldAt(down));
  else {
    const [here, there] = [down, event];
    const round = [[here, here], [there, here], [there, there], [here, there]];
    const corners = round.map(([a, b]) => worldAt({ clientX: a.clientX, clientY: b.clientY }));
    send("box", corners.map(({ x, y }) => [x, y]));
  }
  drop();
}

function drop() {
  down = null;
  box.hidden = true;
}

function pressed(event) {
  if (!down || event.key !== "Escape") return;
  event.stopImmediatePropagation();
  drop();
}

export function start() {
  box.className = "scope-box";
  box.hidden = true;
  layer.append(box);
  window.addEventListener("pointerdown", begin, { capture: true });
  window.addEventListener("pointermove", draw, { capture: true });
  window.addEventListener("pointerup", end, { capture: true });
  window.addEventListener("pointercancel", drop, { capture: true });
  window.addEventListener("keydown", pressed, { capture: true });
}
