// What lies over the map: the scale bar and the pointer's coordinates.

import { viewport, watch, worldAt } from "./camera.js";
import { on, viewer } from "./channel.js";

const LONGEST = 160; // px of the scale bar

/** The layer that follows the canvas; everything of ours lies in it. */
export const layer = document.createElement("div");

/** The longest of 1, 2, 5 × 10^k metres that fits into `pixels`. */
export function roundLength(metresPerPixel, pixels = LONGEST) {
  const room = metresPerPixel * pixels;
  const power = 10 ** Math.floor(Math.log10(room) + 1e-9);
  return [5, 2, 1].find((factor) => factor * power <= room * (1 + 1e-9)) * power;
}

/** A length for a person: 2 km, 5 m, 20 cm, 5 mm. */
export function sayLength(metres) {
  const [factor, unit] = [[1e-3, "km"], [1, "m"], [100, "cm"], [1000, "mm"]].find(([f, u]) => metres * f >= 0.999 || u === "mm");
  return `${+(metres * factor).toPrecision(3)} ${unit}`;
}

const bar = document.createElement("div");
const readout = document.createElement("div");
const hint = document.createElement("div");

function drawScale({ metresPerPixel }) {
  const length = roundLength(metresPerPixel);
  bar.style.width = `${length / metresPerPixel}px`;
  bar.textContent = sayLength(length);
  bar.setAttribute("aria-label", `Scale: this bar is ${sayLength(length)} long`);
}

function place() {
  const box = viewer()?.canvas?.getBoundingClientRect();
  if (!box?.height) return;
  Object.assign(layer.style, {
    left: `${box.left}px`,
    top: `${box.top}px`,
    width: `${box.width}px`,
    height: `${box.height}px`,
  });
  layer.classList.toggle("narrow", box.width < 720);
}

function pointerMoved(event) {
  if (event.target !== viewer()?.canvas || !viewport()) {
    readout.textContent = "";
    return;
  }
  const { x, y, metresPerPixel } = worldAt(event);
  const digits = metresPerPixel < 0.005 ? 3 : 2;
  const say = (number) => number.toFixed(digits).replace("-", "−");
  readout.textContent = `x ${say(x)}  y ${say(y)} m`;
}

export function start() {
  layer.id = "splinescope";
  const corner = document.createElement("div");
  corner.className = "scope-scale scope-card";
  bar.className = "scope-bar";
  bar.setAttribute("role", "img");
  readout.className = "scope-readout";
  hint.className = "scope-hint";
  hint.setAttribute("role", "status");
  corner.append(bar, readout, hint);
  layer.append(corner);
  document.body.prepend(layer); // the keyboard comes to the map before the panels
  watch((view) => {
    place();
    drawScale(view);
  });
  new ResizeObserver(place).observe(document.body);
  on("hint", (text) => (hint.textContent = text));
  on("dark", (dark) => document.documentElement.classList.toggle("scope-light", !dark));
  window.addEventListener("pointermove", pointerMoved, { passive: true });
}
