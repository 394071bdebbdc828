// What went wrong in a frame, and the marks for it: badges, lines to the truth, shapes of the targets.
const DETECTED = "#ffe45c", WRONG = "#ff3b30", WRONG_MM = 100;
const WORDS = ["head", "right hand", "left hand"];
const FAULTS = ["swap", "capture", "lost"];

// The failures that go on in frame i.
const faults = (ep, i) => ep.events.filter((e) => FAULTS.includes(e.kind) && e.first <= ep.frames[i] && ep.frames[i] <= e.last);
const exchanged = (ep, i) => faults(ep, i).some((e) => e.kind === "swap");
// The line from an estimate to its own truth is thick and red where it is far off, or the hands are exchanged.
const wrong = (ep, i, t) => ep.mm[t][i] > WRONG_MM || (t > 0 && exchanged(ep, i));

// The failures of a frame in words, "left and right exchanged" first.
function badges(ep, i) {
  const order = (e) => FAULTS.indexOf(e.kind);
  return faults(ep, i).sort((a, b) => order(a) - order(b)).map((e) => e.kind === "swap" ? "left and right exchanged" : e.text);
}

let ink = {};
function readTheme() {
  const style = getComputedStyle(html);
  const name = (n) => style.getPropertyValue("--" + n).trim();
  ink = {
    text: name("ink"), soft: name("soft"), grid: name("grid"), line: name("line"), merged: name("merged"), hidden: name("hidden"),
    accent: name("accent"), paper: name("paper"), bad: name("bad"), targets: NAMES.map(name),
    font: getComputedStyle(document.body).fontFamily,
  };
}

function shape(ctx, target, x, y, r) {
  ctx.beginPath();
  if (target === 0) ctx.arc(x, y, r, 0, 2 * Math.PI);
  else if (target === 1) ctx.rect(x - r * 0.88, y - r * 0.88, r * 1.76, r * 1.76);
  else {
    ctx.moveTo(x, y - r * 1.2); ctx.lineTo(x + r * 1.2, y); ctx.lineTo(x, y + r * 1.2); ctx.lineTo(x - r * 1.2, y);
    ctx.closePath();
  }
}

// Badges in the top left corner of a box, or one for all where it is small.
function drawBadges(ctx, words, { y: top, w, h }) {
  const size = Math.round(Math.max(10, Math.min(13, w / 24))), tall = size + 7;
  ctx.font = `600 ${size}px ${ink.font}`; ctx.textAlign = "left";
  const most = w < 260 ? 1 : Math.max(1, Math.floor(h / 2 / (tall + 3)));
  const rest = words.length - most, lines = words.slice(0, most);
  if (rest > 0) lines[most - 1] += ` +${rest}`;
  let y = top + 5;
  for (const text of lines) {
    const rows = rowsOf(ctx, text, w - 20), wide = Math.max(...rows.map((row) => ctx.measureText(row).width));
    ctx.fillStyle = "#c4161c"; ctx.fillRect(5, y, wide + 10, tall + (rows.length - 1) * (size + 2));
    ctx.fillStyle = "#fff";
    rows.forEach((row, n) => ctx.fillText(row, 10, y + size + 2 + n * (size + 2)));
    y += tall + (rows.length - 1) * (size + 2) + 3;
  }
}

// The rows of a text that is broken between words.
function rowsOf(ctx, text, room) {
  const rows = [];
  for (const word of text.split(" ")) {
    const longer = rows.length ? `${rows.at(-1)} ${word}` : "";
    if (longer && ctx.measureText(longer).width <= room) rows[rows.length - 1] = longer;
    else rows.push(word);
  }
  return rows;
}

function nice(least) {
  const power = 10 ** Math.floor(Math.log10(least));
  return [1, 2, 5, 10].map((f) => f * power).find((f) => f >= least * 0.999);
}
