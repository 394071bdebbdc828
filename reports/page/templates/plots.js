const dark = matchMedia("(prefers-color-scheme: dark)");
const plots = [...document.querySelectorAll(".plot")];
let figures = null;

// "@name" is the custom property --name of the reader's theme.
function themed(value, style) {
  if (typeof value === "string") {
    return value.startsWith("@") ? style.getPropertyValue("--" + value.slice(1)).trim() : value;
  }
  if (Array.isArray(value)) {
    return value.some((v) => typeof v === "object" && v !== null) ? value.map((v) => themed(v, style)) : value;
  }
  if (value && typeof value === "object") {
    return Object.fromEntries(Object.entries(value).map(([k, v]) => [k, themed(v, style)]));
  }
  return value;
}

const flat = !document.createElement("canvas").getContext("webgl");

function draw(plot) {
  if (flat && plot.dataset.kind === "paths") {
    say(plot, "The view in 3-D needs WebGL, which this browser does not offer. The positions over time do without.");
    return;
  }
  if (!figures || plot.dataset.drawn === plot.dataset.figure || plot.offsetWidth === 0) return;
  const figure = figures[plot.dataset.figure];
  if (!figure) return;
  const style = getComputedStyle(document.documentElement);
  const ink = style.getPropertyValue("--ink").trim();
  const { data, layout } = themed(figure, style);
  const hover = { bgcolor: style.getPropertyValue("--panel").trim(), font: { color: ink } };
  const soft = style.getPropertyValue("--soft").trim();
  Object.assign(layout, {
    modebar: { bgcolor: "rgba(0,0,0,0)", color: soft, activecolor: ink },
    paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", hoverlabel: hover,
    font: { family: getComputedStyle(document.body).fontFamily, size: 12.5, color: ink },
  });
  plot.dataset.drawn = plot.dataset.figure;
  plot.style.height = layout.height + "px";
  const options = { responsive: true, displaylogo: false, displayModeBar: "hover",
    modeBarButtonsToRemove: ["lasso2d", "select2d", "autoScale2d"] };
  Plotly.react(plot, data, layout, options).catch((error) => say(plot, String(error)));
}

function forget(plot) {
  if (!plot.dataset.drawn) return;
  Plotly.purge(plot);
  plot.replaceChildren();
  delete plot.dataset.drawn;
}

function say(plot, words) {
  const note = document.createElement("p");
  note.textContent = words;
  plot.replaceChildren(note);
}

// Browsers keep about 16 WebGL contexts: 3-D plots live only while near the screen.
const near = new Set();
const watch = new IntersectionObserver((changes) => {
  for (const { target, isIntersecting } of changes) {
    if (isIntersecting) { near.add(target); draw(target); } else {
      near.delete(target);
      if (target.dataset.kind === "paths") forget(target);
    }
  }
}, { rootMargin: "500px" });

function redraw() {
  for (const plot of plots) forget(plot);
  for (const plot of near) draw(plot);
}
dark.addEventListener("change", redraw);
addEventListener("beforeprint", () => plots.filter((p) => p.dataset.kind !== "paths").forEach(draw));

(async () => {
  if (typeof DecompressionStream === "undefined") throw new Error("The plots need a browser of 2023 or later.");
  const script = document.createElement("script");
  script.textContent = await unpack("plotly-packed");
  document.head.append(script);
  figures = JSON.parse(await unpack("figures-packed"));
  for (const plot of plots) watch.observe(plot);
  document.documentElement.dataset.ready = "yes";
})().catch((error) => plots.forEach((plot) => say(plot, error.message)));
