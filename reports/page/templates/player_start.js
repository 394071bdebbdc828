// The page's theme, its paper, and what is shown first.
function repaint() {
  readTheme();
  if (now.source) go(now.i);
}
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", repaint);
// Paper is white: curves and 3-D view are drawn again for it.
for (const [name, paper] of [["beforeprint", true], ["afterprint", false]]) {
  addEventListener(name, () => {
    html.classList.toggle("paper", paper);
    readTheme();
    if (now.source) { drawSpaces(); drawCurves(now.source, now.i, secondAt(now.i)); }
  });
}

start(async () => {
  readTheme();
  // The worst moment, unless the address names another.
  const [key, frame] = section.dataset.opening.split("@");
  await (follow(true) || load(key, Number(frame)));
  html.dataset.ready = "yes";
  for (const figure of document.querySelectorAll("[data-film]")) await loopFilm(figure);
  for (const canvas of document.querySelectorAll("canvas[data-thumb]")) await thumb(canvas);
  html.dataset.thumbs = "yes";
});
