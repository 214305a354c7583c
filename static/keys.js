// Keys and clicks of the map: a key does the action that the table gives it.

import { actionOf, perform } from "./actions.js";
import { worldAt } from "./camera.js";
import { send, viewer } from "./channel.js";
import { openDialog } from "./dialog.js";

const CAMERA_CODES = new Set(["KeyW", "KeyA", "KeyS", "KeyD", "KeyQ", "KeyE"]);
const ALONE = new Set(["Shift", "Control", "Alt", "Meta", "CapsLock", "Dead", "Process", "Unidentified"]);
const PRESSING = new Set([" ", "Enter"]); // these work a focused button
const STEERING = /^(Arrow|Home|End|Page)/; // these work a focused slider, tab or list
const CLICK_PIXELS = 4;

const WRITTEN = "input:not([type=range], [type=checkbox]), textarea, select, [contenteditable=true]";

// The field of a closed dialog keeps the focus until the next frame is drawn: what is not seen takes no keys.
const writes = (target) => target.matches?.(WRITTEN) && target.checkVisibility();
const steers = (target) => target.closest?.("[role=slider], [role=tablist], [role=listbox], [role=menu], [role=dialog]");
const presses = (target) => target.closest?.("button, input[type=checkbox], a[href], summary, [role=button], [role=switch], [role=tab]");

/** The name of a key press: "f", "?", " ", "Shift+ArrowRight", "Ctrl+z"; a shifted character is that character. */
export function nameOf(event) {
  const character = event.key.length === 1;
  const shift = event.shiftKey && (!character || event.ctrlKey || event.metaKey || event.altKey || event.key === " ");
  const parts = [event.ctrlKey || event.metaKey ? "Ctrl" : "", event.altKey ? "Alt" : "", shift ? "Shift" : ""];
  return [...parts.filter(Boolean), shift && character ? event.key.toLowerCase() : event.key].join("+");
}

function pressed(event) {
  if (openDialog()) return inDialog(event);
  if (writes(event.target)) return;
  if (CAMERA_CODES.has(event.code) || event.code.startsWith("Arrow")) {
    if (steers(event.target)) return;
    event.stopImmediatePropagation(); // the viewer would move the camera
  }
  if (ALONE.has(event.key) || event.isComposing || event.key === "Tab") return;
  if (PRESSING.has(event.key) && presses(event.target)) return;
  if (STEERING.test(event.key) && steers(event.target)) return;
  const action = actionOf(nameOf(event));
  if (!action) return;
  event.preventDefault();
  if (!event.repeat || action.repeats) perform(action.id);
}

// A dialog has its own keys, and none of the map's; what opened it closes it.
function inDialog(event) {
  if (writes(event.target) || !["help", "palette"].includes(actionOf(nameOf(event))?.id)) return;
  event.preventDefault();
  openDialog().close();
}

// What was worked with the mouse gives the keys back to the map; who came by the keyboard stays.
function clicked(event) {
  if (event.detail > 0 && presses(event.target)) document.activeElement?.blur(); // at once: a key may follow
}

let down = null;

function pointerDown(event) {
  const onMap = event.target === viewer()?.canvas;
  if (onMap) document.activeElement?.blur();
  down = onMap && event.button === 0 && event.isPrimary ? event : null;
}

// A click on a button or a tab leaves the keys with the map; who works it by keyboard keeps it.
function release() {
  const focused = document.activeElement;
  if (focused && focused !== document.body && !writes(focused)) focused.blur();
}

function pointerUp(event) {
  setTimeout(release);
  if (!down) return;
  const moved = Math.hypot(event.clientX - down.clientX, event.clientY - down.clientY);
  if (moved <= CLICK_PIXELS && event.pointerId === down.pointerId) send("click", worldAt(down));
  down = null;
}

export function start() {
  window.addEventListener("keydown", pressed, { capture: true });
  window.addEventListener("click", clicked);
  window.addEventListener("pointerdown", pointerDown, { capture: true });
  window.addEventListener("pointerup", pointerUp, { capture: true });
}
