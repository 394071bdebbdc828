// Shared by the player of a run and that of a data set.
const html = document.documentElement;
const section = document.getElementById("player");
if (!section) return;
const part = (name) => section.querySelector(`[data-part="${name}"]`);
const LETTERS = ["H", "R", "L"];
// Colours on pictures, whatever the theme: drawn on a dark ground with a dark halo.
const BRIGHT = ["#ff8f5e", "#3fdca0", "#74bdff"], HALO = "rgba(8, 10, 14, .85)", GROUND = "#232a33";
const still = matchMedia("(prefers-reduced-motion: reduce)");
const slider = part("slider"), play = part("play"), speed = part("speed");
const views = [part("left"), part("right")];

// The picture at bytes start to end of a text of WebP files in base64; the last sixty are kept.
const pictures = new Map();
function pictureAt(name, text, [start, end]) {
  if (!pictures.has(name)) {
    const first = Math.floor(start / 3);
    const letters = atob(text.slice(first * 4, Math.ceil(end / 3) * 4));
    const bytes = Uint8Array.from({ length: end - start }, (_, i) => letters.charCodeAt(start - first * 3 + i));
    pictures.set(name, createImageBitmap(new Blob([bytes], { type: "image/webp" })).catch(() => null));
    if (pictures.size > 60) pictures.delete(pictures.keys().next().value);
  }
  return pictures.get(name);
}

// The cleared canvas in CSS pixels, sharp on any screen.
function surface(canvas) {
  const dense = Math.max(1, Math.min(3, devicePixelRatio || 1));
  const w = canvas.clientWidth || canvas.width, h = canvas.clientHeight || canvas.height;
  if (canvas.width !== Math.round(w * dense) || canvas.height !== Math.round(h * dense)) {
    canvas.width = Math.round(w * dense);
    canvas.height = Math.round(h * dense);
  }
  const ctx = canvas.getContext("2d");
  ctx.setTransform(dense, 0, 0, dense, 0, 0);
  ctx.clearRect(0, 0, w, h);
  return [ctx, w, h];
}

function strokeWithHalo(ctx, width, colour) {
  ctx.lineWidth = width + 2; ctx.strokeStyle = HALO; ctx.stroke();
  ctx.lineWidth = width; ctx.strokeStyle = colour; ctx.stroke();
}

function drawLetter(ctx, t, size, font, x, y, mark = "") {
  ctx.font = `600 ${size}px ${font}`; ctx.textAlign = "left"; ctx.lineJoin = "round";
  ctx.lineWidth = 3; ctx.strokeStyle = HALO; ctx.strokeText(LETTERS[t] + mark, x, y);
  ctx.fillStyle = BRIGHT[t]; ctx.fillText(LETTERS[t] + mark, x, y);
}

// What is shown. source: the decoded episode or sequence; i: position of its frame.
const now = { key: "", source: null, i: 0, timer: 0, turn: 0, load: 0 };

// Moves of the slider. count() frames, fps() of them a second; pictureOf(i) is a promise; paint(image).
function transport({ count, fps, pictureOf, paint }) {
  async function go(i) {
    if (!now.source) return;
    now.i = Math.min(count() - 1, Math.max(0, i));
    slider.value = String(now.i);
    const mine = ++now.turn;
    const image = await pictureOf(now.i);
    if (mine === now.turn) paint(image);
    if (now.timer) pictureOf((now.i + 1) % count());
  }

  function stop() {
    clearTimeout(now.timer);
    now.timer = 0;
    play.textContent = "Play";
    play.setAttribute("aria-pressed", "false");
  }

  function tick() {
    const next = now.i + 1 < count() ? now.i + 1 : 0;
    const wait = 1000 / fps() / Number(speed.value);
    now.timer = setTimeout(() => { go(next).then(() => now.timer && tick()); }, wait);
  }

  function toggle() {
    if (now.timer || !now.source) { stop(); return; }
    if (now.i === count() - 1) go(0);
    play.textContent = "Pause";
    play.setAttribute("aria-pressed", "true");
    tick();
  }

  play.addEventListener("click", toggle);
  slider.addEventListener("input", () => { stop(); go(Number(slider.value)); });
  for (const button of section.querySelectorAll("[data-by]")) {
    button.addEventListener("click", () => { stop(); go(now.i + Number(button.dataset.by)); });
  }
  for (const box of section.querySelectorAll(".toggles input")) box.addEventListener("change", () => go(now.i));
  let resizing = 0;
  new ResizeObserver(() => {
    cancelAnimationFrame(resizing);
    resizing = requestAnimationFrame(() => { if (now.source) go(now.i); });
  }).observe(section);
  return { go, stop, toggle };
}

// The list of episodes or sequences; visit(key) shows one. Returns the step to the next or last.
function pickFrom(picker, visit) {
  const step = (by) => {
    const all = picker.options.length;
    visit(picker.options[(picker.selectedIndex + by + all) % all].value);
  };
  picker.addEventListener("change", () => visit(picker.value));
  for (const button of section.querySelectorAll("[data-next]")) {
    button.addEventListener("click", () => step(Number(button.dataset.next)));
  }
  return step;
}

async function start(show) {
  try {
    if (typeof DecompressionStream === "undefined") throw new Error("The player needs a browser of 2023 or later.");
    await show();
  } catch (error) {
    part("facts").textContent = error.message;
    html.dataset.ready = "failed";
  }
}
