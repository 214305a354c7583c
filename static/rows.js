// Rows of tables that lead somewhere, and buttons of actions, in texts of the panels: a click on a row is told to Python
// by its name and number, one on a button asks for its action. A button may stand in a row: it comes first.

import { perform } from "./actions.js";
import { send } from "./channel.js";

const find = (event) => event.target.closest?.("[data-row], [data-action]");

function act({ action, row, number }) {
  if (action) perform(action);
  else send("row", { name: row, number: Number(number) });
}

let pressed = null;

// A panel that is drawn anew between press and release takes its button along, and no click comes of it: what is there
// now counts, if it is the same.
function released(event) {
  const [before, now] = [pressed, find(event)];
  pressed = null;
  if (before && now && !before.isConnected && before.outerHTML === now.outerHTML) act(now.dataset);
}

export function start() {
  document.addEventListener("pointerdown", (event) => (pressed = find(event)));
  document.addEventListener("pointerup", released);
  document.addEventListener("click", (event) => find(event) && act(find(event).dataset));
}
