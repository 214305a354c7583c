// Rows of tables that lead somewhere, and buttons of actions, in texts of the panels: a click on a row is told to Python
// by its name and number, one on a button asks for its action. A button may stand in a row: it comes first.

import { perform } from "./actions.js";
import { send } from "./channel.js";

function clicked(event) {
  const found = event.target.closest?.("[data-row], [data-action]");
  if (found?.dataset.action) perform(found.dataset.action);
  else if (found) send("row", { name: found.dataset.row, number: Number(found.dataset.number) });
}

export function start() {
  document.addEventListener("click", clicked);
}
