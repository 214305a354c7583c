// The tabs of the side bar: opened by actions called `tab-…` with their names, and as they were on the last visit.

import { does, rows, watchActions } from "./actions.js";
import { on, send } from "./channel.js";

const TRIES = 300; // ten a second
const ENOUGH = 30; // until what is not there is taken to be out of sight

let known = null; // the open tabs that Python knows of; null before it has said which to open
let wanted = []; // tabs that are to be opened as soon as they are there
let tries = 0; // left
let chosen = false; // a person has opened a tab of this page

const all = () => [...document.querySelectorAll("[role=tab]")];
const nameOf = (tab) => tab.textContent.trim().toLowerCase();
const find = (name) => all().find((tab) => nameOf(tab) === name);
const isOpen = (name) => find(name)?.getAttribute("aria-selected") === "true";
const names = () => rows().filter(({ id }) => id.startsWith("tab-")).map(({ id }) => id.slice(4));

// By a key, for the viewer lets a tab be dragged and hears no click.
function press(name) {
  find(name)?.dispatchEvent(new KeyboardEvent("keydown", { key: "Enter", code: "Enter", bubbles: true }));
}

/** Open the tab with this name, at once or as soon as it is there. */
export function openTab(name) {
  seekAll([name]);
}

function seekAll(those) {
  [wanted, tries] = [those, TRIES];
  seek();
}

// The viewer's own tabs come after the page, and the first is opened again as more come; some may be out of sight.
function seek() {
  const each = names();
  if (each.length) wanted = wanted.filter((name) => each.includes(name));
  const complete = (each.length && each.every(find)) || tries < TRIES - ENOUGH;
  if ((complete && wanted.every(isOpen)) || !tries--) wanted = [];
  else for (const name of wanted) if (!isOpen(name)) press(name);
}

function check() {
  if (wanted.length) seek();
  else report();
}

function report() {
  const open = names().filter(isOpen).join();
  if (known === null || !open || open === known) return;
  known = open;
  send("tab", open);
}

// Who has opened a tab before Python had its say keeps it.
function restore(told) {
  const first = known === null;
  known = told;
  if (!(first && chosen)) seekAll(told.split(","));
}

function touched(event) {
  if (!event.isTrusted || !event.target.closest?.("[role=tab]")) return;
  [wanted, chosen] = [[], true];
}

export function start() {
  on("tab", restore);
  setInterval(check, 100);
  window.addEventListener("pointerdown", touched, { capture: true });
  window.addEventListener("keydown", touched, { capture: true });
  watchActions(() => {
    for (const name of names()) does(`tab-${name}`, () => openTab(name));
  });
}
