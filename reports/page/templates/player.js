"use strict";
(() => {
  const section = document.getElementById("player");
  if (!section) return;
  const html = document.documentElement;
  const part = (name) => section.querySelector(`[data-part="${name}"]`);
  const NAMES = ["head", "right_hand", "left_hand"];
  const LABELS = ["head", "right hand", "left hand"];
  const LETTERS = ["H", "R", "L"];
  const STATUS = ["waiting", "tracked", "coasting", "lost"];
  const DASHES = [[], [7, 4], [2, 3]];
  // On pictures, whatever the theme: they are drawn on a dark ground with a dark halo.
  const BRIGHT = ["#ff8f5e", "#3fdca0", "#74bdff"];
  const SEEN = "#ffe45c", HALO = "rgba(8, 10, 14, .85)", GROUND = "#232a33";
  const picker = part("episode"), slider = part("slider"), play = part("play"), speed = part("speed");
  const views = [part("left"), part("right")], space = part("space"), curves = part("curves");
  const still = matchMedia("(prefers-reduced-motion: reduce)");

  // --- data ------------------------------------------------------------------------------------
  async function unpack(id) {
    const bytes = Uint8Array.from(atob(document.getElementById(id).textContent), (c) => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return JSON.parse(await new Response(stream).text());
  }

  function series(deltas, scale) {
    let last = 0;
    return Float64Array.from(deltas, (d) => d === null ? NaN : (last += d) * scale);
  }

  // Positions in metres as [target][axis][frame]; detections of a view as [frame] = list of ellipses.
  function decode(raw) {
    const points = (columns) => [0, 1, 2].map((t) => [0, 1, 2].map((a) => series(columns[3 * t + a], 1e-4)));
    const seen = raw.seen.map(({ n, v }) => {
      let next = 0;
      return [...n].map((many) => Array.from({ length: Number(many) }, () => {
        const at = next++;
        return [v[0][at] / 10, v[1][at] / 10, v[2][at] / 10, v[3][at] / 10, v[4][at] / 100];
      }));
    });
    const frames = [...series(raw.frames, 1)];
    let said = 0;
    return {
      ...raw, frames, seen, times: series(raw.ms, 1e-3), place: new Map(frames.map((f, i) => [f, i])),
      truth: points(raw.truth), said: points(raw.said),
      mm: raw.mm.map((d) => series(d, 0.1)), px: raw.px.map((d) => series(d, 0.1)),
      label: frames.map((_, i) => {
        while (said + 1 < raw.labels.length && raw.labels[said + 1][0] <= i) said += 1;
        return raw.labels.length && raw.labels[said][0] <= i ? raw.labels[said][1] : "";
      }),
    };
  }

  const episodes = new Map();
  function episode(key) {
    if (!episodes.has(key)) episodes.set(key, unpack("episode-" + key).then(decode));
    return episodes.get(key);
  }

  // Frame -> place of its bytes in the film's base64.
  const films = new Map();
  function film(key) {
    if (!films.has(key)) {
      const holder = document.getElementById("film-" + key);
      const places = new Map();
      let start = 0;
      for (const entry of holder ? holder.dataset.sizes.split(" ") : []) {
        const [frame, size] = entry.split(":").map(Number);
        places.set(frame, [start, start + size]);
        start += size;
      }
      films.set(key, { text: holder ? holder.textContent : "", places });
    }
    return films.get(key);
  }

  const pictures = new Map();
  function picture(key, frame) {
    const { text, places } = film(key);
    if (!places.has(frame)) return Promise.resolve(null);
    const name = key + "@" + frame;
    if (!pictures.has(name)) {
      const [start, end] = places.get(frame);
      const first = Math.floor(start / 3);
      const letters = atob(text.slice(first * 4, Math.ceil(end / 3) * 4));
      const bytes = Uint8Array.from({ length: end - start }, (_, i) => letters.charCodeAt(start - first * 3 + i));
      pictures.set(name, createImageBitmap(new Blob([bytes], { type: "image/webp" })).catch(() => null));
      if (pictures.size > 60) pictures.delete(pictures.keys().next().value);
    }
    return pictures.get(name);
  }

  // --- drawing ---------------------------------------------------------------------------------
  let ink = {};
  function readTheme() {
    const style = getComputedStyle(html);
    const name = (n) => style.getPropertyValue("--" + n).trim();
    ink = {
      text: name("ink"), soft: name("soft"), grid: name("grid"), line: name("line"), merged: name("merged"),
      accent: name("accent"), paper: name("paper"), targets: NAMES.map(name), font: getComputedStyle(document.body).fontFamily,
    };
  }

  // The canvas in CSS pixels, sharp on any screen.
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

  function shape(ctx, target, x, y, r) {
    ctx.beginPath();
    if (target === 0) ctx.arc(x, y, r, 0, 2 * Math.PI);
    else if (target === 1) ctx.rect(x - r * 0.88, y - r * 0.88, r * 1.76, r * 1.76);
    else {
      ctx.moveTo(x, y - r * 1.2); ctx.lineTo(x + r * 1.2, y); ctx.lineTo(x, y + r * 1.2); ctx.lineTo(x - r * 1.2, y);
      ctx.closePath();
    }
  }

  function twice(ctx, width, colour) {
    ctx.lineWidth = width + 2; ctx.strokeStyle = HALO; ctx.stroke();
    ctx.lineWidth = width; ctx.strokeStyle = colour; ctx.stroke();
  }

  function project(camera, points, i) {
    const [x, y, z] = points.map((axis) => axis[i]);
    const P = camera.P;
    const q = [0, 4, 8].map((r) => P[r] * x + P[r + 1] * y + P[r + 2] * z + P[r + 3]);
    return q[2] > 0 ? [q[0] / q[2], q[1] / q[2]] : null;
  }

  // One view of a frame into a box of the canvas; pixel (0, 0) is a pixel's centre.
  function drawView(ctx, box, ep, i, v, image, show) {
    const camera = ep.cameras[v];
    const part = box.part ?? { x: 0, y: 0, w: camera.w };
    const s = box.w / part.w;
    ctx.save();
    ctx.beginPath(); ctx.rect(box.x, box.y, box.w, box.h); ctx.clip();
    ctx.translate(box.x, box.y);
    ctx.fillStyle = GROUND; ctx.fillRect(0, 0, box.w, box.h);
    if (image && show.picture) {
      const w = image.width / 2, f = w / camera.w;
      ctx.drawImage(image, v * w + part.x * f, part.y * f, part.w * f, box.h / s * f, 0, 0, box.w, box.h);
    } else if (show.words) {
      ctx.fillStyle = "#98a3b3"; ctx.font = `12px ${ink.font}`; ctx.textAlign = "right";
      ctx.fillText(show.picture ? "no picture kept of this frame" : "picture switched off", box.w - 9, box.h - 9);
    }
    const big = Math.max(0.55, Math.min(1, box.w / 380));
    const at = (p) => [(p[0] + 0.5 - part.x) * s, (p[1] + 0.5 - part.y) * s];
    if (show.detections) {
      for (const [x, y, a, b, angle] of ep.seen[v][i]) {
        const [cx, cy] = at([x, y]);
        ctx.beginPath(); ctx.ellipse(cx, cy, a * s, b * s, angle, 0, 2 * Math.PI); twice(ctx, 1.4 * big, SEEN);
      }
    }
    for (let t = 0; t < 3 && show.truth; t++) {
      const p = project(camera, ep.truth[t], i);
      if (!p) continue;
      const [x, y] = at(p), r = 7 * big;
      ctx.beginPath(); ctx.moveTo(x - r, y); ctx.lineTo(x + r, y); ctx.moveTo(x, y - r); ctx.lineTo(x, y + r);
      twice(ctx, 2 * big, BRIGHT[t]);
    }
    for (let t = 0; t < 3 && show.estimates; t++) {
      const p = project(camera, ep.said[t], i);
      if (!p || Number.isNaN(p[0])) continue;
      const [x, y] = at(p), sure = ep.status[t][i] === "1";
      ctx.setLineDash(sure ? [] : [4, 3]);
      shape(ctx, t, x, y, 12 * big); twice(ctx, (sure ? 2.4 : 1.6) * big, BRIGHT[t]);
      ctx.setLineDash([]);
      ctx.font = `600 ${Math.round(13 * big)}px ${ink.font}`; ctx.textAlign = "left";
      const tx = Math.min(Math.max(x + 14 * big, 2), box.w - 14), ty = Math.min(Math.max(y - 10 * big, 13), box.h - 4);
      ctx.lineWidth = 3; ctx.strokeStyle = HALO; ctx.lineJoin = "round"; ctx.strokeText(LETTERS[t], tx, ty);
      ctx.fillStyle = BRIGHT[t]; ctx.fillText(LETTERS[t], tx, ty);
    }
    ctx.restore();
  }

  function nice(least) {
    const power = 10 ** Math.floor(Math.log10(least));
    return [1, 2, 5, 10].map((f) => f * power).find((f) => f >= least * 0.999);
  }

  // --- the 3-D view: an own small projection, so that it needs no WebGL ----------------------------
  const START = { yaw: -0.55, pitch: 0.42, zoom: 1 };
  const look = { ...START };

  function bounds(ep) {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (const target of ep.truth) {
      target.forEach((axis, a) => {
        for (const value of axis) { low[a] = Math.min(low[a], value); high[a] = Math.max(high[a], value); }
      });
    }
    return [low.map((l) => Math.floor((l - 0.05) * 10) / 10), high.map((h) => Math.ceil((h + 0.05) * 10) / 10)];
  }

  function drawSpace(ep, i, show) {
    const [ctx, w, h] = surface(space);
    const [low, high] = ep.bounds ??= bounds(ep);
    const middle = low.map((l, a) => (l + high[a]) / 2);
    const radius = Math.hypot(...low.map((l, a) => (high[a] - l) / 2));
    const [sy, cy, sp, cp] = [Math.sin(look.yaw), Math.cos(look.yaw), Math.sin(look.pitch), Math.cos(look.pitch)];
    // The viewer stands at yaw, pitch about the box; the cameras of the scene are at yaw 0.
    const flat = (x, y, z) => {
      const [a, b, c] = [x - middle[0], y - middle[1], z - middle[2]];
      const f = 1 / (1 - Math.min(0.8, ((a * cy + b * sy) * cp + c * sp) / (6 * radius)));
      return [(-a * sy + b * cy) * f, ((a * cy + b * sy) * sp - c * cp) * f];
    };
    const ends = [0, 1, 2, 3, 4, 5, 6, 7].map((n) => flat(...[1, 2, 4].map((bit, a) => n & bit ? high[a] : low[a])));
    const [from, to] = [0, 1].map((a) => ends.map((p) => p[a])).map((v) => [Math.min(...v), Math.max(...v)]);
    // Room for the numbers on the axes.
    const roomy = w > 250;
    const [side, above] = roomy ? [96, 74] : [44, 40];
    const scale = look.zoom * Math.min((w - side) / (from[1] - from[0]), (h - above) / (to[1] - to[0]));
    const spot = (x, y, z) => {
      const p = flat(x, y, z);
      return [w / 2 + (p[0] - (from[0] + from[1]) / 2) * scale, (h - 18) / 2 + (p[1] - (to[0] + to[1]) / 2) * scale];
    };
    const stroke = (from, to) => { ctx.beginPath(); ctx.moveTo(...spot(...from)); ctx.lineTo(...spot(...to)); ctx.stroke(); };
    ctx.font = `11px ${ink.font}`;
    ctx.lineWidth = 1; ctx.strokeStyle = ink.grid; ctx.fillStyle = ink.soft; ctx.textAlign = "center";
    const step = nice(Math.max(...high.map((v, a) => v - low[a])) / 5);
    const ticks = (a) => {
      const found = [];
      for (let n = Math.ceil(low[a] / step - 1e-6); n * step <= high[a] + 1e-6; n++) found.push(n * step);
      return found;
    };
    // The floor of the box, its numbers on the two edges that are nearer to the viewer.
    const ex = cy > 0 ? high[0] : low[0], ey = sy > 0 ? high[1] : low[1];
    const away = (value, edge, a) => edge + (edge === high[a] ? 1 : -1) * 0.15 * radius;
    for (const x of ticks(0)) {
      stroke([x, low[1], low[2]], [x, high[1], low[2]]);
      if (roomy) ctx.fillText(x.toFixed(1), ...spot(x, away(x, ey, 1), low[2]));
    }
    for (const y of ticks(1)) {
      stroke([low[0], y, low[2]], [high[0], y, low[2]]);
      if (roomy) ctx.fillText(y.toFixed(1), ...spot(away(y, ex, 0), y, low[2]));
    }
    // The upright at the corner that is farthest left on the screen.
    const corners = [[low[0], low[1]], [low[0], high[1]], [high[0], low[1]], [high[0], high[1]]];
    const [ux, uy] = corners.reduce((best, c) => spot(...c, low[2])[0] < spot(...best, low[2])[0] ? c : best);
    stroke([ux, uy, low[2]], [ux, uy, high[2]]);
    for (const z of ticks(2)) {
      const [x, y] = spot(ux, uy, z);
      ctx.textAlign = "right";
      if (roomy) ctx.fillText(z.toFixed(1), x - 5, y + 4);
    }
    ctx.textAlign = "center"; ctx.fillStyle = ink.text;
    const name = (words, [x, y]) => {
      const half = ctx.measureText(words).width / 2 + 3;
      ctx.fillText(words, Math.min(w - half, Math.max(half, x)), Math.min(h - 5, Math.max(12, y)));
    };
    name(roomy ? "x, to the cameras" : "x", spot(middle[0], ey + (ey === high[1] ? 1 : -1) * (roomy ? 0.5 : 0.15) * radius, low[2]));
    name(roomy ? "y, to the person’s left" : "y", spot(ex + (ex === high[0] ? 1 : -1) * (roomy ? 0.5 : 0.15) * radius, middle[1], low[2]));
    const top = spot(ux, uy, high[2]);
    name(roomy ? "z, up [m]" : "z", [top[0], top[1] - 8]);

    const far = (points, n) => [0, 1, 2].some((a) => points[a][n] < low[a] - radius || points[a][n] > high[a] + radius);
    const path = (points, first, last) => {
      ctx.beginPath();
      let down = false;
      for (let n = first; n <= last; n++) {
        if (Number.isNaN(points[0][n]) || far(points, n)) { down = false; continue; }
        const p = spot(points[0][n], points[1][n], points[2][n]);
        if (down) ctx.lineTo(...p); else ctx.moveTo(...p);
        down = true;
      }
      ctx.stroke();
    };
    ctx.lineJoin = "round";
    const last = ep.frames.length - 1;
    for (let t = 0; t < 3; t++) {
      ctx.strokeStyle = ink.targets[t];
      if (show.truth) { ctx.globalAlpha = 0.55; ctx.lineWidth = 1; path(ep.truth[t], 0, last); }
      if (show.estimates) {
        ctx.globalAlpha = 0.22; ctx.lineWidth = 2.5; path(ep.said[t], 0, last);
        ctx.globalAlpha = 1; ctx.lineWidth = 2.5; path(ep.said[t], Math.max(0, i - 12), i);
      }
      ctx.globalAlpha = 1;
    }
    for (let t = 0; t < 3; t++) {
      const here = (points) => spot(points[0][i], points[1][i], points[2][i]);
      const [tx, ty] = here(ep.truth[t]);
      ctx.strokeStyle = ctx.fillStyle = ink.targets[t]; ctx.lineWidth = 1.6;
      if (show.truth) {
        ctx.beginPath(); ctx.moveTo(tx - 6, ty); ctx.lineTo(tx + 6, ty); ctx.moveTo(tx, ty - 6); ctx.lineTo(tx, ty + 6); ctx.stroke();
      }
      if (!show.estimates || Number.isNaN(ep.said[t][0][i]) || far(ep.said[t], i)) continue;
      const [x, y] = here(ep.said[t]);
      ctx.beginPath(); ctx.moveTo(tx, ty); ctx.lineTo(x, y); ctx.stroke();
      shape(ctx, t, x, y, 5.5);
      if (ep.status[t][i] === "1") ctx.fill(); else { ctx.fillStyle = ink.paper; ctx.fill(); ctx.stroke(); }
    }
  }

  let drag = null;
  space.addEventListener("pointerdown", (event) => {
    drag = [event.clientX, event.clientY];
    space.setPointerCapture(event.pointerId);
  });
  space.addEventListener("pointermove", (event) => {
    if (!drag) return;
    turn((drag[0] - event.clientX) * 0.009, (event.clientY - drag[1]) * 0.009);
    drag = [event.clientX, event.clientY];
  });
  for (const end of ["pointerup", "pointercancel"]) space.addEventListener(end, () => { drag = null; });

  function turn(yaw, pitch, zoom = 1) {
    look.yaw += yaw;
    look.pitch = Math.min(1.57, Math.max(-0.3, look.pitch + pitch));
    look.zoom = Math.min(5, Math.max(0.5, look.zoom * zoom));
    space.dataset.turn = `${look.yaw.toFixed(2)} ${look.pitch.toFixed(2)} ${look.zoom.toFixed(2)}`;
    if (now.ep) drawSpace(now.ep, now.i, shown());
  }
  space.addEventListener("keydown", (event) => {
    const turns = {
      ArrowLeft: [0.12, 0], ArrowRight: [-0.12, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1],
      "+": [0, 0, 1.15], "=": [0, 0, 1.15], "-": [0, 0, 1 / 1.15],
    };
    if (event.key === "0") Object.assign(look, START);
    const by = event.key === "0" ? [0, 0] : turns[event.key];
    if (!by) return;
    event.preventDefault();
    turn(...by);
  });
  for (const button of section.querySelectorAll("[data-look]")) {
    button.addEventListener("click", () => {
      const [yaw, pitch] = button.dataset.look.split(" ").map(Number);
      Object.assign(look, { yaw, pitch, zoom: 1 });
      turn(0, 0);
    });
  }

  // --- curves ----------------------------------------------------------------------------------
  const LEFT = 58, RIGHT = 12, PANEL = 104, GAP = 26, TOP = 8, LANE = 17;

  function lanes(ep) {
    const words = { swap: "swapped", lost: "lost", capture: "captured" };
    const found = new Map();
    for (const event of ep.events) {
      if (!words[event.kind]) continue;
      const who = event.kind === "swap" ? "hands" : ["head", "right", "left"][event.target];
      const name = `${who} ${words[event.kind]}`;
      if (!found.has(name)) found.set(name, []);
      found.get(name).push(event);
    }
    return found;
  }

  function columnOf(ep, i, w) {
    const last = Math.max(1, ep.frames.length - 1);
    return LEFT + (w - LEFT - RIGHT) * i / last;
  }

  function drawCurves(ep, i) {
    const rows = ep.lanes ??= lanes(ep);
    const height = TOP + 2 * PANEL + GAP + 26 + LANE * rows.size;
    if (curves.style.height !== height + "px") curves.style.height = height + "px";
    const [ctx, w] = surface(curves);
    const x = (n) => columnOf(ep, n, w);
    const n = ep.frames.length, half = n > 1 ? (x(1) - x(0)) / 2 : 4;
    ctx.font = `11px ${ink.font}`;
    const tall = TOP + 2 * PANEL + GAP;
    ctx.fillStyle = ink.merged;
    for (let f = 0; f < n; f++) {
      if (ep.merged.every((flags) => flags[f] === "0")) continue;
      ctx.fillRect(x(f) - half, TOP, 2 * half, tall - TOP);
    }
    [[ep.mm, "3-D error", "mm", 400], [ep.px, "Err_acc", "px", 80]].forEach(([values, title, unit, cap], p) => {
      const y0 = TOP + p * (PANEL + GAP), y1 = y0 + PANEL;
      let top = ep["top" + p];
      if (!top) {
        const all = values.flatMap((v) => [...v]).filter(Number.isFinite);
        top = ep["top" + p] = Math.min(cap, nice(Math.max(1, ...all) / 4) * 4);
      }
      const y = (v) => y1 - Math.min(v, top) / top * PANEL;
      ctx.textAlign = "right"; ctx.lineWidth = 1;
      for (let k = 0; k <= 4; k++) {
        const level = top * k / 4;
        ctx.strokeStyle = ink.grid; ctx.beginPath(); ctx.moveTo(LEFT, y(level)); ctx.lineTo(w - RIGHT, y(level)); ctx.stroke();
        if (k % 2 === 0) { ctx.fillStyle = ink.soft; ctx.fillText(String(+level.toFixed(2)), LEFT - 6, y(level) + 4); }
      }
      ctx.save(); ctx.translate(13, (y0 + y1) / 2); ctx.rotate(-Math.PI / 2); ctx.textAlign = "center";
      ctx.fillStyle = ink.text; ctx.fillText(`${title} [${unit}]`, 0, 0); ctx.restore();
      for (let t = 0; t < 3; t++) {
        ctx.strokeStyle = ctx.fillStyle = ink.targets[t];
        ctx.setLineDash(DASHES[t]); ctx.lineWidth = 1.8; ctx.lineJoin = "round";
        ctx.beginPath();
        let down = false;
        for (let f = 0; f < n; f++) {
          const v = values[t][f];
          if (Number.isNaN(v)) { down = false; continue; }
          if (down) ctx.lineTo(x(f), y(v)); else { ctx.moveTo(x(f), y(v)); ctx.lineTo(x(f) + 0.1, y(v)); }
          down = true;
        }
        ctx.stroke(); ctx.setLineDash([]);
        for (let f = 0; f < n; f++) {
          if (!(values[t][f] > top)) continue;
          // Beyond the axis: a small arrow.
          ctx.beginPath(); ctx.moveTo(x(f), y0 - 4); ctx.lineTo(x(f) - 3, y0 + 2); ctx.lineTo(x(f) + 3, y0 + 2); ctx.fill();
        }
        if (!Number.isNaN(values[t][i])) { shape(ctx, t, x(i), y(values[t][i]), 4); ctx.fill(); }
      }
    });
    let y = tall + 8;
    for (const [name, events] of rows) {
      ctx.fillStyle = ink.soft; ctx.textAlign = "left"; ctx.fillText(name, 2, y + 10);
      for (const event of events) {
        const first = ep.place.get(event.first) ?? 0, last = ep.place.get(event.last) ?? n - 1;
        ctx.fillStyle = event.kind === "swap" ? ink.text : ink.targets[event.target];
        const from = Math.max(LEFT, x(first) - half * 0.8), to = Math.min(w - 2, x(last) + half * 0.8);
        ctx.globalAlpha = 0.8;
        ctx.fillRect(Math.max(from, 92), y + 1, Math.max(3, to - Math.max(from, 92)), 10); ctx.globalAlpha = 1;
      }
      y += LANE;
    }
    ctx.fillStyle = ink.soft; ctx.textAlign = "center";
    const every = Math.max(1, nice((n - 1) / Math.max(3, Math.floor(w / 90))));
    for (let f = 0; f < n; f++) {
      if (ep.frames[f] % every === 0) ctx.fillText(String(ep.frames[f]), x(f), y + 13);
    }
    ctx.strokeStyle = ink.text; ctx.lineWidth = 1.4;
    ctx.beginPath(); ctx.moveTo(x(i), 0); ctx.lineTo(x(i), y + 1); ctx.stroke();
  }

  function pick(event) {
    if (!now.ep) return;
    const box = curves.getBoundingClientRect();
    const share = (event.clientX - box.left - LEFT) / (box.width - LEFT - RIGHT);
    go(Math.round(share * (now.ep.frames.length - 1)));
  }
  curves.addEventListener("pointerdown", (event) => { stop(); curves.setPointerCapture(event.pointerId); pick(event); });
  curves.addEventListener("pointermove", (event) => { if (event.buttons) pick(event); });

  // --- one frame everywhere --------------------------------------------------------------------
  const now = { key: "", ep: null, i: 0, timer: 0, turn: 0 };

  function shown() {
    const on = (name) => part("show-" + name).checked;
    return { picture: on("picture"), detections: on("detections"), estimates: on("estimates"), truth: on("truth"), words: true };
  }

  async function go(i) {
    const ep = now.ep;
    if (!ep) return;
    now.i = Math.min(ep.frames.length - 1, Math.max(0, i));
    slider.value = String(now.i);
    const mine = ++now.turn;
    const image = await picture(now.key, ep.frames[now.i]);
    if (mine === now.turn) paint(image);
    if (now.timer) picture(now.key, ep.frames[(now.i + 1) % ep.frames.length]);
  }

  function paint(image) {
    const { ep, i } = now, show = shown(), frame = ep.frames[i];
    views.forEach((canvas, v) => {
      canvas.style.aspectRatio = `${ep.cameras[v].w} / ${ep.cameras[v].h}`;
      const [ctx, w, h] = surface(canvas);
      drawView(ctx, { x: 0, y: 0, w, h }, ep, i, v, image, show);
    });
    drawSpace(ep, i, show);
    drawCurves(ep, i);
    const words = `frame ${frame}, ${ep.times[i].toFixed(2)} s`;
    part("frame").textContent = words;
    part("label").textContent = ep.label[i].replaceAll(";", ", ");
    slider.setAttribute("aria-valuetext", words);
    for (let t = 0; t < 3; t++) {
      const row = part("readout").rows[t];
      const say = (v, digits) => Number.isNaN(v) ? "–" : v.toFixed(digits);
      row.cells[1].textContent = STATUS[Number(ep.status[t][i])];
      row.cells[2].textContent = say(ep.mm[t][i], 0);
      row.cells[3].textContent = say(ep.px[t][i], 1);
      row.cells[4].textContent = ep.merged[t][i] === "1" ? "merged" : "";
    }
    for (const canvas of [...views, space, curves]) canvas.dataset.frame = String(frame);
    section.dataset.frame = String(frame);
  }

  async function load(key, frame) {
    stop();
    const ep = await episode(key);
    Object.assign(now, { key, ep, i: 0 });
    picker.value = key;
    slider.max = String(ep.frames.length - 1);
    const option = picker.selectedOptions[0];
    part("facts").textContent = option ? option.dataset.facts : "";
    const events = part("events");
    events.replaceChildren(...ep.events.map((event) => {
      const button = document.createElement("button");
      button.type = "button";
      button.className = "chip " + event.kind;
      button.textContent = `${event.words}, ${event.first}–${event.last}`;
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

  function stop() {
    clearTimeout(now.timer);
    now.timer = 0;
    play.textContent = "Play";
    play.setAttribute("aria-pressed", "false");
  }

  function tick() {
    const { ep } = now;
    const next = now.i + 1 < ep.frames.length ? now.i + 1 : 0;
    const wait = 1000 / ep.fps / Number(speed.value);
    now.timer = setTimeout(() => { go(next).then(() => now.timer && tick()); }, wait);
  }

  play.addEventListener("click", () => {
    if (now.timer || !now.ep) { stop(); return; }
    if (now.i === now.ep.frames.length - 1) go(0);
    play.textContent = "Pause";
    play.setAttribute("aria-pressed", "true");
    tick();
  });
  slider.addEventListener("input", () => { stop(); go(Number(slider.value)); });
  for (const button of section.querySelectorAll("[data-by]")) {
    button.addEventListener("click", () => { stop(); go(now.i + Number(button.dataset.by)); });
  }
  picker.addEventListener("change", () => visit(picker.value));
  for (const button of section.querySelectorAll("[data-next]")) {
    button.addEventListener("click", () => {
      const all = [...picker.options];
      const at = (picker.selectedIndex + Number(button.dataset.next) + all.length) % all.length;
      visit(all[at].value);
    });
  }
  for (const box of section.querySelectorAll(".toggles input")) {
    box.addEventListener("change", () => go(now.i));
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

  // --- small pictures elsewhere on the page ------------------------------------------------------
  // The part of a view with the targets and what was found, in the shape of the whole view.
  function partOf(ep, i, v) {
    const camera = ep.cameras[v];
    const points = [...ep.truth, ...ep.said].map((target) => project(camera, target, i));
    const there = [...points, ...ep.seen[v][i]].filter((p) => p && p[0] > 0 && p[0] < camera.w && p[1] > 0 && p[1] < camera.h);
    if (!there.length) return { x: 0, y: 0, w: camera.w };
    const [left, right] = [Math.min, Math.max].map((f) => f(...there.map((p) => p[0])));
    const [top, bottom] = [Math.min, Math.max].map((f) => f(...there.map((p) => p[1])));
    const slope = camera.w / camera.h;
    const w = Math.min(camera.w, Math.max(right - left + 150, (bottom - top + 150) * slope));
    const inside = (middle, size, whole) => Math.min(whole - size, Math.max(0, middle - size / 2));
    return { x: inside((left + right) / 2, w, camera.w), y: inside((top + bottom) / 2, w / slope, camera.h), w };
  }

  async function thumb(canvas) {
    const [key, frame] = canvas.dataset.thumb.split("@");
    const ep = await episode(key);
    const image = await picture(key, Number(frame));
    const i = ep.place.get(Number(frame)) ?? 0;
    const show = { picture: true, detections: true, estimates: true, truth: true, words: false };
    canvas.style.aspectRatio = `${2 * ep.cameras[0].w} / ${ep.cameras[0].h}`;
    const [ctx, w, h] = surface(canvas);
    for (const v of [0, 1]) {
      drawView(ctx, { x: v * w / 2, y: 0, w: w / 2, h, part: partOf(ep, i, v) }, ep, i, v, image, show);
    }
    ctx.fillStyle = HALO; ctx.fillRect(w / 2 - 1, 0, 2, h);
    canvas.dataset.drawn = "yes";
  }

  function repaint() {
    readTheme();
    if (now.ep) go(now.i);
  }
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", repaint);
  // Paper is white: curves and 3-D view are drawn again for it.
  for (const [name, paper] of [["beforeprint", true], ["afterprint", false]]) {
    addEventListener(name, () => {
      html.classList.toggle("paper", paper);
      readTheme();
      if (now.ep) { drawSpace(now.ep, now.i, shown()); drawCurves(now.ep, now.i); }
    });
  }
  let resizing = 0;
  new ResizeObserver(() => {
    cancelAnimationFrame(resizing);
    resizing = requestAnimationFrame(() => { if (now.ep) go(now.i); });
  }).observe(section);

  (async () => {
    if (typeof DecompressionStream === "undefined") throw new Error("The player needs a browser of 2023 or later.");
    readTheme();
    await (follow(true) || load(picker.value, null));
    html.dataset.ready = "yes";
    for (const canvas of document.querySelectorAll("canvas[data-thumb]")) await thumb(canvas);
    html.dataset.thumbs = "yes";
  })().catch((error) => {
    part("facts").textContent = error.message;
    html.dataset.ready = "failed";
  });
})();
