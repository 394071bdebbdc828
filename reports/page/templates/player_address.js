// The address names what is shown: #play=KEY@FRAME, with another run +KEY,over or +KEY,beside.
const ADDRESS = /^#play=([\d-]+)(?:@(\d+))?(?:\+([\d-]+),(over|beside))?$/;

function address() {
  const other = compared.ep ? `+${compared.key},${compared.mode}` : "";
  return `#play=${now.key}@${now.source.frames[now.i]}${other}`;
}

// Written when the reader has moved, and not while it plays: browsers limit how often.
let touched = false, writing = 0;
for (const kind of ["click", "input", "pointerdown"]) section.addEventListener(kind, () => { touched = true; }, true);
function remember() {
  clearTimeout(writing);
  if (!touched || now.timer) return;
  // Not over an address that the reader went to since, by the back button, and that is yet to be followed.
  const from = location.hash;
  writing = setTimeout(() => { if (location.hash === from) history.replaceState(null, "", address()); }, 250);
}

function follow(scroll) {
  const asked = ADDRESS.exec(location.hash);
  if (!asked || !document.getElementById("episode-" + asked[1])) return null;
  clearTimeout(writing);
  if (scroll) section.scrollIntoView({ behavior: still.matches ? "auto" : "smooth" });
  if (asked[3]) compared.mode = asked[4];
  return load(asked[1], asked[2] === undefined ? null : Number(asked[2]), asked[3] ?? "");
}
addEventListener("hashchange", () => follow(true));

async function copyLink() {
  const link = location.href.split("#")[0] + address();
  history.replaceState(null, "", address());
  try {
    await navigator.clipboard.writeText(link);
  } catch {
    // Without a permission, or in a page that is not trusted: by way of a field.
    const field = document.createElement("textarea");
    field.value = link; field.style.position = "fixed"; field.style.opacity = "0";
    document.body.append(field);
    field.select();
    document.execCommand("copy");
    field.remove();
  }
  part("copied").textContent = `link to frame ${now.source.frames[now.i]} copied`;
  setTimeout(() => { part("copied").textContent = ""; }, 3000);
}
part("link").addEventListener("click", copyLink);
