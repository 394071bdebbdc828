// Folds open for a link that leads into them and for paper; the contents say where the reader is.
function openTarget() {
  const place = location.hash && document.getElementById(decodeURIComponent(location.hash.slice(1)));
  if (!place) return;
  const folds = [...place.querySelectorAll(":scope > details"), place.closest("details")].filter(Boolean);
  if (!folds.length) return;
  for (const fold of folds) fold.open = true;
  place.scrollIntoView();
}
addEventListener("hashchange", openTarget);
openTarget();

const unfolded = new Set();
addEventListener("beforeprint", () => {
  for (const fold of document.querySelectorAll("details:not([open])")) {
    unfolded.add(fold);
    fold.open = true;
  }
});
addEventListener("afterprint", () => {
  for (const fold of unfolded) fold.open = false;
  unfolded.clear();
});

const links = [...document.querySelectorAll(".contents a")];
const parts = new Map(links.map((link) => [document.getElementById(link.hash.slice(1)), link]).filter(([p]) => p));
function mark() {
  const line = innerHeight * 0.3;
  const passed = [...parts.keys()].filter((part) => part.getBoundingClientRect().top <= line);
  const here = passed.sort((a, b) => b.getBoundingClientRect().top - a.getBoundingClientRect().top)[0];
  for (const [part, link] of parts) {
    if (part === here) link.setAttribute("aria-current", "true"); else link.removeAttribute("aria-current");
  }
}
let marking = 0;
addEventListener("scroll", () => {
  cancelAnimationFrame(marking);
  marking = requestAnimationFrame(mark);
}, { passive: true });
mark();
