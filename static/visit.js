// Visits: the page says hello with its name and what stands behind its address, learns whether it drives or watches,
// and says so when nobody answers any more.

import { perform, titleOf, watchActions } from "./actions.js";
import { standpoint } from "./camera.js";
import { connected, on, send, viewer } from "./channel.js";
import { dialog } from "./dialog.js";
import { layer } from "./overlay.js";

const NAME = "splinescope.name";
const OURS = ["scan", "layers", "camera", "colour", "token"]; // what a link says once and no reload says again
const GUARDED = ["click", "pointerdown", "mousedown", "keydown", "input", "change"];
const WORKING = "button, input, select, textarea, label, [role=button], [role=switch], [role=option], [role=combobox]";

let sender = null;
let query = location.search; // until the viewer has answered: what is said while it is not connected is lost
let driving = true;
let copied = "";
let link = "";

const banner = document.createElement("div");
const told = document.createElement("div");
const lost = document.createElement("div");

/** Whether this page may change what all see. */
export const drives = () => driving;

function name() {
  const known = sessionStorage.getItem(NAME) ?? Math.random().toString(36).slice(2);
  sessionStorage.setItem(NAME, known);
  return known;
}

function hello() {
  const internals = viewer();
  lost.hidden = sender === null || connected();
  if (!connected() || internals.sendMessage === sender) return;
  const back = sender !== null; // it goes on where it was, whatever others have looked at meanwhile
  sender = internals.sendMessage;
  send("hello", { name: name(), query, back, place: back ? standpoint() : null });
  const words = new URLSearchParams(location.search);
  for (const each of OURS) words.delete(each);
  history.replaceState(null, "", location.pathname + (words.size ? `?${words}` : ""));
}

function role(value) {
  query = "";
  driving = value.driving;
  document.documentElement.classList.toggle("scope-watching", !driving);
  banner.hidden = driving && !value.watchers;
  const button = document.createElement("button");
  button.type = "button";
  button.className = "scope-close";
  button.textContent = titleOf("take-control", "Take control");
  button.addEventListener("click", () => perform("take-control"));
  const others = value.watchers === 1 ? "One other page watches." : `${value.watchers} other pages watch.`;
  banner.replaceChildren(driving ? others : "You are watching: another page drives. ", ...(driving ? [] : [button]));
}

// What the viewer's own widgets would send is not this page's to change.
function guard(event) {
  if (driving || !event.isTrusted || event.key === "Tab") return;
  const { target } = event;
  if (!target.closest || target.closest("#splinescope, .scope-dialog, [role=tab]") || !target.closest(WORKING)) return;
  event.preventDefault();
  event.stopImmediatePropagation();
  banner.classList.remove("scope-blink");
  requestAnimationFrame(() => banner.classList.add("scope-blink"));
}

const shown = dialog("link", "Link to this moment", (body) => {
  const field = Object.assign(document.createElement("input"), { type: "text", value: link, readOnly: true });
  field.setAttribute("aria-label", "Link");
  body.replaceChildren(field);
  setTimeout(() => field.select());
});

function say(sentence) {
  told.textContent = sentence;
  told.classList.remove("scope-fading");
  requestAnimationFrame(() => told.classList.add("scope-fading"));
}

async function copy({ query, number }) {
  if (number === copied) return; // said again after a lost connection
  copied = number;
  link = `${location.origin}${location.pathname}?${query}`;
  try {
    await navigator.clipboard.writeText(link);
    say("The link is copied.");
  } catch {
    shown.toggle(); // a page that is not on this machine may not use the clipboard
  }
}

export function start() {
  banner.className = "scope-role scope-card";
  banner.setAttribute("role", "status");
  banner.hidden = true;
  told.className = "scope-told scope-card";
  told.setAttribute("role", "status");
  lost.className = "scope-role scope-lost scope-card";
  lost.setAttribute("role", "alert");
  lost.textContent = "The connection is lost: SplineScope has ended or is out of reach. This page goes on when it is back.";
  lost.hidden = true;
  layer.append(lost, banner, told);
  on("role", role);
  on("copy", copy);
  watchActions(() => banner.querySelector("button")?.replaceChildren(titleOf("take-control", "Take control")));
  for (const kind of GUARDED) window.addEventListener(kind, guard, { capture: true });
  setInterval(hello, 100);
  hello();
}
