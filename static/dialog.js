// Windows of ours over the page: one at a time, modal, closed by Escape, by a click beside them, or by their key.

const made = [];

/** A dialog with a title; `fill(body)` is called each time before it opens. */
export function dialog(name, title, fill) {
  const box = document.createElement("dialog");
  const head = document.createElement("header");
  const heading = document.createElement("h2");
  const close = document.createElement("button");
  const body = document.createElement("div");
  box.className = `scope-dialog scope-${name}`;
  box.setAttribute("aria-label", title);
  heading.textContent = title;
  close.type = "button";
  close.className = "scope-close";
  close.textContent = "Close";
  close.addEventListener("click", () => box.close());
  box.addEventListener("click", (event) => event.target === box && box.close());
  head.append(heading, close);
  box.append(head, body);
  made.push(box);
  return {
    box,
    toggle() {
      if (box.open) return box.close();
      for (const other of made) other.close();
      if (!box.isConnected) document.body.append(box);
      fill(body);
      box.showModal();
    },
  };
}

/** The dialog that is open; undefined when none is. */
export const openDialog = () => made.find((box) => box.open);
