// A short film of a failure in a loop, both views side by side: see worst_film.html.j2.
const BEFORE_S = 2.5, AFTER_S = 2.5, LONGEST_S = 9, REST_MS = 900;

// Positions of the frames about a frame: from before its failure began until after it.
function clipOf(ep, i) {
  const begun = faults(ep, i).map((e) => ep.place.get(e.first) ?? i);
  const from = Math.min(i, ...begun), at = (n) => ep.times[Math.max(0, Math.min(ep.frames.length - 1, n))];
  const start = Math.max(at(from) - BEFORE_S, at(i) + AFTER_S - LONGEST_S);
  return ep.frames.map((_, n) => n).filter((n) => ep.times[n] >= start - 1e-6 && ep.times[n] <= at(i) + AFTER_S + 1e-6);
}

async function loopFilm(figure) {
  const [key, frame] = figure.dataset.film.split("@");
  const canvas = figure.querySelector("canvas"), button = figure.querySelector("button"), time = figure.querySelector("output");
  const ep = await episode(key), worst = ep.place.get(Number(frame)) ?? 0, clip = clipOf(ep, worst);
  const crops = [0, 1].map((v) => cropOf(ep, clip, v));
  let n = clip.indexOf(worst), timer = 0, playing = !still.matches, near = true;

  async function paint() {
    const i = clip[n];
    drawPair(canvas, ep, i, await picture(key, ep.frames[i]), crops);
    time.textContent = `frame ${ep.frames[i]}, ${ep.times[i].toFixed(2)} s`;
    figure.dataset.frame = String(ep.frames[i]);
  }
  // Nothing runs while it is paused, out of sight, or the page is in the background.
  function schedule() {
    clearTimeout(timer);
    if (!playing || !near || document.hidden) return;
    const last = n === clip.length - 1;
    const wait = last ? REST_MS : 1000 * (ep.times[clip[n + 1]] - ep.times[clip[n]]);
    timer = setTimeout(() => { n = last ? 0 : n + 1; paint().then(schedule); }, Math.max(30, wait));
  }
  function set(on) {
    playing = on;
    button.textContent = on ? "Pause" : "Play";
    figure.dataset.playing = on ? "yes" : "no";
    schedule();
  }

  button.addEventListener("click", () => set(!playing));
  still.addEventListener("change", () => { if (still.matches) { n = clip.indexOf(worst); set(false); paint(); } });
  document.addEventListener("visibilitychange", schedule);
  new IntersectionObserver(([entry]) => { near = entry.isIntersecting; schedule(); }).observe(canvas);
  new ResizeObserver(() => requestAnimationFrame(paint)).observe(canvas);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", paint);
  if (playing) n = 0;
  await paint();
  set(playing);
}
