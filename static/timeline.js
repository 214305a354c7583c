// The timeline: where the cursor stands among the scans, what is processed, what to find again, and the play buttons.

import { does, perform, titleOf, watchActions } from "./actions.js";
import { coverBottom } from "./camera.js";
import { on, send } from "./channel.js";
import { layer } from "./overlay.js";

const SPEEDS = [0.25, 0.5, 1, 2, 5, 10, 50];
const ICONS = {
  play: "M7 4.5v15l12.5-7.5z",
  pause: "M6.5 5h4v14h-4zM13.5 5h4v14h-4z",
  "back-10": "M11.5 5v14l-8-7zM20.5 5v14l-8-7z",
  "previous-scan": "M16.5 5v14l-9-7z",
  "next-scan": "M7.5 5v14l9-7z",
  "on-10": "M3.5 5v14l8-7zM12.5 5v14l8-7z",
};
const CORNERS = 44; // px: the scale and the legend stand above the timeline
const MARKS = [
  ["key", "--scope-mark-key", 0.62, 1],
  ["loop", "--scope-mark-loop", 0, 0.5],
  ["new", "--scope-mark-new", 0.5, 0.62],
  ["gated", "--scope-mark-gated", 0.5, 0.62],
  ["lost", "--scope-mark-lost", 0, 1],
  ["hand", "--scope-mark-hand", 0, 0.62],
];

const ask = (command, value) => send("timeline", { command, value });

let state = { index: 0, length: 0, processed: 0, playing: false, speed: 1, label: "" };
let marks = {};
let held = false; // while a person drags the thumb it is theirs

function button(id) {
  const made = document.createElement("button");
  made.type = "button";
  made.className = `scope-button scope-${id}`;
  made.addEventListener("click", () => perform(id));
  dress(made, id, titleOf(id));
  return made;
}

function dress(made, icon, title) {
  if (made.dataset.icon === icon && made.title === title) return;
  made.dataset.icon = icon;
  made.setAttribute("aria-label", title);
  made.title = title;
  made.innerHTML = `<svg viewBox="0 0 24 24" aria-hidden="true"><path d="${ICONS[icon]}"/></svg>`;
}

const buttons = new Map(["back-10", "previous-scan", "play", "next-scan", "on-10"].map((id) => [id, button(id)]));
const track = document.createElement("div");
const strip = document.createElement("canvas");
const slider = document.createElement("input");
const counter = document.createElement("label");
const jump = document.createElement("input");
const total = document.createElement("span");
const note = document.createElement("span");
const status = document.createElement("div");
const progress = document.createElement("i");
const doing = document.createElement("span");
const speed = document.createElement("select");

function show() {
  const last = Math.max(state.length - 1, 0);
  for (const [id, made] of buttons) if (id !== "play") dress(made, id, titleOf(id));
  dress(buttons.get("play"), state.playing ? "pause" : "play", titleOf("play", state.playing ? "Pause" : "Play"));
  slider.max = last;
  slider.disabled = state.length === 0;
  for (const each of buttons.values()) each.disabled = state.length === 0;
  if (!held) slider.value = state.index;
  slider.setAttribute("aria-valuetext", `scan ${state.index} of ${last}`);
  if (document.activeElement !== jump) jump.value = state.index;
  jump.max = last;
  jump.style.width = `${Math.max(`${last}`.length, 2) + 1}ch`;
  total.textContent = ` / ${last}`;
  note.textContent = state.label;
  speed.value = SPEEDS.reduce((best, each) => (Math.abs(each - state.speed) < Math.abs(best - state.speed) ? each : best));
  draw();
}

function draw() {
  const ratio = window.devicePixelRatio || 1;
  const [width, height] = [strip.clientWidth, strip.clientHeight];
  if (!width) return;
  strip.width = width * ratio;
  strip.height = height * ratio;
  const pen = strip.getContext("2d");
  const colours = getComputedStyle(layer);
  const last = Math.max(state.length - 1, 1);
  pen.scale(ratio, ratio);
  pen.fillStyle = colours.getPropertyValue("--scope-track");
  pen.fillRect(0, height * 0.62, width, height * 0.38);
  pen.fillStyle = colours.getPropertyValue("--scope-done");
  pen.fillRect(0, height * 0.62, (width * Math.min(state.processed, state.length)) / Math.max(state.length, 1), height * 0.38);
  for (const [kind, colour, top, base] of MARKS) {
    pen.fillStyle = colours.getPropertyValue(colour);
    for (const position of marks[kind] ?? []) pen.fillRect((position / last) * width - 0.5, top * height, 1, (base - top) * height);
  }
  pen.fillStyle = colours.getPropertyValue("--scope-accent");
  const shown = held ? Number(slider.value) : state.index;
  pen.fillRect((shown / last) * width - 1, 0, 2, height);
}

function build() {
  const bar = document.createElement("div");
  bar.className = "scope-timeline scope-card";
  bar.setAttribute("role", "group");
  bar.setAttribute("aria-label", "Timeline");
  const row = document.createElement("div");
  row.className = "scope-row";
  track.className = "scope-track";
  Object.assign(slider, { type: "range", min: 0, max: 0, step: 1 });
  slider.setAttribute("aria-label", "Scan under the cursor");
  Object.assign(jump, { type: "number", min: 0, step: 1 });
  jump.setAttribute("aria-label", "Jump to scan");
  counter.className = "scope-counter";
  counter.append("Scan ", jump, total);
  note.className = "scope-note";
  speed.className = "scope-speed";
  speed.setAttribute("aria-label", "Playing speed");
  speed.append(...SPEEDS.map((each) => new Option(`${each}×`, each)));
  const controls = document.createElement("div");
  controls.className = "scope-buttons";
  controls.append(...buttons.values());
  track.append(strip, slider);
  row.append(counter, note, controls, speed);
  status.className = "scope-status";
  status.setAttribute("role", "status");
  status.append(progress, doing);
  bar.append(track, row, status);
  layer.append(bar);
  return bar;
}

export function start() {
  const bar = build();
  slider.addEventListener("pointerdown", () => (held = true));
  for (const end of ["pointerup", "pointercancel", "blur"]) slider.addEventListener(end, () => (held = false));
  slider.addEventListener("input", () => {
    ask("seek", Number(slider.value));
    draw();
  });
  jump.addEventListener("change", () => {
    if (jump.value !== "" && jump.checkValidity()) ask("seek", Number(jump.value));
    jump.blur();
    show();
  });
  speed.addEventListener("change", () => {
    ask("speed", Number(speed.value));
    speed.blur();
  });
  does("go-to-scan", () => {
    jump.focus();
    jump.select();
  });
  jump.addEventListener("keydown", (event) => {
    if (event.key === "Escape") jump.value = slider.value;
    if (["Escape", "Enter"].includes(event.key)) jump.blur(); // the number that was there is no change, and is answered, too
  });
  watchActions(show);
  on("role", ({ driving }) => (bar.inert = !driving));
  on("timeline", (value) => {
    state = value;
    bar.hidden = false;
    coverBottom(bar.offsetHeight + CORNERS);
    show();
  });
  on("status", ({ text, busy, fraction }) => {
    doing.textContent = text;
    status.classList.toggle("scope-busy", busy);
    progress.style.width = busy ? `${100 * (fraction ?? 1)}%` : "0";
    bar.hidden = false;
    coverBottom(bar.offsetHeight + CORNERS);
  });
  on("marks", (value) => {
    marks = value;
    draw();
  });
  on("dark", () => requestAnimationFrame(draw));
  new ResizeObserver(draw).observe(strip);
  bar.hidden = true;
}
