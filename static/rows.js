// Rows of tables that lead somewhere: a click on one is told to Python by its name and number.

import { send } from "./channel.js";

function clicked(event) {
  const row = event.target.closest?.("[data-row]");
  if (row) send("row", { name: row.dataset.row, number: Number(row.dataset.number) });
}

export function start() {
  document.addEventListener("click", clicked);
}
