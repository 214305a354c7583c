// What stands in the middle of the map while there is no map.

import { perform, titleOf, watchActions } from "./actions.js";
import { on } from "./channel.js";
import { layer } from "./overlay.js";

export function start() {
  const card = document.createElement("div");
  const title = document.createElement("h2");
  const text = document.createElement("p");
  const button = document.createElement("button");
  let action = "";
  card.className = "scope-stage scope-card";
  card.setAttribute("role", "status");
  button.type = "button";
  button.className = "scope-close";
  button.addEventListener("click", () => perform(action));
  card.append(title, text, button);
  card.hidden = true;
  layer.append(card);
  const name = () => (button.textContent = titleOf(action));
  watchActions(name);
  on("stage", (stage) => {
    card.hidden = !stage;
    if (!stage) return;
    card.dataset.kind = stage.kind;
    title.textContent = stage.title;
    text.textContent = stage.text;
    action = stage.action;
    button.hidden = !action;
    name();
  });
}
