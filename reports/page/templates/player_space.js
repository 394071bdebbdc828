// The 3-D view: a small projection of our own, so that it needs no WebGL.
const space = part("space");
const START = { yaw: -0.55, pitch: 0.42, zoom: 1 };
const gaze = { ...START };

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
  const [sy, cy, sp, cp] = [Math.sin(gaze.yaw), Math.cos(gaze.yaw), Math.sin(gaze.pitch), Math.cos(gaze.pitch)];
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
  const scale = gaze.zoom * Math.min((w - side) / (from[1] - from[0]), (h - above) / (to[1] - to[0]));
  const spot = (x, y, z) => {
    const p = flat(x, y, z);
    return [w / 2 + (p[0] - (from[0] + from[1]) / 2) * scale, (h - 18) / 2 + (p[1] - (to[0] + to[1]) / 2) * scale];
  };
  const stroke = (from, to) => { ctx.beginPath(); ctx.moveTo(...spot(...from)); ctx.lineTo(...spot(...to)); ctx.stroke(); };
  ctx.font = `11px ${ink.font}`;
  ctx.lineWidth = 1; ctx.strokeStyle = ink.grid; ctx.fillStyle = ink.soft; ctx.textAlign = "center";
  const step = nice(Math.max(...high.map((v, a) => v - low[a])) / 5);
  const ticks = (a) => {
    const values = [];
    for (let n = Math.ceil(low[a] / step - 1e-6); n * step <= high[a] + 1e-6; n++) values.push(n * step);
    return values;
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
      ctx.globalAlpha = 0.22; ctx.lineWidth = 2.5; path(ep.estimates[t], 0, last);
      ctx.globalAlpha = 1; ctx.lineWidth = 2.5; path(ep.estimates[t], Math.max(0, i - 12), i);
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
    if (!show.estimates || Number.isNaN(ep.estimates[t][0][i])) continue;
    const [x, y] = here(ep.estimates[t]), bad = wrong(ep, i, t);
    ctx.lineWidth = bad ? 4 : 1.6; ctx.strokeStyle = bad ? WRONG : ink.targets[t];
    ctx.beginPath(); ctx.moveTo(tx, ty); ctx.lineTo(x, y); ctx.stroke();
    ctx.lineWidth = 1.6; ctx.strokeStyle = ink.targets[t];
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
  gaze.yaw += yaw;
  gaze.pitch = Math.min(1.57, Math.max(-0.3, gaze.pitch + pitch));
  gaze.zoom = Math.min(5, Math.max(0.5, gaze.zoom * zoom));
  space.dataset.turn = `${gaze.yaw.toFixed(2)} ${gaze.pitch.toFixed(2)} ${gaze.zoom.toFixed(2)}`;
  if (now.source) drawSpace(now.source, now.i, shown());
}
space.addEventListener("keydown", (event) => {
  const turns = {
    ArrowLeft: [0.12, 0], ArrowRight: [-0.12, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1],
    "+": [0, 0, 1.15], "=": [0, 0, 1.15], "-": [0, 0, 1 / 1.15],
  };
  if (event.key === "0") Object.assign(gaze, START);
  const by = event.key === "0" ? [0, 0] : turns[event.key];
  if (!by) return;
  event.preventDefault();
  turn(...by);
});
for (const button of section.querySelectorAll("[data-look]")) {
  button.addEventListener("click", () => {
    const [yaw, pitch] = button.dataset.look.split(" ").map(Number);
    Object.assign(gaze, { yaw, pitch, zoom: 1 });
    turn(0, 0);
  });
}
