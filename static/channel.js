// The two-way channel: values from Python arrive by topic, events go back over the viewer's own connection.

const listeners = new Map();
const latest = new Map();

/** The viewer's internals, where it exposes them to its own tests; undefined until the canvas is up. */
export const viewer = () => window.__viserMutable;

/** Call `listener` with the latest value of a topic, now if there is one, and with every later one. */
export function on(topic, listener) {
  listeners.set(topic, [...(listeners.get(topic) ?? []), listener]);
  if (latest.has(topic)) listener(latest.get(topic));
}

function receive(topic, value) {
  latest.set(topic, value);
  for (const listener of listeners.get(topic) ?? []) {
    try {
      listener(value);
    } catch (error) {
      console.error(topic, error); // whatever comes next must still arrive
    }
  }
}

/** Tell Python what a person did. */
export function send(topic, value) {
  viewer()?.sendMessage({ type: "PageEvent", topic, value: JSON.stringify(value) });
}

/** Whether somebody answers: what the viewer sends with says so of itself where nobody does. */
export function connected() {
  const sender = viewer()?.sendMessage;
  return Boolean(sender) && !String(sender).includes("is not connected");
}

/** Take over from the stub that collected values while this module was loading. */
export function open() {
  const { waiting } = window.splinescope;
  window.splinescope = { receive, latest };
  for (const [topic, value] of waiting) receive(topic, value);
}
