// The help sheet: what the page shows, and every key by its group.

import { about, does, rows } from "./actions.js";
import { dialog } from "./dialog.js";

function keys(group, title) {
  const part = document.createElement("section");
  const heading = document.createElement("h3");
  const list = document.createElement("dl");
  heading.textContent = title;
  for (const row of group) {
    const key = document.createElement("dt");
    const words = document.createElement("dd");
    key.append(Object.assign(document.createElement("kbd"), { textContent: row.shown }));
    words.textContent = row.words;
    list.append(key, words);
  }
  part.append(heading, list);
  return part;
}

function fill(body) {
  const sentences = about().map((text) => Object.assign(document.createElement("p"), { textContent: text }));
  const columns = document.createElement("div");
  const shown = rows().filter((row) => row.shown);
  const titles = [...new Set(shown.map((row) => row.group))];
  columns.className = "scope-columns";
  columns.append(...titles.map((title) => keys(shown.filter((row) => row.group === title), title)));
  body.replaceChildren(...sentences, columns);
}

export function start() {
  does("help", dialog("help", "Keys and help", fill).toggle);
}
