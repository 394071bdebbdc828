// Keys that work anywhere on the page, but not while somebody types, nor in an open dialogue.
const BOXES = ["picture", "detections", "estimates", "truth"];

function keysBusy(event) {
  if (event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey || !part("keys").checked) return true;
  const at = event.target instanceof Element ? event.target : document.body;
  if (at.closest("textarea, select, dialog[open], [contenteditable]")) return true;
  const type = at instanceof HTMLInputElement ? at.type : "";
  if (type && !["range", "checkbox", "radio", "button"].includes(type)) return true;
  // The browser's own keys of a button, a slider, a choice, a table that scrolls.
  if (event.key === " ") return Boolean(type && type !== "range") || Boolean(at.closest("button, summary"));
  if (/^(Arrow|Home|End)/.test(event.key) && !event.shiftKey) return type === "range" || type === "radio" || Boolean(at.closest(".scroll"));
  return false;
}

let sought = -Infinity; // when a key last began to scroll to the player [ms]

function onScreen() {
  if (performance.now() - sought < 1000) return true; // it is on its way
  const box = part("left").getBoundingClientRect();
  return box.bottom > 0 && box.top < innerHeight;
}

const mode = (to) => compareAs(compared.mode === to ? "alone" : to);
const jump = (by) => {
  const all = starts(now.source), next = by > 0 ? all.find((i) => i > now.i) : all.findLast((i) => i < now.i);
  if (next !== undefined) go(next);
};
const ACTIONS = {
  "[": () => jump(-1), "]": () => jump(1), w: showWorst, n: () => step(1), p: () => step(-1),
  v: () => lookFrom(look + 1), c: copyLink, o: () => mode("over"), b: () => mode("beside"), x: switchRuns,
};

addEventListener("keydown", (event) => {
  if (!now.source || keysBusy(event)) return;
  const far = event.shiftKey ? 10 : 1, last = now.source.frames.length - 1;
  const moves = { ArrowLeft: now.i - far, ArrowRight: now.i + far, Home: 0, End: last };
  const action = ACTIONS[event.key.toLowerCase()], box = /^[1-4]$/.test(event.key) && part("show-" + BOXES[event.key - 1]);
  touched = true;
  if (event.key in moves) {
    // Far from the player these scroll the page, as everywhere.
    if (/^(Home|End)$/.test(event.key) && !onScreen()) return;
    stop(); go(moves[event.key]);
  } else if (event.key === " ") toggle();
  else if (box) { box.checked = !box.checked; go(now.i); }
  else if (action) { if ("[]".includes(event.key)) stop(); action(); }
  else return;
  event.preventDefault();
  if (onScreen()) return;
  sought = performance.now();
  section.scrollIntoView({ behavior: still.matches ? "auto" : "smooth" });
});
