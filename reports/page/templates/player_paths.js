// Ways of the targets in the 3-D view, and the line from each estimate to its own truth.
function drawPaths(ctx, spot, [low, high], ep, i, show) {
  const radius = Math.hypot(...low.map((l, a) => (high[a] - l) / 2)), last = ep.frames.length - 1;
  const far = (points, n) => [0, 1, 2].some((a) => points[a][n] < low[a] - radius || points[a][n] > high[a] + radius);
  const at = (points, n) => spot(points[0][n], points[1][n], points[2][n]);
  const path = (points, first, end) => {
    ctx.beginPath();
    let down = false;
    for (let n = first; n <= end; n++) {
      if (Number.isNaN(points[0][n]) || far(points, n)) { down = false; continue; }
      if (down) ctx.lineTo(...at(points, n)); else ctx.moveTo(...at(points, n));
      down = true;
    }
    ctx.stroke();
  };
  ctx.lineJoin = "round";
  for (let t = 0; t < 3; t++) {
    ctx.strokeStyle = ink.targets[t];
    if (show.truth) { ctx.globalAlpha = 0.55; ctx.lineWidth = 1; path(ep.truth[t], 0, last); }
    if (show.estimates) {
      ctx.setLineDash(show.dashed ? [6, 5] : []);
      ctx.globalAlpha = 0.22; ctx.lineWidth = 2.5; path(ep.estimates[t], 0, last);
      ctx.globalAlpha = 1; path(ep.estimates[t], Math.max(0, i - 12), i);
      ctx.setLineDash([]);
    }
    ctx.globalAlpha = 1;
  }
  // Wrong ones last: nothing covers their lines.
  for (const t of [0, 1, 2].sort((a, b) => wrong(ep, i, a) - wrong(ep, i, b))) {
    const [tx, ty] = at(ep.truth[t], i), bad = wrong(ep, i, t);
    ctx.strokeStyle = ctx.fillStyle = ink.targets[t]; ctx.lineWidth = 1.6;
    if (show.truth) {
      ctx.beginPath(); ctx.moveTo(tx - 6, ty); ctx.lineTo(tx + 6, ty); ctx.moveTo(tx, ty - 6); ctx.lineTo(tx, ty + 6); ctx.stroke();
    }
    if (!show.estimates || Number.isNaN(ep.estimates[t][0][i])) continue;
    const [x, y] = at(ep.estimates[t], i);
    ctx.setLineDash(show.dashed ? [6, 5] : []);
    ctx.lineWidth = bad ? 4 : 1.6; ctx.strokeStyle = bad ? WRONG : ink.targets[t];
    ctx.beginPath(); ctx.moveTo(tx, ty); ctx.lineTo(x, y); ctx.stroke();
    ctx.setLineDash([]);
    ctx.lineWidth = 1.6; ctx.strokeStyle = ink.targets[t];
    shape(ctx, t, x, y, 5.5);
    if (ep.status[t][i] === "1" && !show.dashed) ctx.fill(); else { ctx.fillStyle = ink.paper; ctx.fill(); ctx.stroke(); }
  }
}
