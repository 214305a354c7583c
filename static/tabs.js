// The tabs of the side bar: opened by actions called `tab-…` with their names, and as they were on the last visit.

import { does, rows, watchActions } from "./actions.js";
import { on, send } from "./channel.js";

/** Open the tab with this name, if there is one: by a key, for the viewer lets a tab be dragged and hears no click. */
export function openTab(name) {
  const tab = [...document.querySelectorAll("[role=tab]")].find((each) => each.textContent.trim().toLowerCase() === name);
  tab?.dispatchEvent(new KeyboardEvent("keydown", { key: "Enter", code: "Enter", bubbles: true }));
}

let known = null; // the tab that Python knows of; null before it has said which one to open

function report() {
  const name = document.querySelector("[role=tab][aria-selected=true]")?.textContent.trim().toLowerCase();
  if (known === null || !name || name === known) return;
  known = name;
  send("tab", name);
}

// The viewer's own tabs come after the page: keep trying for a while.
function restore(name, tries = 40) {
  known = null;
  if (!name) known = "";
  else if (document.querySelector("[role=tab]")) {
    openTab(name);
    known = name;
  } else if (tries) setTimeout(() => restore(name, tries - 1), 100);
}

export function start() {
  on("tab", (name) => restore(name));
  setInterval(report, 300);
  watchActions(() => {
    for (const { id } of rows()) if (id.startsWith("tab-")) does(id, () => openTab(id.slice(4)));
  });
}
