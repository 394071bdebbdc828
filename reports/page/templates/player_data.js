// Data of the episodes: numbers, films, pictures.
const picker = part("episode");
const NAMES = ["head", "right_hand", "left_hand"];
const STATUS = ["waiting", "tracked", "coasting", "lost"];

function series(deltas, scale) {
  let last = 0;
  return Float64Array.from(deltas, (d) => d === null ? NaN : (last += d) * scale);
}

// Positions in metres as [target][axis][frame]; detections of a view as [frame] = list of ellipses.
function decode(raw) {
  const points = (columns) => [0, 1, 2].map((t) => [0, 1, 2].map((a) => series(columns[3 * t + a], 1e-4)));
  const detections = raw.detections.map(({ n, v }) => {
    let next = 0;
    return [...n].map((many) => Array.from({ length: Number(many) }, () => {
      const at = next++;
      return [v[0][at] / 10, v[1][at] / 10, v[2][at] / 10, v[3][at] / 10, v[4][at] / 100];
    }));
  });
  const frames = [...series(raw.frames, 1)];
  let current = 0;
  return {
    ...raw, frames, detections, times: series(raw.ms, 1e-3), place: new Map(frames.map((f, i) => [f, i])),
    truth: points(raw.truth), estimates: points(raw.estimates),
    mm: raw.mm.map((d) => series(d, 0.1)), px: raw.px.map((d) => series(d, 0.1)), exchange: series(raw.exchange, 1e-3),
    label: frames.map((_, i) => {
      while (current + 1 < raw.labels.length && raw.labels[current + 1][0] <= i) current += 1;
      return raw.labels.length && raw.labels[current][0] <= i ? raw.labels[current][1] : "";
    }),
  };
}

const episodes = new Map();
function episode(key) {
  if (!episodes.has(key)) episodes.set(key, unpack("episode-" + key).then(JSON.parse).then(decode));
  return episodes.get(key);
}

// Frame -> place of its bytes in the film's base64.
const films = new Map();
function film(key) {
  if (!films.has(key)) {
    const holder = document.getElementById("film-" + key), owner = holder?.dataset.owner;
    if (owner) return film(owner);
    const places = new Map();
    let start = 0;
    for (const entry of holder ? holder.dataset.sizes.split(" ") : []) {
      const [frame, size] = entry.split(":").map(Number);
      places.set(frame, [start, start + size]);
      start += size;
    }
    films.set(key, { id: key, text: holder ? holder.textContent : "", places });
  }
  return films.get(key);
}

function picture(key, frame) {
  const { id, text, places } = film(key);
  return places.has(frame) ? pictureAt(id + "@" + frame, text, places.get(frame)) : Promise.resolve(null);
}
