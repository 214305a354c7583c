// The palette: every action by its name. Type a few letters, choose with the arrows, Enter does it.

import { does, perform, refusalOf, rows } from "./actions.js";
import { dialog } from "./dialog.js";

const MOST = 60;
const input = document.createElement("input");
const list = document.createElement("ul");
let found = [];
let at = 0;

/** How well a row fits what was typed: smaller is better, −1 is not at all. */
export function fitness(row, typed) {
  const words = typed.toLowerCase().split(/\s+/).filter(Boolean);
  const text = `${row.words} ${row.group}`.toLowerCase();
  if (!words.every((word) => text.includes(word))) return -1;
  if (!words.length) return 0;
  if (row.words.toLowerCase().startsWith(words[0])) return 0;
  return new RegExp(`\\b${words[0].replace(/[^\p{L}\p{N}]/gu, "\\$&")}`, "u").test(row.words.toLowerCase()) ? 1 : 2;
}

function search() {
  found = rows()
    .filter((row) => row.id !== "palette")
    .map((row) => [fitness(row, input.value), row])
    .filter(([fit]) => fit >= 0)
    .sort((a, b) => a[0] - b[0])
    .slice(0, MOST)
    .map(([, row]) => row);
  at = 0;
  list.replaceChildren(...found.map(option));
  if (!found.length) list.append(Object.assign(document.createElement("li"), { textContent: "No action is called that." }));
  mark();
}

function option(row, number) {
  const item = document.createElement("li");
  const words = document.createElement("span");
  const key = document.createElement("kbd");
  item.id = `scope-option-${number}`;
  item.setAttribute("role", "option");
  words.textContent = row.words;
  key.textContent = row.shown;
  item.append(words, ...(row.shown ? [key] : []));
  const refusal = refusalOf(row.id);
  if (refusal) {
    item.setAttribute("aria-disabled", "true");
    const why = document.createElement("small");
    why.textContent = refusal;
    item.append(why);
  }
  item.addEventListener("click", () => choose(number));
  return item;
}

function mark() {
  [...list.children].forEach((item, number) => item.setAttribute("aria-selected", String(number === at && found.length > 0)));
  input.setAttribute("aria-activedescendant", found.length ? `scope-option-${at}` : "");
  list.children[at]?.scrollIntoView({ block: "nearest" });
}

function choose(number) {
  const row = found[number];
  if (!row) return;
  palette.box.close();
  perform(row.id);
}

function pressed(event) {
  const steps = { ArrowDown: 1, ArrowUp: -1, PageDown: 8, PageUp: -8 };
  if (event.key in steps) {
    at = Math.min(Math.max(at + steps[event.key], 0), Math.max(found.length - 1, 0));
    mark();
  } else if (event.key === "Enter") choose(at);
  else if (event.key === "k" && (event.ctrlKey || event.metaKey)) palette.box.close();
  else return;
  event.preventDefault();
}

const palette = dialog("palette", "Find an action", (body) => {
  if (!list.isConnected) body.append(input, list);
  input.value = "";
  search();
});

export function start() {
  Object.assign(input, { type: "text", placeholder: "What do you want to do?", autocomplete: "off", spellcheck: false, autofocus: true });
  input.setAttribute("role", "combobox");
  input.setAttribute("aria-label", "Name of an action");
  input.setAttribute("aria-controls", "scope-options");
  input.setAttribute("aria-expanded", "true");
  list.id = "scope-options";
  list.setAttribute("role", "listbox");
  list.setAttribute("aria-label", "Actions");
  input.addEventListener("input", search);
  input.addEventListener("keydown", pressed);
  does("palette", palette.toggle);
}
