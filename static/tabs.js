// The tabs of the side bar, opened by actions called `tab-…` with their names.

import { does, rows, watchActions } from "./actions.js";

/** Open the tab with this name, if there is one: by a key, for the viewer lets a tab be dragged and hears no click. */
export function openTab(name) {
  const tab = [...document.querySelectorAll("[role=tab]")].find((each) => each.textContent.trim().toLowerCase() === name);
  tab?.dispatchEvent(new KeyboardEvent("keydown", { key: "Enter", code: "Enter", bubbles: true }));
}

export function start() {
  watchActions(() => {
    for (const { id } of rows()) if (id.startsWith("tab-")) does(id, () => openTab(id.slice(4)));
  });
}
