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
