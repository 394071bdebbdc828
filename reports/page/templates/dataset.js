// The player of a data set: layers, labels, values and events of the frame of a sequence.
const [OCCLUDED, VISIBLE] = [1, 2];
const LEGENDS = {
  colour: [["what the cameras filmed"]],
  clean: [["before the sensor's noise and blur"]],
  depth: [["near to far: 0.5 m red, 4 m and more blue; dark: nothing", "ramp"]],
  amodal: [["the whole of each target: filled where it shows, striped where something hides it"]],
  classes: [["a colour a class; their names are in conventions.json"]],
  normals: [["red to the right, green up, blue towards the camera"]],
  flow: [
    ["the colour is the direction, bright from 40 px on; to the next frame, of the last one back", ""],
    ["hidden in the other frame", "#fa963c"], ["outside the other picture", "#50aaeb"],
  ],
  disparity: [["large red, small blue; dark: none. Rectified pair: boxes and keypoints are not drawn", "ramp"]],
  occlusion: [
    ["seen in the other view", "#5a5c60"], ["hidden in the other view", "#fa963c"],
    ["outside the other view", "#50aaeb"], ["no surface. Rectified pair: boxes and keypoints are not drawn", "#202226"],
  ],
};
// Of the keypoints of a hand: wrist to palm, palm to each tip. The body is of no target's colour.
const PALM = [[0, 1], ...[2, 3, 4, 5, 6].map((tip) => [1, tip])], BODY = "#f2f2f2";
const RAMP = "linear-gradient(90deg, #7a0403, #e8510b, #fabb39, #a4fc3c, #1ae4b6, #4686fb, #30123b)";
const picker = part("sequence");
const radios = [...section.querySelectorAll("input[name=layer]")];

const sequences = new Map();
function sequenceOf(key) {
  if (!sequences.has(key)) sequences.set(key, unpack("sequence-" + key).then(JSON.parse));
  return sequences.get(key);
}

const places = new Map();
function picture(key, layer, i) {
  const id = `pictures-${key}-${layer}`, holder = document.getElementById(id);
  if (!holder) return Promise.resolve(null);
  if (!places.has(id)) {
    let start = 0;
    places.set(id, holder.dataset.sizes.split(" ").map((size) => [start, start += Number(size)]));
  }
  return pictureAt(id + "@" + i, holder.textContent, places.get(id)[i]);
}

let layerNow = "colour";

function drawView(v, image, show) {
  const { source: sequence, i } = now, [width, height] = sequence.size[v];
  views[v].style.aspectRatio = `${width} / ${height}`;
  const [ctx, w, h] = surface(views[v]);
  ctx.fillStyle = GROUND; ctx.fillRect(0, 0, w, h);
  if (image) {
    const half = image.width / 2;
    ctx.imageSmoothingEnabled = !["seg", "classes", "occlusion"].includes(layerNow);
    ctx.drawImage(image, v * half, 0, half, half * height / width, 0, 0, w, h);
  }
  if (radios.find((r) => r.value === layerNow).dataset.rectified) return;
  const s = w / width, big = Math.max(0.6, Math.min(1.25, w / 420));
  // Pixel (0, 0) is a pixel's centre.
  const at = (x, y) => [(x + 0.5) * s, (y + 0.5) * s];
  for (let t = 0; t < 3; t++) {
    const whole = sequence.amodal_boxes[i][v][t], box = sequence.boxes[i][v][t];
    if (show.wholes && whole) {
      ctx.setLineDash([5, 4]);
      ctx.beginPath(); ctx.rect(whole[0] * s, whole[1] * s, whole[2] * s, whole[3] * s); strokeWithHalo(ctx, 1.2 * big, BRIGHT[t]);
      ctx.setLineDash([]);
    }
    if (show.boxes && box) {
      ctx.beginPath(); ctx.rect(box[0] * s, box[1] * s, box[2] * s, box[3] * s); strokeWithHalo(ctx, 1.6 * big, BRIGHT[t]);
      const spot = [Math.min(Math.max(box[0] * s + 3, 2), w - 12), Math.max(box[1] * s - 4, 12)];
      drawLetter(ctx, t, Math.round(13 * big), 'system-ui, "DejaVu Sans", sans-serif', ...spot);
    }
    if (show.points) drawPoints(ctx, sequence.keypoints[i][v][t], t > 0 ? PALM : [], BRIGHT[t], at, big);
  }
  if (show.joints) sequence.skeletons[i][v].forEach((points, k) => drawPoints(ctx, points, sequence.bones[k], k ? BRIGHT[k] : BODY, at, 0.7 * big));
}

function drawPoints(ctx, points, bones, colour, at, big) {
  const known = (p) => p && p[0] !== null && p[1] !== null && p[2] >= OCCLUDED;
  for (const [a, b] of bones) {
    const from = points[a], to = points[b];
    if (!known(from) || !known(to)) continue;
    ctx.beginPath(); ctx.moveTo(...at(from[0] / 10, from[1] / 10)); ctx.lineTo(...at(to[0] / 10, to[1] / 10));
    ctx.globalAlpha = 0.55; ctx.lineWidth = 1.1 * big; ctx.strokeStyle = colour; ctx.stroke(); ctx.globalAlpha = 1;
  }
  for (const p of points) {
    if (!known(p)) continue;
    ctx.beginPath(); ctx.arc(...at(p[0] / 10, p[1] / 10), (p[2] === VISIBLE ? 2.3 : 2.8) * big, 0, 2 * Math.PI);
    if (p[2] === VISIBLE) { ctx.lineWidth = 1.6; ctx.strokeStyle = HALO; ctx.stroke(); ctx.fillStyle = colour; ctx.fill(); }
    else strokeWithHalo(ctx, 1.2 * big, colour);
  }
}

// "person 2.1 % L, 1.9 % R; ..." of lists of [name, value] of both views.
function grouped(lists) {
  const values = new Map();
  lists.forEach((list, v) => list.forEach(([name, value]) => values.set(name, [...(values.get(name) ?? []), `${value} ${"LR"[v]}`.trim()])));
  return [...values].map(([name, texts]) => `${name} ${texts.join(", ")}`).join("; ");
}

function paint(image) {
  const { source: sequence, i } = now, on = (name) => part("show-" + name).checked;
  const show = { boxes: on("boxes"), wholes: on("wholes"), points: on("points"), joints: on("joints") };
  for (const v of [0, 1]) drawView(v, image, show);
  const text = `frame ${i}, ${(sequence.ms[i] / 1000).toFixed(2)} s`;
  part("frame").textContent = text;
  slider.setAttribute("aria-valuetext", text);
  const last = Math.max(1, sequence.ms.length - 1);
  part("lanes").style.setProperty("--at", `${100 * i / last}%`);
  const share = (v) => v === null ? "out of view" : `${(v / 10).toFixed(1)}\u00a0%`;
  for (let t = 0; t < 3; t++) {
    const by = grouped([0, 1].map((v) => sequence.occluders[i][v][t].map(([name, s]) => [name, `${(s / 10).toFixed(1)}\u00a0%`])));
    const merged = grouped([0, 1].map((v) => sequence.merged_with[i][v][t].map((name) => [name, ""])));
    const speed = sequence.speeds[i][t];
    const values = [
      sequence.positions[i][t].map((p) => p === null ? "–" : (p / 1e4).toFixed(3)).join(" / "), speed === null ? "–" : (speed / 1000).toFixed(2),
      share(sequence.visible[i][0][t]), share(sequence.visible[i][1][t]),
      [0, 1].map((v) => sequence.truncation[i][v][t] === null ? "–" : `${(sequence.truncation[i][v][t] / 10).toFixed(0)}\u00a0%`).join(" / "), by, merged,
    ];
    values.forEach((value, n) => { part("values").rows[t].cells[n + 1].textContent = value; });
  }
  for (const [v, canvas] of views.entries()) {
    canvas.setAttribute("aria-label", `${["left", "right"][v]} view, ${layerNow}, ${text}${sequence.arrived[i][v] ? "" : ", picture lost"}`);
  }
  section.dataset.layer = layerNow;
  section.dataset.key = now.key;
  section.dataset.frame = String(i);
}

function legend() {
  const entries = layerNow === "seg" ? now.source.legend.map(([colour, name]) => [name.replaceAll("_", " "), colour]) : LEGENDS[layerNow];
  part("legend").replaceChildren(...entries.map(([words, colour]) => {
    const span = document.createElement("span");
    if (colour) {
      const key = document.createElement("i");
      if (colour === "ramp") key.className = "ramp";
      key.style.background = colour === "ramp" ? RAMP : colour;
      span.append(key);
    }
    span.append(words);
    return span;
  }));
}

function lanes() {
  const { source: sequence } = now, last = Math.max(1, sequence.ms.length - 1);
  part("lanes").replaceChildren(...sequence.events.map((row) => {
    const lane = document.createElement("div"), name = document.createElement("b"), spans = document.createElement("div");
    lane.className = "lane " + row.kind;
    spans.className = "spans";
    name.textContent = row.text;
    for (const [from, to] of row.spans) {
      const bar = document.createElement("button");
      bar.type = "button";
      const words = `${row.text}, frame${from === to ? "" : "s"} ${from === to ? from : from + " to " + to}`;
      bar.title = words;
      bar.setAttribute("aria-label", words);
      bar.style.left = `min(${100 * from / last}%, 100% - 6px)`;
      bar.style.width = `${100 * (to - from) / last}%`;
      bar.addEventListener("click", () => { stop(); go(from); });
      spans.append(bar);
    }
    lane.append(name, spans);
    return lane;
  }));
  part("no-events").hidden = sequence.events.length > 0;
}

function choose(layer) {
  const radio = radios.find((r) => r.value === layer);
  if (!radio || radio.disabled) return;
  radio.checked = true;
  layerNow = layer;
  legend();
  go(now.i);
}

async function load(key, frame) {
  stop();
  const sequence = await sequenceOf(key);
  Object.assign(now, { key, source: sequence, i: 0 });
  picker.value = key;
  slider.max = String(sequence.ms.length - 1);
  for (const radio of radios) radio.disabled = !document.getElementById(`pictures-${key}-${radio.value}`);
  if (radios.find((r) => r.value === layerNow).disabled) layerNow = "colour";
  radios.find((r) => r.value === layerNow).checked = true;
  const some = sequence.ms.length < sequence.sequence_frames ? `${sequence.ms.length} of ${sequence.sequence_frames}` : String(sequence.sequence_frames);
  part("facts").textContent = `${some} frames, ${sequence.fps} a second`;
  legend();
  lanes();
  await go(frame);
}

function visit(key) {
  history.replaceState(null, "", "#seq=" + key);
  load(key, 0);
}

const { go, stop, toggle } = transport({
  count: () => now.source.ms.length,
  fps: () => now.source.fps,
  pictureOf: (i) => picture(now.key, layerNow, i),
  paint,
});
const step = pickFrom(picker, visit);
for (const radio of radios) radio.addEventListener("change", () => choose(radio.value));

addEventListener("keydown", (event) => {
  if (!now.source || event.ctrlKey || event.metaKey || event.altKey) return;
  const at = event.target, typed = at instanceof HTMLSelectElement, pressed = at instanceof HTMLButtonElement || at.type === "checkbox";
  // A slider, a radio group and a table that scrolls have arrows of their own.
  const own = typed || at === slider || at.type === "radio" || at.closest?.(".scroll");
  const far = event.shiftKey ? 10 : 1, radio = /^[0-9]$/.test(event.key) && radios[(Number(event.key) + 9) % 10];
  const moves = { ArrowLeft: now.i - far, ArrowRight: now.i + far, Home: 0, End: now.source.ms.length - 1 };
  if (event.key in moves && (!own || (at === slider && event.shiftKey))) { stop(); go(moves[event.key]); }
  else if (event.key === " " && !typed && !pressed) toggle();
  else if (radio && !typed) choose(radio.value);
  else if (/^[pn]$/i.test(event.key) && !typed) step(event.key.toLowerCase() === "n" ? 1 : -1);
  else return;
  event.preventDefault();
});

// The address says which sequence and frame: #seq=2@14.
function follow() {
  const asked = /^#seq=(\d+)(?:@(\d+))?$/.exec(location.hash);
  return asked && document.getElementById("sequence-" + asked[1]) ? load(asked[1], Number(asked[2] ?? 0)) : null;
}
addEventListener("hashchange", follow);

start(async () => {
  await (follow() || load(picker.value, 0));
  html.dataset.ready = "yes";
});
