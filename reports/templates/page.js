"use strict";
(() => {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const plots = [...document.querySelectorAll(".plot")];
  let figures = null;

  async function unpack(id) {
    const text = document.getElementById(id).textContent;
    const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).text();
  }

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

  function draw(plot) {
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

  for (const select of document.querySelectorAll("select[data-section]")) {
    select.addEventListener("change", () => {
      const section = document.getElementById(select.dataset.section);
      for (const plot of section.querySelectorAll('.plot[data-kind="errors"], .plot[data-kind="paths"]')) {
        plot.dataset.figure = plot.dataset.kind + "-" + select.value;
        if (near.has(plot)) draw(plot);
      }
      let shown = 0;
      for (const shots of section.querySelectorAll(".shots")) {
        shots.hidden = shots.dataset.entry !== select.value;
        shown += shots.hidden ? 0 : 1;
      }
      section.querySelector(".no-shots").hidden = shown > 0;
    });
  }

  function openTarget() {
    const place = location.hash && document.getElementById(location.hash.slice(1));
    const details = place && place.querySelector(":scope > details");
    if (details) { details.open = true; place.scrollIntoView(); }
  }
  addEventListener("hashchange", openTarget);
  openTarget();

  function redraw() {
    for (const plot of plots) forget(plot);
    for (const plot of near) draw(plot);
  }
  dark.addEventListener("change", redraw);
  addEventListener("beforeprint", () => plots.filter((p) => p.dataset.kind !== "paths").forEach(draw));

  const box = document.getElementById("lightbox");
  let shown = null;
  function show(shot) {
    const image = shot.querySelector("img");
    shown = shot;
    box.querySelector("img").src = image.src;
    box.querySelector("img").alt = image.alt;
    box.querySelector("span").textContent = shot.querySelector("span").textContent;
    if (!box.open) box.showModal();
  }
  function step(by) {
    const all = [...shown.parentElement.children];
    show(all[(all.indexOf(shown) + by + all.length) % all.length]);
  }
  for (const shot of document.querySelectorAll(".shot")) shot.addEventListener("click", () => show(shot));
  for (const button of box.querySelectorAll("[data-step]")) {
    button.addEventListener("click", () => step(Number(button.dataset.step)));
  }
  box.addEventListener("keydown", (event) => {
    if (event.key === "ArrowLeft") step(-1);
    if (event.key === "ArrowRight") step(1);
  });
  box.addEventListener("click", (event) => { if (event.target === box) box.close(); });
  box.addEventListener("close", () => shown && shown.focus());

  (async () => {
    if (typeof DecompressionStream === "undefined") throw new Error("The plots need a browser of 2023 or later.");
    const script = document.createElement("script");
    script.textContent = await unpack("plotly-packed");
    document.head.append(script);
    figures = JSON.parse(await unpack("figures-packed"));
    for (const plot of plots) watch.observe(plot);
    document.documentElement.dataset.ready = "yes";
  })().catch((error) => plots.forEach((plot) => say(plot, error.message)));
})();
