// Questions: what an action has to know first. One field, Enter answers; where there are choices, a click does too.

import { does, refusalOf, rows, watchActions } from "./actions.js";
import { send } from "./channel.js";
import { dialog } from "./dialog.js";

const made = new Map();

function field(row, answer) {
  const form = document.createElement("form");
  const label = document.createElement("label");
  const input = document.createElement("input");
  const go = Object.assign(document.createElement("button"), { type: "submit", className: "scope-close scope-strong", textContent: "Go" });
  Object.assign(input, { type: "text", placeholder: row.asks.example, autocomplete: "off", spellcheck: false, autofocus: true });
  label.append(row.asks.label, input);
  form.append(label, go);
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    if (input.value.trim()) answer(input.value.trim());
  });
  return form;
}

function choices(row, answer) {
  const list = document.createElement("p");
  list.className = "scope-choices";
  for (const choice of row.asks.choices) {
    const button = Object.assign(document.createElement("button"), { type: "button", className: "scope-close", textContent: choice });
    button.addEventListener("click", () => answer(choice));
    list.append(button);
  }
  return list;
}

function question(row) {
  const box = dialog("question", row.words, (body) => {
    const answer = (text) => {
      box.box.close();
      send("answer", { action: row.id, text });
    };
    body.replaceChildren(field(row, answer), ...(row.asks.choices.length ? [choices(row, answer)] : []));
  });
  return box;
}

// What cannot be done now is not asked: Python says why.
function ask(row) {
  if (refusalOf(row.id)) send("action", row.id);
  else made.get(row.id).toggle();
}

export function start() {
  watchActions(() => {
    for (const row of rows().filter((each) => each.asks && !made.has(each.id))) {
      made.set(row.id, question(row));
      does(row.id, () => ask(row));
    }
  });
}
