// Lanes of the time line: failures, merges, hidden targets, the stated probability of an exchange; marks above the slider.
const SHADES = { merged: "merged", hidden: "hidden" }, MOST_LANES = 16;

// Rows to draw: those of the episode, then the failures of another run's, named B.
function lanesOf(ep, second) {
  const rows = ep.lanes.slice(0, MOST_LANES).map((lane) => ({ ...lane, of: ep }));
  if (second) {
    const faulty = second.ep.lanes.filter((lane) => FAULTS.includes(lane.kind));
    rows.push(...faulty.map((lane) => ({ ...lane, of: second.ep, text: `B: ${lane.text}`, dashed: true })));
  }
  for (const e of second ? [ep, second.ep] : [ep]) {
    if (!e.exchange.some((p) => p >= 0.01)) continue;
    rows.push({ kind: "exchange", text: `${e === ep ? "" : "B: "}stated exchange`, of: e });
  }
  return rows;
}

// On a narrow screen a lane's name stands above it, over the cursor.
const rowHeight = (w) => w > 600 ? 18 : 29;

function drawLanes(ctx, w, top, rows, ep, x, half) {
  const left = leftOf(w);
  rows.forEach((row, n) => {
    const y = top + n * rowHeight(w) + (w > 600 ? 1 : 15);
    ctx.fillStyle = ink.grid; ctx.fillRect(left, y + 12, w - RIGHT - left, 1);
    if (row.kind === "exchange") drawChance(ctx, row.of, ep, x, half, y);
    else drawSpans(ctx, row, ep, x, half, y);
  });
}

function nameLanes(ctx, w, top, rows) {
  const wide = w > 600, left = leftOf(w);
  ctx.textAlign = wide ? "right" : "left";
  ctx.strokeStyle = ink.paper; ctx.lineWidth = 4; ctx.lineJoin = "round";
  rows.forEach((row, n) => {
    const at = [wide ? left - 8 : left, top + n * rowHeight(w) + (wide ? 10.5 : 11.5)];
    if (!wide) ctx.strokeText(row.text, ...at);
    ctx.fillStyle = FAULTS.includes(row.kind) ? ink.text : ink.soft;
    ctx.fillText(row.text, ...at, wide ? left - 10 : w - left); // squeezed where a font is wide
  });
}

function drawSpans(ctx, row, ep, x, half, y) {
  const fill = { swap: WRONG, merged: "#c98a00", hidden: ink.soft }[row.kind] ?? ink.targets[row.target];
  for (const span of row.spans) {
    // Of another run: the same frames, at their own places.
    const [from, to] = span.map((n) => ep.place.get(row.of.frames[n]) ?? 0);
    const at = x(from) - half * 0.85, wide = Math.max(3, x(to) - x(from) + half * 1.7);
    ctx.fillStyle = ctx.strokeStyle = fill;
    if (row.dashed) { ctx.setLineDash([4, 3]); ctx.lineWidth = 1.6; ctx.strokeRect(at + 1, y + 1, Math.max(2, wide - 2), 9); ctx.setLineDash([]); }
    else ctx.fillRect(at, y, wide, 11);
  }
  if (row.kind !== "lost") return;
  // Recovered: a tick where the target is tracked again.
  for (const event of row.of.events.filter((e) => e.kind === "recovered" && e.target === row.target)) {
    const at = x(ep.place.get(event.last) ?? 0);
    ctx.strokeStyle = ink.text; ctx.lineWidth = 2;
    ctx.beginPath(); ctx.moveTo(at - 4, y + 6); ctx.lineTo(at - 1, y + 10); ctx.lineTo(at + 5, y + 1); ctx.stroke();
    if (at + 70 < ctx.canvas.clientWidth) { ctx.fillStyle = ink.soft; ctx.textAlign = "left"; ctx.fillText("recovered", at + 8, y + 9.5); }
  }
}

function drawChance(ctx, of, ep, x, half, y) {
  ctx.fillStyle = ink.accent;
  of.exchange.forEach((p, n) => {
    const f = ep.place.get(of.frames[n]);
    if (p >= 0.01 && f !== undefined) ctx.fillRect(x(f) - half, y + 12 - 12 * p, Math.max(1, 2 * half), 12 * p);
  });
}

// Marks above the slider: failures above, merges and hidden targets below.
function drawMarks(ep) {
  const last = Math.max(1, ep.frames.length - 1);
  part("marks").replaceChildren(...ep.lanes.flatMap((lane) => lane.spans.map(([from, to]) => {
    const mark = document.createElement("i");
    mark.className = `${lane.kind} ${NAMES[lane.target] ?? ""}`;
    mark.title = lane.text;
    mark.style.left = `${100 * Math.max(0, from - 0.5) / last}%`;
    mark.style.width = `max(3px, ${100 * (Math.min(last, to + 0.5) - Math.max(0, from - 0.5)) / last}%)`;
    return mark;
  })));
}

// First frames of all that happens, in order: where "[" and "]" lead.
function starts(ep) {
  const places = ep.lanes.flatMap((lane) => lane.spans.map(([from]) => from));
  const back = ep.events.filter((e) => e.kind === "recovered").map((e) => ep.place.get(e.last) ?? 0);
  return [...new Set([...places, ...back])].sort((a, b) => a - b);
}

// The lanes in words, for those who do not see them.
function lanesInWords(ep) {
  const span = ([a, b]) => a === b ? String(ep.frames[a]) : `${ep.frames[a]} to ${ep.frames[b]}`;
  return ep.lanes.slice(0, MOST_LANES).map((lane) => `${lane.text}: ${lane.spans.slice(0, 6).map(span).join(", ")}`).join("; ");
}
