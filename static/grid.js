// The grid behind the map: a plain canvas beneath the viewer's transparent one, lines sharp at every zoom.

import { viewport, watch } from "./camera.js";
import { on, viewer } from "./channel.js";

const CELLS = [0.05, 0.1, 0.5, 1, 5, 10, 50, 100, 500, 1000, 5000];
const FINEST = 22; // px between lines

const sheet = document.createElement("canvas");
let shown = true;

/** The two cell sizes (m) for a scale: the finest that is not too fine, and the next. */
export function cells(metresPerPixel) {
  const first = CELLS.findIndex((cell) => cell / metresPerPixel >= FINEST);
  return first < 0 ? [] : CELLS.slice(first, first + 2);
}

function rules(cell, centre, metresPerPixel, length, stroke) {
  const first = Math.ceil((centre - (length / 2) * metresPerPixel) / cell);
  const last = Math.floor((centre + (length / 2) * metresPerPixel) / cell);
  for (let i = first; i <= last; i++) stroke(Math.round(length / 2 + (i * cell - centre) / metresPerPixel));
}

function draw({ x, y, metresPerPixel, width, height, turn }) {
  const ratio = window.devicePixelRatio || 1;
  attach();
  sheet.width = Math.round(width * ratio);
  sheet.height = Math.round(height * ratio);
  const pen = sheet.getContext("2d");
  const colours = getComputedStyle(sheet);
  if (!shown) return;
  const reach = turn ? Math.ceil(Math.hypot(sheet.width, sheet.height)) : 0; // turned, only a larger sheet covers all
  const [wide, tall] = turn ? [reach, reach] : [sheet.width, sheet.height];
  pen.translate(sheet.width / 2, sheet.height / 2);
  pen.rotate(turn);
  pen.translate(-wide / 2, -tall / 2);
  cells(metresPerPixel).forEach((cell, level) => {
    pen.fillStyle = colours.getPropertyValue(level ? "--scope-grid-strong" : "--scope-grid");
    const scale = metresPerPixel / ratio;
    rules(cell, x, scale, wide, (at) => pen.fillRect(at, 0, 1, tall));
    rules(cell, -y, scale, tall, (at) => pen.fillRect(0, at, wide, 1));
  });
}

function attach() {
  const { parentElement } = viewer().canvas;
  if (sheet.parentElement !== parentElement) parentElement.prepend(sheet);
}

function redraw() {
  const view = viewport();
  if (view) draw(view);
}

export function start() {
  sheet.className = "scope-sheet";
  sheet.setAttribute("aria-hidden", "true");
  watch(draw);
  on("grid", (value) => {
    shown = value;
    redraw();
  });
  on("dark", () => requestAnimationFrame(redraw));
}
