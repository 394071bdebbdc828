// The two camera views, large in the player and small elsewhere on the page.
const DETECTED = "#ffe45c", WRONG = "#eb2e2e", LOST_MM = 150;

const exchanged = (ep, i) => ep.events.some((e) => e.kind === "swap" && e.first <= ep.frames[i] && ep.frames[i] <= e.last);
// A line leads from an estimate to its own truth where it is far off, or where the hands are exchanged.
const wrong = (ep, i, t) => ep.mm[t][i] > LOST_MM || (t > 0 && exchanged(ep, i));

let ink = {};
function readTheme() {
  const style = getComputedStyle(html);
  const name = (n) => style.getPropertyValue("--" + n).trim();
  ink = {
    text: name("ink"), soft: name("soft"), grid: name("grid"), line: name("line"), merged: name("merged"),
    accent: name("accent"), paper: name("paper"), targets: NAMES.map(name), font: getComputedStyle(document.body).fontFamily,
  };
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

function project(camera, points, i) {
  const [x, y, z] = points.map((axis) => axis[i]);
  const P = camera.P;
  const q = [0, 4, 8].map((r) => P[r] * x + P[r + 1] * y + P[r + 2] * z + P[r + 3]);
  return q[2] > 0 ? [q[0] / q[2], q[1] / q[2]] : null;
}

// One view of a frame into a box of the canvas; pixel (0, 0) is a pixel's centre.
function drawView(ctx, box, ep, i, v, image, show) {
  const camera = ep.cameras[v];
  const crop = box.crop ?? { x: 0, y: 0, w: camera.w };
  const s = box.w / crop.w;
  ctx.save();
  ctx.beginPath(); ctx.rect(box.x, box.y, box.w, box.h); ctx.clip();
  ctx.translate(box.x, box.y);
  ctx.fillStyle = GROUND; ctx.fillRect(0, 0, box.w, box.h);
  if (image && show.picture) {
    const w = image.width / 2, f = w / camera.w;
    ctx.drawImage(image, v * w + crop.x * f, crop.y * f, crop.w * f, box.h / s * f, 0, 0, box.w, box.h);
  } else if (show.notes) {
    ctx.fillStyle = "#98a3b3"; ctx.font = `12px ${ink.font}`; ctx.textAlign = "right";
    ctx.fillText(show.picture ? "no picture kept of this frame" : "picture switched off", box.w - 9, box.h - 9);
  }
  const big = Math.max(0.55, Math.min(1, box.w / 380));
  const at = (p) => [(p[0] + 0.5 - crop.x) * s, (p[1] + 0.5 - crop.y) * s];
  if (show.detections) {
    for (const [x, y, a, b, angle] of ep.detections[v][i]) {
      const [cx, cy] = at([x, y]);
      ctx.beginPath(); ctx.ellipse(cx, cy, a * s, b * s, angle, 0, 2 * Math.PI); strokeWithHalo(ctx, 1.4 * big, DETECTED);
    }
  }
  for (let t = 0; t < 3 && show.truth; t++) {
    const p = project(camera, ep.truth[t], i);
    if (!p) continue;
    const [x, y] = at(p), r = 7 * big;
    ctx.beginPath(); ctx.moveTo(x - r, y); ctx.lineTo(x + r, y); ctx.moveTo(x, y - r); ctx.lineTo(x, y + r);
    strokeWithHalo(ctx, 2 * big, BRIGHT[t]);
  }
  for (let t = 0; t < 3 && show.truth && show.estimates; t++) {
    const from = project(camera, ep.estimates[t], i), to = project(camera, ep.truth[t], i);
    if (!from || !to || Number.isNaN(from[0]) || !wrong(ep, i, t)) continue;
    ctx.beginPath(); ctx.moveTo(...at(from)); ctx.lineTo(...at(to)); strokeWithHalo(ctx, 3.4 * big, WRONG);
  }
  for (let t = 0; t < 3 && show.estimates; t++) {
    const p = project(camera, ep.estimates[t], i);
    if (!p || Number.isNaN(p[0])) continue;
    const [x, y] = at(p), sure = ep.status[t][i] === "1";
    ctx.setLineDash(sure ? [] : [4, 3]);
    shape(ctx, t, x, y, 12 * big); strokeWithHalo(ctx, (sure ? 2.4 : 1.6) * big, BRIGHT[t]);
    ctx.setLineDash([]);
    const tx = Math.min(Math.max(x + 14 * big, 2), box.w - 14), ty = Math.min(Math.max(y - 10 * big, 13), box.h - 4);
    drawLetter(ctx, t, Math.round(13 * big), ink.font, tx, ty);
  }
  if (show.notes && show.estimates && exchanged(ep, i)) {
    ctx.font = `600 ${Math.round(13 * big)}px ${ink.font}`; ctx.textAlign = "left";
    const words = "left and right exchanged", long = ctx.measureText(words).width;
    ctx.fillStyle = WRONG; ctx.fillRect(8, 8, long + 14, 20 * big + 2);
    ctx.fillStyle = "#fff"; ctx.fillText(words, 15, 8 + 15 * big);
  }
  ctx.restore();
}

function nice(least) {
  const power = 10 ** Math.floor(Math.log10(least));
  return [1, 2, 5, 10].map((f) => f * power).find((f) => f >= least * 0.999);
}

// The part of a view with targets, estimates and detections, in the shape of the whole view.
function cropOf(ep, i, v) {
  const camera = ep.cameras[v];
  const points = [...ep.truth, ...ep.estimates].map((target) => project(camera, target, i));
  const inView = [...points, ...ep.detections[v][i]].filter((p) => p && p[0] > 0 && p[0] < camera.w && p[1] > 0 && p[1] < camera.h);
  if (!inView.length) return { x: 0, y: 0, w: camera.w };
  const [left, right] = [Math.min, Math.max].map((f) => f(...inView.map((p) => p[0])));
  const [top, bottom] = [Math.min, Math.max].map((f) => f(...inView.map((p) => p[1])));
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
  const show = { picture: true, detections: true, estimates: true, truth: true, notes: false };
  canvas.style.aspectRatio = `${2 * ep.cameras[0].w} / ${ep.cameras[0].h}`;
  const [ctx, w, h] = surface(canvas);
  for (const v of [0, 1]) {
    drawView(ctx, { x: v * w / 2, y: 0, w: w / 2, h, crop: cropOf(ep, i, v) }, ep, i, v, image, show);
  }
  ctx.fillStyle = HALO; ctx.fillRect(w / 2 - 1, 0, 2, h);
  canvas.dataset.drawn = "yes";
}
