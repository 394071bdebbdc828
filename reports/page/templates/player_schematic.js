// A view of a frame without a picture: head and hands as discs where they really are, their last way, the detections.
const SKIN = "rgba(214, 170, 139, .55)", RADII_M = [0.105, 0.045, 0.045], TRAIL = 8;

// Pixels of a metre across the view at a target's depth.
function pixelsPerMetre(camera, points, i) {
  const P = camera.P, [x, y, z] = points.map((axis) => axis[i]);
  const depth = P[8] * x + P[9] * y + P[10] * z + P[11];
  return Math.hypot(P[0], P[1], P[2]) / depth;
}

// at: pixels of the view to the canvas; s: scale of the two.
function drawSchematic(ctx, ep, i, v, at, s) {
  const camera = ep.cameras[v];
  // The far target first: what is nearer to the camera covers it.
  const order = [0, 1, 2].map((t) => [t, pixelsPerMetre(camera, ep.truth[t], i)]).sort((a, b) => a[1] - b[1]);
  for (const [t, scale] of order) {
    const trail = [];
    for (let n = Math.max(0, i - TRAIL); n <= i; n++) trail.push(project(camera, ep.truth[t], n));
    ctx.beginPath();
    trail.filter(Boolean).map(at).forEach(([x, y], n) => { if (n) ctx.lineTo(x, y); else ctx.moveTo(x, y); });
    ctx.lineWidth = 2; ctx.strokeStyle = "rgba(152, 163, 179, .5)"; ctx.stroke();
    const here = trail.at(-1);
    if (!here) continue;
    ctx.beginPath(); ctx.arc(...at(here), Math.max(3, RADII_M[t] * scale * s), 0, 2 * Math.PI);
    ctx.fillStyle = SKIN; ctx.fill();
  }
  ctx.fillStyle = "rgba(255, 228, 92, .16)";
  for (const [x, y, a, b, angle] of ep.detections[v][i]) {
    ctx.beginPath(); ctx.ellipse(...at([x, y]), a * s, b * s, angle, 0, 2 * Math.PI); ctx.fill();
  }
}
