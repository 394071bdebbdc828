// The two camera views, large in the player and small elsewhere on the page.
function project(camera, points, i) {
  const [x, y, z] = points.map((axis) => axis[i]);
  const P = camera.P;
  const q = [0, 4, 8].map((r) => P[r] * x + P[r + 1] * y + P[r + 2] * z + P[r + 3]);
  return q[2] > 0 ? [q[0] / q[2], q[1] / q[2]] : null;
}

// A box of the canvas as the frame of a view: at(pixel) is its place in the box, s the scale.
function placed(box, camera) {
  const crop = box.crop ?? { x: 0, y: 0, w: camera.w };
  const s = box.w / crop.w;
  // Pixel (0, 0) is a pixel's centre.
  return { crop, s, big: Math.max(0.55, Math.min(1, box.w / 380)), at: (p) => [(p[0] + 0.5 - crop.x) * s, (p[1] + 0.5 - crop.y) * s] };
}

// One view of a frame into a box of the canvas.
function drawView(ctx, box, ep, i, v, image, show) {
  const camera = ep.cameras[v], { crop, s, big, at } = placed(box, camera);
  ctx.save();
  ctx.beginPath(); ctx.rect(box.x, box.y, box.w, box.h); ctx.clip();
  ctx.translate(box.x, box.y);
  ctx.fillStyle = GROUND; ctx.fillRect(0, 0, box.w, box.h);
  if (image && show.picture) {
    const w = image.width / 2, f = w / camera.w;
    ctx.drawImage(image, v * w + crop.x * f, crop.y * f, crop.w * f, box.h / s * f, 0, 0, box.w, box.h);
  } else {
    drawSchematic(ctx, ep, i, v, at, s);
    if (show.notes) {
      ctx.fillStyle = "#aeb8c6"; ctx.font = `12px ${ink.font}`; ctx.textAlign = "right";
      ctx.fillText(show.picture ? "schematic: no picture kept" : "schematic: picture switched off", box.w - 9, box.h - 9);
    }
  }
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
  if (show.estimates) drawEstimates(ctx, box, ep, i, v, show);
  const words = show.estimates && show.badges !== false ? badges(ep, i) : [];
  drawBadges(ctx, words, { ...box, y: 0 });
  ctx.restore();
}

// Estimates of a frame, each with a line to its own truth: dashed as a second run's, thin where not tracked.
function drawEstimates(ctx, box, ep, i, v, show) {
  const camera = ep.cameras[v], { big, at } = placed(box, camera), dash = show.dashed ? [5 * big + 1, 4 * big] : [];
  const ends = [0, 1, 2].map((t) => [project(camera, ep.estimates[t], i), project(camera, ep.truth[t], i)]);
  const given = (t) => ends[t][0] && !Number.isNaN(ends[t][0][0]);
  // Wrong ones last: nothing covers them.
  const order = [0, 1, 2].filter(given).sort((a, b) => wrong(ep, i, a) - wrong(ep, i, b));
  for (const t of order) {
    if (!show.truth || !ends[t][1]) continue;
    const bad = wrong(ep, i, t);
    ctx.setLineDash(dash);
    ctx.beginPath(); ctx.moveTo(...at(ends[t][0])); ctx.lineTo(...at(ends[t][1]));
    strokeWithHalo(ctx, (bad ? 4.2 : 1.3) * big, bad ? WRONG : BRIGHT[t]);
  }
  for (const t of order) {
    const [x, y] = at(ends[t][0]), sure = ep.status[t][i] === "1";
    ctx.setLineDash(dash);
    shape(ctx, t, x, y, 12 * big); strokeWithHalo(ctx, (sure ? 2.4 : 1.2) * big, BRIGHT[t]);
    ctx.setLineDash([]);
    const tx = Math.min(Math.max(x + 14 * big, 2), box.w - 26), ty = Math.min(Math.max(y - 10 * big, 13), box.h - 4);
    drawLetter(ctx, t, Math.round(13 * big), ink.font, tx, ty, sure ? "" : "?");
  }
  ctx.setLineDash([]);
}

// The part of a view with targets, estimates and detections of some frames, in the shape of the whole view.
function cropOf(ep, frames, v) {
  const camera = ep.cameras[v];
  const points = frames.flatMap((i) => [
    ...[...ep.truth, ...ep.estimates].map((target) => project(camera, target, i)), ...ep.detections[v][i],
  ]);
  const inView = points.filter((p) => p && p[0] > 0 && p[0] < camera.w && p[1] > 0 && p[1] < camera.h);
  if (!inView.length) return { x: 0, y: 0, w: camera.w };
  const [left, right] = [Math.min, Math.max].map((f) => f(...inView.map((p) => p[0])));
  const [top, bottom] = [Math.min, Math.max].map((f) => f(...inView.map((p) => p[1])));
  const slope = camera.w / camera.h;
  const w = Math.min(camera.w, Math.max(right - left + 150, (bottom - top + 150) * slope));
  const inside = (middle, size, whole) => Math.min(whole - size, Math.max(0, middle - size / 2));
  return { x: inside((left + right) / 2, w, camera.w), y: inside((top + bottom) / 2, w / slope, camera.h), w };
}

// Both views side by side on a canvas, cropped; with the badges of the frame in the left one.
function drawPair(canvas, ep, i, image, crops) {
  const show = { picture: true, detections: true, estimates: true, truth: true, notes: false };
  const shaped = `${2 * ep.cameras[0].w} / ${ep.cameras[0].h}`;
  if (canvas.style.aspectRatio !== shaped) canvas.style.aspectRatio = shaped;
  const [ctx, w, h] = surface(canvas);
  for (const v of [0, 1]) {
    drawView(ctx, { x: v * w / 2, y: 0, w: w / 2, h, crop: crops[v] }, ep, i, v, image, { ...show, badges: v === 0 });
  }
  ctx.fillStyle = HALO; ctx.fillRect(w / 2 - 1, 0, 2, h);
}

async function thumb(canvas) {
  const [key, frame] = canvas.dataset.thumb.split("@");
  const ep = await episode(key);
  const image = await picture(key, Number(frame));
  const i = ep.place.get(Number(frame)) ?? 0;
  drawPair(canvas, ep, i, image, [0, 1].map((v) => cropOf(ep, [i], v)));
  const words = badges(ep, i);
  if (words.length) canvas.setAttribute("aria-label", `${canvas.getAttribute("aria-label")}: ${words.join(", ")}`);
  canvas.dataset.drawn = "yes";
}
