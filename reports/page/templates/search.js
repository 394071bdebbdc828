// The search box: whatever has data-find, listed while the reader writes; Enter goes there.
const box = document.getElementById("search");
if (!box) return;
const list = document.getElementById("search-results");
const none = list.nextElementSibling;
const MOST = 40;
// Kinds in the order of the list.
const KINDS = ["scenario", "failure", "episode", "event"];
const places = [...document.querySelectorAll("[data-find]")].map((element) => ({
  text: element.dataset.find, words: element.dataset.find.toLowerCase().replaceAll("_", " "), kind: element.dataset.kind,
  address: element.getAttribute("href") || "#" + element.id,
})).sort((a, b) => KINDS.indexOf(a.kind) - KINDS.indexOf(b.kind));

function close() {
  list.hidden = none.hidden = true;
  box.setAttribute("aria-expanded", "false");
  box.removeAttribute("aria-activedescendant");
}

function choose(option) {
  for (const other of list.children) other.setAttribute("aria-selected", String(other === option));
  box.setAttribute("aria-activedescendant", option.id);
  option.scrollIntoView({ block: "nearest" });
}

function go(option) {
  close();
  box.blur();
  // The same address again is no change, and still leads there.
  if (location.hash === option.dataset.address) dispatchEvent(new HashChangeEvent("hashchange"));
  location.hash = option.dataset.address;
}

function find() {
  const asked = box.value.toLowerCase().replaceAll("_", " ").split(/\s+/).filter(Boolean);
  if (!asked.length) { close(); return; }
  const hits = places.filter((place) => asked.every((word) => place.words.includes(word)));
  list.replaceChildren(...hits.slice(0, MOST).map((place, n) => {
    const option = document.createElement("li");
    option.id = `search-result-${n}`;
    option.setAttribute("role", "option");
    option.dataset.address = place.address;
    const kind = document.createElement("small");
    kind.textContent = place.kind;
    option.append(place.text, kind);
    option.addEventListener("pointerdown", (event) => { event.preventDefault(); go(option); });
    return option;
  }));
  list.hidden = !hits.length;
  none.hidden = hits.length > 0;
  none.textContent = hits.length ? "" : "Nothing of that name.";
  box.setAttribute("aria-expanded", String(hits.length > 0));
  if (hits.length) choose(list.firstElementChild); else box.removeAttribute("aria-activedescendant");
}

box.addEventListener("input", find);
box.addEventListener("focus", find);
box.addEventListener("blur", close);
box.addEventListener("keydown", (event) => {
  event.stopPropagation();  // the keys of the player are elsewhere
  if (event.key === "Escape") { box.value = ""; close(); return; }
  if (list.hidden) return;
  const chosen = list.querySelector('[aria-selected="true"]');
  if (event.key === "Enter") { event.preventDefault(); go(chosen); return; }
  const next = { ArrowDown: chosen.nextElementSibling ?? list.firstElementChild, ArrowUp: chosen.previousElementSibling ?? list.lastElementChild }[event.key];
  if (next) { event.preventDefault(); choose(next); }
});
