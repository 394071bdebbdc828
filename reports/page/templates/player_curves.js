// Curves of the errors with a cursor at the frame; below them the lanes of player_lanes.js, on the same scale.
const curves = part("curves");
const RIGHT = 12, PANEL = 104, GAP = 26, TOP = 8;

// Where the scale of the frames begins: right of the names of the lanes, where there is room for them.
const leftOf = (w) => w > 600 ? 212 : 46;

function columnOf(ep, i, w) {
  const last = Math.max(1, ep.frames.length - 1);
  return leftOf(w) + (w - leftOf(w) - RIGHT) * i / last;
}

// Half the width of a frame's column.
const halfOf = (ep, w) => ep.frames.length > 1 ? (columnOf(ep, 1, w) - columnOf(ep, 0, w)) / 2 : 4;

// second: another run's episode of the same frames, with dashed curves, or null.
function drawCurves(ep, i, second = null) {
  const rows = lanesOf(ep, second), box = curves.clientWidth, row = rowHeight(box);
  const tall = TOP + 2 * PANEL + GAP, height = tall + 26 + row * rows.length;
  if (curves.style.height !== height + "px") curves.style.height = height + "px";
  const [ctx, w] = surface(curves);
  const x = (n) => columnOf(ep, n, w), half = halfOf(ep, w), last = ep.frames.length - 1;
  ctx.font = `11px ${ink.font}`;
  for (const lane of ep.lanes.filter((l) => SHADES[l.kind])) {
    ctx.fillStyle = ink[SHADES[lane.kind]];
    for (const [from, to] of lane.spans) ctx.fillRect(x(from) - half, TOP, x(to) - x(from) + 2 * half, tall - TOP);
  }
  const shown = second ? [ep, second.ep] : [ep];
  [["mm", "3-D error", 400], ["px", "Err_acc", 80]].forEach(([name, title, cap], p) => {
    const y0 = TOP + p * (PANEL + GAP);
    const all = shown.flatMap((e) => e[name].flatMap((v) => [...v])).filter(Number.isFinite);
    const top = Math.min(cap, nice(Math.max(1, ...all) / 4) * 4);
    drawScale(ctx, w, y0, top, `${title} [${name}]`);
    if (name === "mm" && top > WRONG_MM) drawLimit(ctx, w, y0 + PANEL * (1 - WRONG_MM / top));
    const others = second ? second.ep[name].map((v) => ep.frames.map((f) => v[second.ep.place.get(f)] ?? NaN)) : [];
    for (let t = 0; t < 3; t++) {
      if (second) drawCurve(ctx, t, others[t], x, y0, top, true);
      drawCurve(ctx, t, ep[name][t], x, y0, top, false);
      const v = ep[name][t][i];
      if (!Number.isNaN(v)) { shape(ctx, t, x(i), y0 + PANEL * (1 - Math.min(v, top) / top), 4.5); ctx.fill(); }
    }
  });
  drawLanes(ctx, w, tall + 8, rows, ep, x, half);
  const foot = tall + 8 + row * rows.length;
  ctx.fillStyle = ink.soft; ctx.textAlign = "center";
  const every = Math.max(1, nice(last / Math.max(3, Math.floor((w - leftOf(w)) / 80))));
  ep.frames.forEach((f, n) => { if (f % every === 0) ctx.fillText(String(f), x(n), foot + 13); });
  ctx.strokeStyle = ink.text; ctx.lineWidth = 1.4;
  ctx.beginPath(); ctx.moveTo(x(i), 0); ctx.lineTo(x(i), foot + 1); ctx.stroke();
  nameLanes(ctx, w, tall + 8, rows);
}

function drawScale(ctx, w, y0, top, title) {
  const left = leftOf(w);
  ctx.textAlign = "right"; ctx.lineWidth = 1;
  for (let k = 0; k <= 4; k++) {
    const y = y0 + PANEL * (1 - k / 4);
    ctx.strokeStyle = ink.grid; ctx.beginPath(); ctx.moveTo(left, y); ctx.lineTo(w - RIGHT, y); ctx.stroke();
    if (k % 2 === 0) { ctx.fillStyle = ink.soft; ctx.fillText(String(+(top * k / 4).toFixed(2)), left - 6, y + 4); }
  }
  ctx.save(); ctx.translate(left > 100 ? left - 44 : 11, y0 + PANEL / 2); ctx.rotate(-Math.PI / 2); ctx.textAlign = "center";
  ctx.fillStyle = ink.text; ctx.fillText(title, 0, 0); ctx.restore();
}

// From this error on an estimate counts as wrong.
function drawLimit(ctx, w, y) {
  ctx.strokeStyle = ink.bad; ctx.lineWidth = 1; ctx.setLineDash([2, 4]);
  ctx.beginPath(); ctx.moveTo(leftOf(w), y); ctx.lineTo(w - RIGHT, y); ctx.stroke(); ctx.setLineDash([]);
}

function drawCurve(ctx, t, values, x, y0, top, dashed) {
  const y = (v) => y0 + PANEL * (1 - Math.min(v, top) / top);
  ctx.strokeStyle = ctx.fillStyle = ink.targets[t];
  ctx.setLineDash(dashed ? [5, 4] : []); ctx.lineWidth = 1.8; ctx.lineJoin = "round";
  ctx.beginPath();
  let down = false;
  values.forEach((v, f) => {
    if (Number.isNaN(v)) { down = false; return; }
    if (down) ctx.lineTo(x(f), y(v)); else { ctx.moveTo(x(f), y(v)); ctx.lineTo(x(f) + 0.1, y(v)); }
    down = true;
  });
  ctx.stroke(); ctx.setLineDash([]);
  // Shapes tell the targets apart where colours do not; beyond the axis: a small arrow.
  const every = Math.max(1, Math.round(36 / Math.max(1, x(1) - x(0))));
  values.forEach((v, f) => {
    if (v > top) {
      ctx.beginPath(); ctx.moveTo(x(f), y0 - 5); ctx.lineTo(x(f) - 3, y0 + 1); ctx.lineTo(x(f) + 3, y0 + 1); ctx.fill();
    } else if (!Number.isNaN(v) && !dashed && (f + t) % every === 0) { shape(ctx, t, x(f), y(v), 2.6); ctx.fill(); }
  });
}

function pick(event) {
  if (!now.source) return;
  const box = curves.getBoundingClientRect(), left = leftOf(box.width);
  const share = (event.clientX - box.left - left) / (box.width - left - RIGHT);
  go(Math.round(share * (now.source.frames.length - 1)));
}
curves.addEventListener("pointerdown", (event) => { stop(); curves.setPointerCapture(event.pointerId); pick(event); });
curves.addEventListener("pointermove", (event) => { if (event.buttons) pick(event); });
