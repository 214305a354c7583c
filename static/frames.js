// When the map is drawn. The viewer takes in what Python says just before it draws, and so draws what was there before
// once more, first; without a graphics card that takes longer than all the rest. Here it is taken in as it comes, and what
// is for our script alone draws nothing.

import { viewer } from "./channel.js";

const FOR_THE_SCRIPT = "RunJavascriptMessage";
let followed = null;

function follow(internals) {
  const { messageQueue } = internals;
  const takeIn = () => messageQueue.length && internals.getRenderRequestState === "ready" && internals.drainMessageQueue?.();
  let draw = internals.requestRender;
  const request = () => {
    const unseen = messageQueue.length > 0 && messageQueue.every(({ type }) => type === FOR_THE_SCRIPT);
    if (messageQueue.length) queueMicrotask(takeIn); // not in the middle of what asks for a picture
    if (!unseen) draw();
  };
  Object.defineProperty(internals, "requestRender", { configurable: true, get: () => request, set: (made) => (draw = made) });
  followed = internals;
}

/** Take care of the viewer's drawing, as soon as there is a viewer. */
export function start() {
  setInterval(() => viewer() && viewer() !== followed && follow(viewer()), 250);
}
