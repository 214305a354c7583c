// The camera: straight down for ever. Every button pans, the wheel zooms about the pointer, nothing can tilt; only Python
// may turn it about the vertical.

import { connected, on, send, viewer } from "./channel.js";
import { together } from "./lines.js";

const MIN_VIEW = 0.2; // m from top to bottom
const MAX_VIEW = 5000;
const DEPTH = 20; // m above and below the floor that are drawn
const MARGIN = 28; // px around what is fitted

const watchers = [];
let locked = null; // the camera controls that have been configured
let sender = null; // changes with every connection
let shown = ""; // what the watchers know
let wanted = null; // the rectangle to show; null once a person has moved the camera
let touched = false; // it is where a person wants it, not where a fit has put it
let fitted = ""; // the last fit that was asked for
let bottom = 0; // px covered by the timeline
let turn = 0; // rad from north up to what is up now, anticlockwise
let aim = null; // a place to show; null once the camera stands there, or a person has moved it
let timer = null;
let kept = null; // where a person has put the camera: the viewer takes it away with every new connection
let adrift = false; // it has done so, and nobody has put it back yet

/** What this page sees: centre (m), metres per CSS pixel, size (px), turn (rad); null until the camera is up. */
export function viewport() {
  const { canvas, camera } = viewer() ?? {};
  if (!canvas?.clientHeight || !camera) return null;
  const tall = 2 * camera.position.y * Math.tan((camera.fov * Math.PI) / 360);
  if (!(tall > 0.1 * MIN_VIEW)) return null; // not placed yet
  return {
    x: -camera.position.z, // the viewer's own axes: left, up, back
    y: -camera.position.x,
    metresPerPixel: tall / canvas.clientHeight,
    width: canvas.clientWidth,
    height: canvas.clientHeight,
    turn,
  };
}

/** A step to the right and up on the screen, as a step in the world. */
function inWorld(right, up) {
  return [right * Math.cos(turn) - up * Math.sin(turn), right * Math.sin(turn) + up * Math.cos(turn)];
}

/** The point of the world under a pointer event. */
export function worldAt(event) {
  const view = viewport();
  const box = viewer().canvas.getBoundingClientRect();
  const right = (event.clientX - box.left - view.width / 2) * view.metresPerPixel;
  const up = -(event.clientY - box.top - view.height / 2) * view.metresPerPixel;
  const [x, y] = inWorld(right, up);
  return { x: view.x + x, y: view.y + y, metresPerPixel: view.metresPerPixel };
}

/** Call `watcher(viewport)` whenever something else is seen. */
export function watch(watcher) {
  watchers.push(watcher);
}

/** Say how many pixels at the bottom are covered, so that a fit keeps clear of them. */
export function coverBottom(pixels) {
  if (pixels === bottom) return;
  bottom = pixels;
  check();
}

/** Go nearer (factor above 1) or farther, about the middle of the view. */
export function zoom(factor) {
  check(); // the viewer may have new controls by now
  const view = viewport();
  if (!locked || !view) return;
  const from = aim ?? standing(view); // two quick presses zoom twice
  const most = MAX_VIEW / view.height;
  const metresPerPixel = Math.min(Math.max(from.metresPerPixel / factor, MIN_VIEW / view.height), most);
  letGo();
  aim = { ...from, metresPerPixel, glide: true };
  check();
}

function letGo() {
  [wanted, aim, touched, adrift] = [null, null, true, false];
}

// Where the camera is going, not where it is.
function standing(view) {
  const { radius } = locked.getSpherical({ copy: (end) => end });
  const target = locked.getTarget({ copy: (end) => end });
  return { x: -target.z, y: -target.x, metresPerPixel: (radius * tangent()) / view.height };
}

function lock(controls) {
  const { ACTION } = controls.constructor;
  Object.assign(controls.mouseButtons, {
    left: ACTION.TRUCK,
    middle: ACTION.TRUCK,
    right: ACTION.TRUCK,
    wheel: ACTION.DOLLY,
  });
  Object.assign(controls.touches, {
    one: ACTION.TOUCH_TRUCK,
    two: ACTION.TOUCH_DOLLY_TRUCK,
    three: ACTION.TOUCH_TRUCK,
  });
  controls.dollyToCursor = true;
  controls.dollySpeed = 0.6;
  controls.minDistance = MIN_VIEW / tangent();
  viewer().configuredMaxOrbitDistance = MAX_VIEW / tangent();
  controls.addEventListener("control", letGo);
  controls.addEventListener("update", changed);
  controls.addEventListener("rest", changed);
  dress();
  locked = controls;
}

function changed() {
  const view = viewport();
  if (!view) return;
  keep(view);
  const key = Object.values(view).join();
  if (key === shown) return;
  shown = key;
  focusDepth();
  for (const watcher of watchers) watcher(view);
  timer ??= setTimeout(report, 80);
}

function keep({ x, y, metresPerPixel }) {
  if (connected() && viewer().sendMessage !== sender) adrift = sender !== null;
  if (!adrift && !aim) kept = touched ? [x, y, metresPerPixel] : null;
}

/** Where a person has put the camera of this page (x, y, metres per pixel); null where a fit has put it. */
export const standpoint = () => kept;

// All layers lie within a few metres of the floor: near and far as close around it as that, or depth is too coarse.
function focusDepth() {
  const { camera } = viewer();
  camera.near = Math.max(camera.position.y / 2, camera.position.y - DEPTH);
  camera.far = camera.position.y + DEPTH;
  camera.updateProjectionMatrix();
}

function report() {
  timer = null;
  const view = viewport();
  if (view) send("viewport", { ...view, fitted: !touched });
}

function fit({ bounds, number }) {
  if (number === fitted) return; // said again after a lost connection
  fitted = number;
  [wanted, aim, touched, adrift] = [bounds, null, false, false];
  check();
}

function look(place) {
  if (place.number === fitted) return; // said again after a lost connection
  fitted = place.number;
  [wanted, aim, touched, adrift] = [null, place, true, false];
  check();
}

/** Where the camera must stand to show a rectangle, clear of what covers the bottom. */
function placeFor([left, low, right, high], view) {
  const [across, along] = [Math.abs(Math.cos(turn)), Math.abs(Math.sin(turn))];
  const [width, height] = [right - left, high - low];
  const wide = Math.max(width * across + height * along, MIN_VIEW) / Math.max(view.width - 2 * MARGIN, 50);
  const tall = Math.max(width * along + height * across, MIN_VIEW) / Math.max(view.height - 2 * MARGIN - bottom, 50);
  const metresPerPixel = Math.min(Math.max(wide, tall), MAX_VIEW / view.height);
  const [x, y] = inWorld(0, -(bottom / 2) * metresPerPixel);
  return { x: (left + right) / 2 + x, y: (low + high) / 2 + y, metresPerPixel };
}

// Panels that open and close change the room there is, and the viewer puts its camera back where it began when it
// connects: what was to be seen stays in sight until a person looks elsewhere.
function keepShown(view) {
  if (!wanted) return;
  const place = placeFor(wanted, view);
  if (!stands(place, view)) stand(place, view, true);
}

// A glide may be cut short by the viewer, for one when it renders its controls anew: it is begun again until it ends.
function keepAiming(view) {
  if (!aim) return;
  if (stands(aim, view)) aim = null;
  else stand(aim, view, aim.glide);
}

function stands({ x, y, metresPerPixel }, view) {
  const away = Math.hypot(x - view.x, y - view.y) / metresPerPixel;
  return away < 0.5 && Math.abs(Math.log(view.metresPerPixel / metresPerPixel)) < 0.001;
}

function stand({ x, y, metresPerPixel }, view, glide) {
  const distance = (metresPerPixel * view.height) / tangent();
  locked.setLookAt(-y, distance, -x, -y, 0, -x, glide);
}

// The viewer's camera has an "up" of its own, and gets its first one back with every connection.
function keepTurned(view) {
  const { up } = viewer().camera;
  const [x, y, z] = [-Math.cos(turn), 0, Math.sin(turn)];
  if (Math.hypot(up.x - x, up.y - y, up.z - z) < 1e-9) return;
  const place = standing(view);
  up.set(x, y, z);
  locked.updateCameraUp();
  stand(place, view, false);
}

function tangent() {
  return 2 * Math.tan((viewer().camera.fov * Math.PI) / 360);
}

// The viewer would map our colours as if they were light in a room, and says nothing of its canvas.
function dress() {
  const { scene, canvas } = viewer();
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", "The map, seen from above");
  if (!scene) return;
  scene.onBeforeRender = (renderer) => {
    renderer.toneMapping = 0;
    together(scene);
  };
}

// The viewer may replace its controls, lose its connection or change its size at any time.
function check() {
  const internals = viewer();
  if (!internals?.cameraControl || !viewport()) return;
  if (internals.cameraControl !== locked) lock(internals.cameraControl);
  keep(viewport());
  if (internals.sendMessage !== sender) {
    sender = internals.sendMessage;
    timer ??= setTimeout(report, 80);
  }
  keepTurned(viewport());
  keepAiming(viewport());
  keepShown(viewport());
  changed();
}

export function start() {
  on("fit", fit);
  on("look", look);
  on("turn", (value) => {
    turn = value;
    check();
  });
  setInterval(check, 250);
  window.addEventListener("resize", () => requestAnimationFrame(check));
  window.addEventListener("contextmenu", (event) => {
    if (event.target === viewer()?.canvas) event.preventDefault();
  });
  window.splinescope.camera = { viewport, worldAt };
}
