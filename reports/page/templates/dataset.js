"use strict";
(() => {
  const section = document.getElementById("player");
  const html = document.documentElement;
  const part = (name) => section.querySelector(`[data-part="${name}"]`);
  const LETTERS = ["H", "R", "L"];
  // On pictures, whatever the theme: with a dark halo.
  const BRIGHT = ["#ff8f5e", "#3fdca0", "#74bdff"], HALO = "rgba(8, 10, 14, .85)", GROUND = "#232a33";
  const [OCCLUDED, VISIBLE] = [1, 2];
  const WORDS = {
    colour: [["what the cameras filmed"]],
    clean: [["before the sensor's noise and blur"]],
    depth: [["near to far: 0.5 m red, 4 m and more blue; dark: nothing", "ramp"]],
    amodal: [["the whole of each target: filled where it shows, striped where something hides it"]],
    disparity: [["large red, small blue; dark: none. Rectified pair: boxes and keypoints are not drawn", "ramp"]],
    occlusion: [
      ["seen in the other view", "#5a5c60"], ["hidden in the other view", "#fa963c"],
      ["outside the other view", "#50aaeb"], ["no surface. Rectified pair: boxes and keypoints are not drawn", "#202226"],
    ],
  };
  const RAMP = "linear-gradient(90deg, #7a0403, #e8510b, #fabb39, #a4fc3c, #1ae4b6, #4686fb, #30123b)";
  const picker = part("sequence"), slider = part("slider"), play = part("play"), speed = part("speed");
  const views = [part("left"), part("right")];
  const radios = [...section.querySelectorAll("input[name=layer]")];

  // --- data ------------------------------------------------------------------------------------
  async function unpack(id) {
    const bytes = Uint8Array.from(atob(document.getElementById(id).textContent), (c) => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return JSON.parse(await new Response(stream).text());
  }

  const clips = new Map();
  function clipOf(key) {
    if (!clips.has(key)) clips.set(key, unpack("clip-" + key));
    return clips.get(key);
  }

  const places = new Map(), pictures = new Map();
  function picture(key, layer, i) {
    const id = `pictures-${key}-${layer}`, holder = document.getElementById(id);
    if (!holder) return Promise.resolve(null);
    if (!places.has(id)) {
      let start = 0;
      places.set(id, holder.dataset.sizes.split(" ").map((size) => [start, start += Number(size)]));
    }
    const name = id + "@" + i;
    if (!pictures.has(name)) {
      const [start, end] = places.get(id)[i];
      const first = Math.floor(start / 3);
      const letters = atob(holder.textContent.slice(first * 4, Math.ceil(end / 3) * 4));
      const bytes = Uint8Array.from({ length: end - start }, (_, n) => letters.charCodeAt(start - first * 3 + n));
      pictures.set(name, createImageBitmap(new Blob([bytes], { type: "image/webp" })).catch(() => null));
      if (pictures.size > 60) pictures.delete(pictures.keys().next().value);
    }
    return pictures.get(name);
  }

  // --- drawing ---------------------------------------------------------------------------------
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

  function twice(ctx, width, colour) {
    ctx.lineWidth = width + 2; ctx.strokeStyle = HALO; ctx.stroke();
    ctx.lineWidth = width; ctx.strokeStyle = colour; ctx.stroke();
  }

  function drawView(v, image, show) {
    const { clip, i } = now, [width, height] = clip.size[v];
    views[v].style.aspectRatio = `${width} / ${height}`;
    const [ctx, w, h] = surface(views[v]);
    ctx.fillStyle = GROUND; ctx.fillRect(0, 0, w, h);
    if (image) {
      const half = image.width / 2;
      ctx.imageSmoothingEnabled = now.layer !== "seg" && now.layer !== "occlusion";
      ctx.drawImage(image, v * half, 0, half, half * height / width, 0, 0, w, h);
    }
    if (radios.find((r) => r.value === now.layer).dataset.rectified) return;
    const s = w / width, big = Math.max(0.6, Math.min(1.25, w / 420));
    // Pixel (0, 0) is a pixel's centre.
    const at = (x, y) => [(x + 0.5) * s, (y + 0.5) * s];
    for (let t = 0; t < 3; t++) {
      const whole = clip.wholes[i][v][t], box = clip.boxes[i][v][t];
      if (show.wholes && whole) {
        ctx.setLineDash([5, 4]);
        ctx.beginPath(); ctx.rect(whole[0] * s, whole[1] * s, whole[2] * s, whole[3] * s); twice(ctx, 1.2 * big, BRIGHT[t]);
        ctx.setLineDash([]);
      }
      if (show.boxes && box) {
        ctx.beginPath(); ctx.rect(box[0] * s, box[1] * s, box[2] * s, box[3] * s); twice(ctx, 1.6 * big, BRIGHT[t]);
        ctx.font = `600 ${Math.round(13 * big)}px system-ui, "DejaVu Sans", sans-serif`; ctx.textAlign = "left"; ctx.lineJoin = "round";
        const spot = [Math.min(Math.max(box[0] * s + 3, 2), w - 12), Math.max(box[1] * s - 4, 12)];
        ctx.lineWidth = 3; ctx.strokeStyle = HALO; ctx.strokeText(LETTERS[t], ...spot);
        ctx.fillStyle = BRIGHT[t]; ctx.fillText(LETTERS[t], ...spot);
      }
      if (show.points) drawPoints(ctx, clip.points[i][v][t], BRIGHT[t], at, big, t > 0);
    }
  }

  function drawPoints(ctx, points, colour, at, big, hand) {
    const there = (p) => p && p[0] !== null && p[1] !== null && p[2] >= OCCLUDED;
    // A hand: wrist to palm, palm to each tip.
    for (let n = 1; hand && n < points.length; n++) {
      const from = points[n === 1 ? 0 : 1];
      if (!there(from) || !there(points[n])) continue;
      ctx.beginPath(); ctx.moveTo(...at(from[0] / 10, from[1] / 10)); ctx.lineTo(...at(points[n][0] / 10, points[n][1] / 10));
      ctx.globalAlpha = 0.55; ctx.lineWidth = 1.1 * big; ctx.strokeStyle = colour; ctx.stroke(); ctx.globalAlpha = 1;
    }
    for (const p of points) {
      if (!there(p)) continue;
      ctx.beginPath(); ctx.arc(...at(p[0] / 10, p[1] / 10), (p[2] === VISIBLE ? 2.3 : 2.8) * big, 0, 2 * Math.PI);
      if (p[2] === VISIBLE) { ctx.lineWidth = 1.6; ctx.strokeStyle = HALO; ctx.stroke(); ctx.fillStyle = colour; ctx.fill(); }
      else twice(ctx, 1.2 * big, colour);
    }
  }

  // --- one frame everywhere --------------------------------------------------------------------
  const now = { key: "", clip: null, layer: "colour", i: 0, timer: 0, turn: 0 };

  async function go(i) {
    const { clip, key, layer } = now;
    if (!clip) return;
    now.i = Math.min(clip.ms.length - 1, Math.max(0, i));
    slider.value = String(now.i);
    const mine = ++now.turn;
    const image = await picture(key, layer, now.i);
    if (mine === now.turn) paint(image);
    if (now.timer) picture(key, layer, (now.i + 1) % clip.ms.length);
  }

  // "person 2.1 % L, 1.9 % R; ..." of lists of [name, value] of both views.
  function grouped(seen) {
    const found = new Map();
    seen.forEach((list, v) => list.forEach(([name, value]) => found.set(name, [...(found.get(name) ?? []), `${value} ${"LR"[v]}`.trim()])));
    return [...found].map(([name, values]) => `${name} ${values.join(", ")}`).join("; ");
  }

  function paint(image) {
    const { clip, i } = now, on = (name) => part("show-" + name).checked;
    const show = { boxes: on("boxes"), wholes: on("wholes"), points: on("points") };
    for (const v of [0, 1]) drawView(v, image, show);
    const words = `frame ${i}, ${(clip.ms[i] / 1000).toFixed(2)} s`;
    part("frame").textContent = words;
    slider.setAttribute("aria-valuetext", words);
    const last = Math.max(1, clip.ms.length - 1);
    part("lanes").style.setProperty("--at", `${100 * i / last}%`);
    const share = (v) => v === null ? "out of view" : `${(v / 10).toFixed(1)} %`;
    for (let t = 0; t < 3; t++) {
      const by = grouped([0, 1].map((v) => clip.by[i][v][t].map(([name, s]) => [name, `${(s / 10).toFixed(1)} %`])));
      const merged = grouped([0, 1].map((v) => clip.with[i][v][t].map((name) => [name, ""])));
      const speed = clip.speeds[i][t];
      const values = [
        clip.places[i][t].map((p) => p === null ? "–" : (p / 1e4).toFixed(3)).join(" / "), speed === null ? "–" : (speed / 1000).toFixed(2),
        share(clip.shown[i][0][t]), share(clip.shown[i][1][t]),
        [0, 1].map((v) => clip.cut[i][v][t] === null ? "–" : `${(clip.cut[i][v][t] / 10).toFixed(0)} %`).join(" / "), by, merged,
      ];
      values.forEach((value, n) => { part("values").rows[t].cells[n + 1].textContent = value; });
    }
    for (const [v, canvas] of views.entries()) {
      canvas.setAttribute("aria-label", `${["left", "right"][v]} view, ${now.layer}, ${words}${clip.came[i][v] ? "" : ", picture lost"}`);
    }
    section.dataset.layer = now.layer;
    section.dataset.key = now.key;
    section.dataset.frame = String(i);
  }

  function legend() {
    const entries = now.layer === "seg" ? now.clip.legend.map(([colour, name]) => [name.replaceAll("_", " "), colour]) : WORDS[now.layer];
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
    const { clip } = now, last = Math.max(1, clip.ms.length - 1);
    part("lanes").replaceChildren(...clip.events.map((row) => {
      const lane = document.createElement("div"), name = document.createElement("b"), spans = document.createElement("div");
      lane.className = "lane " + row.kind;
      spans.className = "spans";
      name.textContent = row.words;
      for (const [from, to] of row.spans) {
        const bar = document.createElement("button");
        bar.type = "button";
        const words = `${row.words}, frame${from === to ? "" : "s"} ${from === to ? from : from + " to " + to}`;
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
    part("no-events").hidden = clip.events.length > 0;
  }

  function choose(layer) {
    const radio = radios.find((r) => r.value === layer);
    if (!radio || radio.disabled) return;
    radio.checked = true;
    now.layer = layer;
    legend();
    go(now.i);
  }

  async function load(key, frame) {
    stop();
    const clip = await clipOf(key);
    Object.assign(now, { key, clip, i: 0 });
    picker.value = key;
    slider.max = String(clip.ms.length - 1);
    for (const radio of radios) radio.disabled = !document.getElementById(`pictures-${key}-${radio.value}`);
    if (radios.find((r) => r.value === now.layer).disabled) now.layer = "colour";
    radios.find((r) => r.value === now.layer).checked = true;
    const some = clip.ms.length < clip.all ? `${clip.ms.length} of ${clip.all}` : String(clip.all);
    part("facts").textContent = `${some} frames, ${clip.fps} a second`;
    legend();
    lanes();
    await go(frame);
  }

  function stop() {
    clearTimeout(now.timer);
    now.timer = 0;
    play.textContent = "Play";
    play.setAttribute("aria-pressed", "false");
  }

  function tick() {
    const next = now.i + 1 < now.clip.ms.length ? now.i + 1 : 0;
    const wait = 1000 / now.clip.fps / Number(speed.value);
    now.timer = setTimeout(() => { go(next).then(() => now.timer && tick()); }, wait);
  }

  function toggle() {
    if (now.timer || !now.clip) { stop(); return; }
    if (now.i === now.clip.ms.length - 1) go(0);
    play.textContent = "Pause";
    play.setAttribute("aria-pressed", "true");
    tick();
  }

  function visit(key) {
    history.replaceState(null, "", "#seq=" + key);
    load(key, 0);
  }

  function step(by) {
    const all = picker.options.length;
    visit(picker.options[(picker.selectedIndex + by + all) % all].value);
  }

  play.addEventListener("click", toggle);
  slider.addEventListener("input", () => { stop(); go(Number(slider.value)); });
  picker.addEventListener("change", () => visit(picker.value));
  for (const button of section.querySelectorAll("[data-by]")) {
    button.addEventListener("click", () => { stop(); go(now.i + Number(button.dataset.by)); });
  }
  for (const button of section.querySelectorAll("[data-next]")) button.addEventListener("click", () => step(Number(button.dataset.next)));
  for (const radio of radios) radio.addEventListener("change", () => choose(radio.value));
  for (const box of section.querySelectorAll(".toggles input")) box.addEventListener("change", () => go(now.i));

  addEventListener("keydown", (event) => {
    if (!now.clip || event.ctrlKey || event.metaKey || event.altKey) return;
    const at = event.target, typed = at instanceof HTMLSelectElement, pressed = at instanceof HTMLButtonElement || at.type === "checkbox";
    // A slider, a radio group and a table that scrolls have arrows of their own.
    const own = typed || at === slider || at.type === "radio" || at.closest?.(".scroll");
    const far = event.shiftKey ? 10 : 1;
    const moves = { ArrowLeft: now.i - far, ArrowRight: now.i + far, Home: 0, End: now.clip.ms.length - 1 };
    if (event.key in moves && (!own || (at === slider && event.shiftKey))) { stop(); go(moves[event.key]); }
    else if (event.key === " " && !typed && !pressed) toggle();
    else if (/^[1-9]$/.test(event.key) && !typed && radios[Number(event.key) - 1]) choose(radios[Number(event.key) - 1].value);
    else if (/^[pn]$/i.test(event.key) && !typed) step(event.key.toLowerCase() === "n" ? 1 : -1);
    else return;
    event.preventDefault();
  });

  // The address says which sequence and frame: #seq=2@14.
  function follow() {
    const asked = /^#seq=(\d+)(?:@(\d+))?$/.exec(location.hash);
    return asked && document.getElementById("clip-" + asked[1]) ? load(asked[1], Number(asked[2] ?? 0)) : null;
  }
  addEventListener("hashchange", follow);
  let resizing = 0;
  new ResizeObserver(() => {
    cancelAnimationFrame(resizing);
    resizing = requestAnimationFrame(() => { if (now.clip) go(now.i); });
  }).observe(section);

  (async () => {
    if (typeof DecompressionStream === "undefined") throw new Error("The player needs a browser of 2023 or later.");
    await (follow() || load(picker.value, 0));
    html.dataset.ready = "yes";
  })().catch((error) => {
    part("facts").textContent = error.message;
    html.dataset.ready = "failed";
  });
})();
