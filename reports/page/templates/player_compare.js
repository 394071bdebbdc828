// Another run's episode of the same scenario and seed: laid over (dashed), or side by side.
const against = part("against"), modes = [...section.querySelectorAll("input[name=compare]")];
// ep: of the other run; keys: of all episodes that can be compared with the one shown.
const compared = { mode: "alone", key: "", ep: null };

const optionOf = (key) => [...picker.options].find((option) => option.value === key);
const runOf = (key) => optionOf(key)?.dataset.run ?? "";

// Keys are run-scenario-seed; a page of one run names none.
function partnersOf(key) {
  if (!runOf(key)) return [];
  const rest = key.slice(key.indexOf("-"));
  return [...picker.options].map((o) => o.value).filter((other) => other !== key && other.slice(other.indexOf("-")) === rest);
}

// Offers the other runs of the episode that is shown now; wanted: key of one, "" for the one of before.
async function offerRuns(key, wanted) {
  const partners = partnersOf(key), run = runOf(compared.key);
  part("compare").hidden = !partners.length;
  against.replaceChildren(...partners.map((other) => new Option(runOf(other), other)));
  compared.key = partners.find((other) => other === wanted) ?? partners.find((other) => runOf(other) === run) ?? partners[0] ?? "";
  against.value = compared.key;
  compared.ep = compared.key && compared.mode !== "alone" ? await episode(compared.key) : null;
  arrange();
}

function arrange() {
  const mode = compared.ep ? compared.mode : "alone";
  part("stage-b").hidden = mode !== "beside";
  section.dataset.compare = mode;
  part("dashed").hidden = mode === "alone";
  for (const radio of modes) radio.checked = radio.value === compared.mode;
  const names = mode === "alone" ? "" : ` A ${mode === "over" ? "(solid) " : ""}is ${runOf(now.key)}, B ${mode === "over" ? "(dashed) " : ""}is ${runOf(compared.key)}.`;
  part("who").textContent = names;
  part("name-a").textContent = mode === "beside" ? `A, ${runOf(now.key)}` : "";
  part("name-b").textContent = mode === "beside" ? `B, ${runOf(compared.key)}` : "";
}

async function compareAs(mode) {
  if (part("compare").hidden) return;
  compared.mode = mode;
  await offerRuns(now.key, compared.key);
  go(now.i);
}

// The other run's episode at the frame that is shown; null where there is none to show.
function secondAt(i) {
  const { ep } = compared, place = ep?.place.get(now.source.frames[i]);
  return place === undefined ? null : { ep, i: place };
}

// A becomes B, at the same frame.
function switchRuns() {
  if (!compared.key) return;
  const [key, frame] = [now.key, now.source.frames[now.i]];
  load(compared.key, frame, key);
}

for (const radio of modes) radio.addEventListener("change", () => compareAs(radio.value));
against.addEventListener("change", () => { compared.key = against.value; compareAs(compared.mode); });
part("switch").addEventListener("click", switchRuns);
