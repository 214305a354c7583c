// The guided tour: one card after the other, and an invitation for who has never taken it.

import { perform } from "./actions.js";
import { on } from "./channel.js";
import { layer } from "./overlay.js";
import { openTab } from "./tabs.js";

const TRIES = 50; // ten a second

const card = document.createElement("section");
let shown = -1;
let revealing = null;

function button(words, action, plain = true) {
  const made = document.createElement("button");
  made.type = "button";
  made.className = plain ? "scope-close" : "scope-close scope-strong";
  made.textContent = words;
  made.addEventListener("click", () => perform(action));
  return made;
}

function element(kind, text) {
  return Object.assign(document.createElement(kind), { textContent: text });
}

function invite() {
  card.replaceChildren(
    element("h2", "New here?"),
    element("p", "A tour of two minutes shows the map, one wrong decision in it, and how to mend that."),
    foot(button("No, thanks", "tour-end"), button("Take the tour", "tour", false)),
  );
}

function foot(...parts) {
  const row = document.createElement("footer");
  row.append(...parts);
  return row;
}

function show(tour) {
  card.hidden = !tour;
  card.classList.toggle("scope-invitation", Boolean(tour?.invitation)); // only who drives can take it
  if (!tour) shown = -1;
  else if (tour.invitation) invite();
  else {
    const last = tour.step === tour.steps - 1;
    const next = button(last ? "Finish" : tour.asks ? "Skip" : "Next", last ? "tour-end" : "tour-next", tour.asks);
    const back = button("Back", "tour-back");
    [next.disabled, back.disabled] = [tour.waiting, tour.waiting || tour.step === 0];
    const held = card.contains(document.activeElement);
    card.replaceChildren(
      element("h2", tour.title),
      element("p", tour.text),
      foot(element("span", `${tour.step + 1} of ${tour.steps}`), button("End", "tour-end"), back, next),
    );
    if (held) next.focus(); // who came by the keyboard goes on by it
    if (!tour.waiting && tour.step !== shown) {
      openTab(tour.tab);
      reveal(tour.rows);
    }
    shown = tour.waiting ? -1 : tour.step;
  }
}

// The rows that a card speaks of may be below the edge of their tab, which is filled a little after it is opened.
function reveal(rows, tries = TRIES) {
  clearTimeout(revealing);
  if (!rows || !tries) return;
  const [row, sentence = row] = document.querySelectorAll(`[data-row="${rows}"]`);
  for (const part of [row, sentence]) part?.scrollIntoView({ block: "nearest" });
  revealing = setTimeout(reveal, 100, rows, row?.checkVisibility() ? 0 : tries - 1);
}

// The viewer's notices come up in the same corner: below the card.
function makeRoom() {
  document.documentElement.style.setProperty("--scope-tour", `${card.offsetHeight}px`);
}

export function start() {
  card.className = "scope-tour scope-card";
  card.setAttribute("aria-label", "Guided tour");
  card.setAttribute("aria-live", "polite");
  card.hidden = true;
  layer.prepend(card); // the keyboard comes to it before all else
  on("tour", show);
  new ResizeObserver(makeRoom).observe(card);
}
