// Curves of the errors and lanes of the events, with a cursor at the frame.
const curves = part("curves");
const DASHES = [[], [7, 4], [2, 3]];
const LEFT = 58, RIGHT = 12, PANEL = 104, GAP = 26, TOP = 8, LANE = 17;

function lanes(ep) {
  const verbs = { swap: "swapped", lost: "lost", capture: "captured" };
  const rows = new Map();
  for (const event of ep.events) {
    if (!verbs[event.kind]) continue;
    const who = event.kind === "swap" ? "hands" : ["head", "right", "left"][event.target];
    const name = `${who} ${verbs[event.kind]}`;
    if (!rows.has(name)) rows.set(name, []);
    rows.get(name).push(event);
  }
  return rows;
}

function columnOf(ep, i, w) {
  const last = Math.max(1, ep.frames.length - 1);
  return LEFT + (w - LEFT - RIGHT) * i / last;
}

function drawCurves(ep, i) {
  const rows = ep.lanes ??= lanes(ep);
  // A lane of its own for the stated probability that the hands are exchanged, where there is any.
  const doubt = ep.doubt ??= ep.exchange.some((p) => p >= 0.01);
  const height = TOP + 2 * PANEL + GAP + 26 + LANE * (rows.size + doubt);
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
  if (doubt) {
    ctx.fillStyle = ink.soft; ctx.textAlign = "left"; ctx.fillText("exchange", 2, y + 11);
    ctx.fillStyle = ink.accent;
    for (let f = 0; f < n; f++) {
      const p = ep.exchange[f], from = Math.max(92, x(f) - half);
      if (p >= 0.01) ctx.fillRect(from, y + 13 - 13 * p, Math.max(1, x(f) + half - from), 13 * p);
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
  if (!now.source) return;
  const box = curves.getBoundingClientRect();
  const share = (event.clientX - box.left - LEFT) / (box.width - LEFT - RIGHT);
  go(Math.round(share * (now.source.frames.length - 1)));
}
curves.addEventListener("pointerdown", (event) => { stop(); curves.setPointerCapture(event.pointerId); pick(event); });
curves.addEventListener("pointermove", (event) => { if (event.buttons) pick(event); });
