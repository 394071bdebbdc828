// One frame everywhere: slider, buttons, list of episodes, readout.
function shown() {
  const on = (name) => part("show-" + name).checked;
  return { picture: on("picture"), detections: on("detections"), estimates: on("estimates"), truth: on("truth"), notes: true };
}

function drawViews(canvases, ep, i, image, show, second) {
  canvases.forEach((canvas, v) => {
    canvas.style.aspectRatio = `${ep.cameras[v].w} / ${ep.cameras[v].h}`;
    const [ctx, w, h] = surface(canvas), box = { x: 0, y: 0, w, h };
    drawView(ctx, box, ep, i, v, image, show);
    if (second && show.estimates) {
      drawEstimates(ctx, box, second.ep, second.i, v, { ...show, dashed: true });
      drawBadges(ctx, badges(second.ep, second.i).map((text) => `B: ${text}`), { y: h / 2, w, h });
    }
  });
}

function drawSpaces() {
  if (!now.source) return;
  const { source: ep, i } = now, second = secondAt(i), over = compared.mode === "over" ? second : null;
  drawSpace(space, ep, i, shown(), over);
  if (second && compared.mode === "beside") drawSpace(spaces[1], second.ep, second.i, shown());
}

function paint([image, other]) {
  const { source: ep, i } = now, show = shown(), frame = ep.frames[i], second = secondAt(i);
  const over = compared.mode === "over" ? second : null;
  drawViews(views, ep, i, image, show, over);
  if (second && compared.mode === "beside") drawViews([part("left-b"), part("right-b")], second.ep, second.i, other, show, null);
  drawSpaces();
  drawCurves(ep, i, second);
  const text = `frame ${frame}, ${ep.times[i].toFixed(2)} s`;
  part("frame").textContent = text;
  slider.setAttribute("aria-valuetext", [text, ...badges(ep, i)].join(", "));
  part("label").textContent = ep.label[i];
  readout(ep, i, second);
  for (const canvas of [...views, space, curves]) canvas.dataset.frame = String(frame);
  section.dataset.frame = String(frame);
  remember();
}

function readout(ep, i, second) {
  const figure = (v, digits) => v === undefined || Number.isNaN(v) ? "–" : v.toFixed(digits);
  for (let t = 0; t < 3; t++) {
    const row = part("readout").rows[t];
    const both = (name, digits) => [ep[name][t][i], ...(second ? [second.ep[name][t][second.i]] : [])].map((v) => figure(v, digits)).join(" | ");
    row.cells[1].textContent = STATUS[Number(ep.status[t][i])];
    const errors = [[ep, i], ...(second ? [[second.ep, second.i]] : [])].map(([of, n]) => {
      const error = document.createElement("span");
      error.textContent = figure(of.mm[t][n], 0);
      error.classList.toggle("bad", wrong(of, n, t));
      return error;
    });
    row.cells[2].replaceChildren(errors[0], ...(second ? [" | ", errors[1]] : []));
    row.cells[3].textContent = both("px", 1);
    row.cells[4].textContent = ep.merged[t][i] === "1" ? "merged" : "";
  }
  const doubts = [ep.exchange[i], ...(second ? [second.ep.exchange[second.i]] : [])];
  const stated = doubts.map((p) => p === undefined || Number.isNaN(p) ? "–" : `${(100 * p).toFixed(1)}\u00a0%`).join(" | ");
  part("doubt").textContent = doubts.every((p) => Number.isNaN(p)) ? "" : `Chance that the hands are exchanged, as the tracker states it: ${stated}`;
}

function listEvents(ep) {
  part("events").replaceChildren(...ep.events.map((event) => {
    const button = document.createElement("button"), back = event.kind === "recovered";
    button.type = "button";
    button.className = "chip " + event.kind;
    button.textContent = `${event.text}, ${back ? event.last : `${event.first}–${event.last}`}`;
    button.addEventListener("click", () => { stop(); go(ep.place.get(back ? event.last : event.first) ?? 0); });
    return button;
  }));
  part("no-events").hidden = ep.events.length > 0;
}

// A command in which lines end between words alone.
function showCommand(command) {
  part("command").replaceChildren(...command.split(" ").flatMap((word) => {
    const whole = document.createElement("span");
    whole.textContent = word;
    return [whole, " "];
  }));
}

// frame: null for the worst; other: key of the run to compare with, "" for the one of before.
async function load(key, frame, other = "") {
  stop();
  const mine = ++now.load, ep = await episode(key);
  if (mine !== now.load) return;
  Object.assign(now, { key, source: ep, i: ep.place.get(frame ?? worstOf(key)) ?? 0 });
  picker.value = key;
  slider.max = String(ep.frames.length - 1);
  const option = picker.selectedOptions[0];
  part("facts").textContent = option ? option.dataset.facts : "";
  if (part("command")) showCommand(option?.dataset.command ?? "");
  listEvents(ep);
  drawMarks(ep);
  const last = key.lastIndexOf("-");
  for (const canvas of spaces) canvas.setAttribute("aria-label", `Paths in 3-D, seed ${key.slice(last + 1)}; arrow keys turn, plus and minus zoom, 0 resets`);
  curves.setAttribute("aria-label", `3-D error and Err_acc of each frame; ${lanesInWords(ep) || "nothing merged, hidden or lost"}`);
  section.dataset.key = key;
  await offerRuns(key, other);
  await go(now.i);
}

function visit(key) {
  touched = true;
  load(key, null);
}

// The worst moment of an episode, as the page knows it.
const worstOf = (key) => Number(optionOf(key).dataset.worst);
function showWorst() {
  stop();
  go(now.source.place.get(worstOf(now.key)) ?? 0);
}
part("worst").addEventListener("click", showWorst);

const pictureB = (i) => {
  const second = compared.mode === "beside" ? secondAt(i) : null;
  return second ? picture(compared.key, second.ep.frames[second.i]) : null;
};
const { go, stop, toggle } = transport({
  count: () => now.source.frames.length,
  fps: () => (now.source.frames.length - 1) / (now.source.times.at(-1) - now.source.times[0]) || 1,
  pictureOf: (i) => Promise.all([picture(now.key, now.source.frames[i]), pictureB(i)]),
  paint,
});
const step = pickFrom(picker, visit);
