// One frame everywhere: slider, buttons, list of episodes, address, readout.
const picker = part("episode");

function shown() {
  const on = (name) => part("show-" + name).checked;
  return { picture: on("picture"), detections: on("detections"), estimates: on("estimates"), truth: on("truth"), notes: true };
}

function paint(image) {
  const { source: ep, i } = now, show = shown(), frame = ep.frames[i];
  views.forEach((canvas, v) => {
    canvas.style.aspectRatio = `${ep.cameras[v].w} / ${ep.cameras[v].h}`;
    const [ctx, w, h] = surface(canvas);
    drawView(ctx, { x: 0, y: 0, w, h }, ep, i, v, image, show);
  });
  drawSpace(ep, i, show);
  drawCurves(ep, i);
  const text = `frame ${frame}, ${ep.times[i].toFixed(2)} s`;
  part("frame").textContent = text;
  const doubt = ep.exchange[i];
  const stated = Number.isNaN(doubt) ? "" : `hands exchanged, as stated: ${(100 * doubt).toFixed(1)} %`;
  part("label").textContent = [ep.label[i].replaceAll(";", ", "), stated].filter(Boolean).join(" · ");
  slider.setAttribute("aria-valuetext", text);
  for (let t = 0; t < 3; t++) {
    const row = part("readout").rows[t];
    const figure = (v, digits) => Number.isNaN(v) ? "–" : v.toFixed(digits);
    row.cells[1].textContent = STATUS[Number(ep.status[t][i])];
    row.cells[2].textContent = figure(ep.mm[t][i], 0);
    row.cells[3].textContent = figure(ep.px[t][i], 1);
    row.cells[4].textContent = ep.merged[t][i] === "1" ? "merged" : "";
  }
  for (const canvas of [...views, space, curves]) canvas.dataset.frame = String(frame);
  section.dataset.frame = String(frame);
}

async function load(key, frame) {
  stop();
  const ep = await episode(key);
  Object.assign(now, { key, source: ep, i: 0 });
  picker.value = key;
  slider.max = String(ep.frames.length - 1);
  const option = picker.selectedOptions[0];
  part("facts").textContent = option ? option.dataset.facts : "";
  if (part("command")) part("command").textContent = option?.dataset.command ?? "";
  const events = part("events");
  events.replaceChildren(...ep.events.map((event) => {
    const button = document.createElement("button");
    button.type = "button";
    button.className = "chip " + event.kind;
    button.textContent = `${event.text}, ${event.first}–${event.last}`;
    button.addEventListener("click", () => { stop(); go(ep.place.get(event.first) ?? 0); });
    return button;
  }));
  part("no-events").hidden = ep.events.length > 0;
  const marks = part("marks");
  marks.replaceChildren(...ep.events.filter((e) => e.kind !== "recovered").map((event) => {
    const mark = document.createElement("i");
    const last = Math.max(1, ep.frames.length - 1);
    const from = ep.place.get(event.first) ?? 0, to = ep.place.get(event.last) ?? last;
    mark.className = event.kind === "swap" ? "swap" : NAMES[event.target];
    mark.style.left = `${100 * from / last}%`;
    mark.style.width = `max(3px, ${100 * (to - from) / last}%)`;
    return mark;
  }));
  const last = key.lastIndexOf("-");
  space.setAttribute("aria-label", `Paths in 3-D, seed ${key.slice(last + 1)}; arrow keys turn, plus and minus zoom, 0 resets`);
  section.dataset.key = key;
  await go(frame === null ? 0 : ep.place.get(frame) ?? 0);
}

// The address says what is shown, so that "back" leads back to where a link was followed.
function visit(key) {
  history.replaceState(null, "", "#play=" + key);
  load(key, null);
}
function follow(scroll) {
  const asked = /^#play=([\d-]+)(?:@(\d+))?$/.exec(location.hash);
  if (!asked || !document.getElementById("episode-" + asked[1])) return null;
  if (scroll) section.scrollIntoView({ behavior: still.matches ? "auto" : "smooth" });
  return load(asked[1], asked[2] === undefined ? null : Number(asked[2]));
}
addEventListener("hashchange", () => follow(true));

const { go, stop } = transport({
  count: () => now.source.frames.length,
  fps: () => (now.source.frames.length - 1) / (now.source.times.at(-1) - now.source.times[0]) || 1,
  pictureOf: (i) => picture(now.key, now.source.frames[i]),
  paint,
});
pickFrom(picker, visit);

function repaint() {
  readTheme();
  if (now.source) go(now.i);
}
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", repaint);
// Paper is white: curves and 3-D view are drawn again for it.
for (const [name, paper] of [["beforeprint", true], ["afterprint", false]]) {
  addEventListener(name, () => {
    html.classList.toggle("paper", paper);
    readTheme();
    if (now.source) { drawSpace(now.source, now.i, shown()); drawCurves(now.source, now.i); }
  });
}

start(async () => {
  readTheme();
  // Opens on the worst moment, unless the address names another.
  const [key, frame] = section.dataset.opening.split("@");
  await (follow(true) || load(key, Number(frame)));
  html.dataset.ready = "yes";
  for (const figure of document.querySelectorAll("[data-film]")) await loopFilm(figure);
  for (const canvas of document.querySelectorAll("canvas[data-thumb]")) await thumb(canvas);
  html.dataset.thumbs = "yes";
});
