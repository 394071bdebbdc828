// The 3-D view: a small projection of our own, so that it needs no WebGL.
const space = part("space"), spaces = [space, part("space-b")].filter(Boolean);
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

// The axes of a box, and the place on the canvas of a point in it.
function drawAxes(ctx, w, h, [low, high]) {
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
  // Beyond the numbers of an edge, and beside them where the edge is steep: they go on away from it.
  const nameEdge = (words, edge, tick) => {
    const [x, y] = spot(...tick), from = spot(...edge);
    if (!roomy) return name(words[0], [x, y]);
    const aside = Math.max(-1, Math.min(1, (x - from[0]) / 12));
    name(words, [x + aside * (ctx.measureText(words).width / 2 + 8), y + (y < from[1] ? -16 : 16)]);
  };
  nameEdge("x, to the cameras", [middle[0], ey, low[2]], [middle[0], away(middle[0], ey, 1), low[2]]);
  nameEdge("y, to the person’s left", [ex, middle[1], low[2]], [away(middle[1], ex, 0), middle[1], low[2]]);
  const top = spot(ux, uy, high[2]);
  name(roomy ? "z, up [m]" : "z", [top[0], top[1] - 8]);
  return spot;
}

// second: the position of another run's episode that is laid over it, or null.
function drawSpace(canvas, ep, i, show, second = null) {
  const [ctx, w, h] = surface(canvas), box = ep.bounds ??= bounds(ep);
  const spot = drawAxes(ctx, w, h, box);
  drawPaths(ctx, spot, box, ep, i, show);
  if (second) drawPaths(ctx, spot, box, second.ep, second.i, { ...show, truth: false, dashed: true });
}

for (const canvas of spaces) {
  let drag = null;
  canvas.addEventListener("pointerdown", (event) => {
    drag = [event.clientX, event.clientY];
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!drag) return;
    turn((drag[0] - event.clientX) * 0.009, (event.clientY - drag[1]) * 0.009);
    drag = [event.clientX, event.clientY];
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => { drag = null; });
  canvas.addEventListener("keydown", turnByKey);
}

function turn(yaw, pitch, zoom = 1) {
  gaze.yaw += yaw;
  gaze.pitch = Math.min(1.57, Math.max(-0.3, gaze.pitch + pitch));
  gaze.zoom = Math.min(5, Math.max(0.5, gaze.zoom * zoom));
  space.dataset.turn = `${gaze.yaw.toFixed(2)} ${gaze.pitch.toFixed(2)} ${gaze.zoom.toFixed(2)}`;
  drawSpaces();
}

function turnByKey(event) {
  const turns = {
    ArrowLeft: [0.12, 0], ArrowRight: [-0.12, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1],
    "+": [0, 0, 1.15], "=": [0, 0, 1.15], "-": [0, 0, 1 / 1.15],
  };
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.key === "0") Object.assign(gaze, START);
  const by = event.key === "0" ? [0, 0] : turns[event.key];
  if (!by) return;
  event.preventDefault();
  turn(...by);
}

const looks = [...section.querySelectorAll("[data-look]")];
let look = looks.length - 1;
function lookFrom(n) {
  look = n % looks.length;
  const [yaw, pitch] = looks[look].dataset.look.split(" ").map(Number);
  Object.assign(gaze, { yaw, pitch, zoom: 1 });
  turn(0, 0);
}
looks.forEach((button, n) => button.addEventListener("click", () => lookFrom(n)));
