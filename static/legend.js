// The legend: what hue, line and glyph say. It can be folded away, and remembers that.

import { does } from "./actions.js";
import { on } from "./channel.js";
import { layer } from "./overlay.js";

const KEY = "splinescope.legend";

function entry({ label, svg }) {
  const item = document.createElement("li");
  item.innerHTML = svg; // drawn by our own server from its palette
  item.append(label);
  return item;
}

function section({ title, entries }) {
  const part = document.createElement("section");
  const heading = document.createElement("h3");
  const list = document.createElement("ul");
  heading.textContent = title;
  list.append(...entries.map(entry));
  part.append(heading, list);
  return part;
}

export function start() {
  const legend = document.createElement("details");
  const title = document.createElement("summary");
  const body = document.createElement("div");
  legend.className = "scope-legend scope-card";
  title.textContent = "Legend";
  legend.append(title, body);
  legend.open = localStorage.getItem(KEY) === "open";
  legend.addEventListener("toggle", () => localStorage.setItem(KEY, legend.open ? "open" : "folded"));
  layer.append(legend);
  on("legend", (sections) => {
    body.replaceChildren(...sections.map(section));
    legend.hidden = sections.length === 0;
  });
  does("legend", () => (legend.open = !legend.open));
  legend.hidden = true;
}
