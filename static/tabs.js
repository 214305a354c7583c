// The tabs of the side bar: opened by actions called `tab-…` with their names, and as they were on the last visit.

import { does, rows, watchActions } from "./actions.js";
import { on, send } from "./channel.js";

/** Open the tab with this name, and say whether there is one: by a key, for the viewer lets a tab be dragged and hears no click. */
export function openTab(name) {
  const tab = [...document.querySelectorAll("[role=tab]")].find((each) => each.textContent.trim().toLowerCase() === name);
  return tab?.dispatchEvent(new KeyboardEvent("keydown", { key: "Enter", code: "Enter", bubbles: true })) !== undefined;
}

let known = null; // the open tabs that Python knows of; null before it has said which to open

const openTabs = () => [...document.querySelectorAll("[role=tab][aria-selected=true]")].map((tab) => tab.textContent.trim().toLowerCase());

function report() {
  const names = openTabs().filter((name) => rows().some(({ id }) => id === `tab-${name}`)).join();
  if (known === null || !names || names === known) return;
  known = names;
  send("tab", names);
}

// The viewer's own tabs come after the page, and the first is opened again as more come: keep trying for a while.
function restore(names, tries = 40) {
  known = null;
  const wanted = names.split(",").filter(Boolean);
  if (!wanted.length || openTabs().includes(wanted.at(-1)) || !tries) {
    known = names;
  } else {
    wanted.forEach(openTab);
    setTimeout(() => restore(names, tries - 1), 100);
  }
}

export function start() {
  on("tab", (names) => restore(names));
  setInterval(report, 300);
  watchActions(() => {
    for (const { id } of rows()) if (id.startsWith("tab-")) does(id, () => openTab(id.slice(4)));
  });
}
