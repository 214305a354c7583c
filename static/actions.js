// The table of actions, as Python gives it: which key means which, what is refused just now, and what is done here.

import { on, send } from "./channel.js";

let table = { about: [], actions: [] };
let refused = {};
let byKey = new Map();
let byId = new Map();
const own = new Map(); // what the page's script does by itself, by id
const watchers = [];
let performed = "";

/** All rows of the table, and the sentences above it in the help sheet. */
export const rows = () => table.actions;
export const about = () => table.about;

/** The row that a key means; undefined for a key without a meaning. */
export const actionOf = (key) => byKey.get(key);

/** Why an action cannot be done now; undefined if it can. */
export const refusalOf = (id) => refused[id];

/** Do an action: here if it is the script's own, else ask Python. */
export function perform(id) {
  if (own.has(id)) own.get(id)();
  else if (byId.has(id)) send("action", id);
}

/** The script itself does the action of this id. */
export function does(id, act) {
  own.set(id, act);
}

/** What a button for an action says: its words and its key. */
export function titleOf(id, words) {
  const row = byId.get(id);
  if (!row) return words ?? id;
  return row.shown ? `${words ?? row.words} (${row.shown})` : (words ?? row.words);
}

/** Call `watcher()` whenever the table or what is refused has changed. */
export function watchActions(watcher) {
  watchers.push(watcher);
}

const tell = () => watchers.forEach((watcher) => watcher());

export function start() {
  on("actions", (value) => {
    table = value;
    byId = new Map(table.actions.map((row) => [row.id, row]));
    byKey = new Map(table.actions.flatMap((row) => row.keys.map((key) => [key, row])));
    tell();
  });
  on("refusals", (value) => {
    refused = value;
    tell();
  });
  on("perform", ({ action, number }) => {
    if (number === performed) return; // said again after a lost connection
    performed = number;
    own.get(action)?.();
  });
}
