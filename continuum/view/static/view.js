"use strict";
// The page of `continuum view`: it sends the form, and shows the map, the answer, and maps of the solution.
const form = $("form");
let middle = {}; // the values at which the sliders began, each a number and its unit
let asking = new AbortController(); // ends what was asked before
let later = null, clock = null;
let entered = {}; // what was entered for the map before
const sliders = document.querySelectorAll("input[data-for]"); // two of w and of the pressure: one is beside the curve
let layers = { map: [], solved: [] }, lacks = [], names = known.opened;

for (const name of known.materials) $("materials").append(new Option(name));
for (const input of form.elements) if (known.help[input.name]) input.title = known.help[input.name];

const fields = () => Object.fromEntries([...new FormData(form)].map(([name, value]) => [name, value.trim()]));

async function answered(path, body, method = "POST", headers = {}, signal = undefined) {
  const answer = await fetch(path, { method, body, headers, signal });
  if (!answer.ok) throw new Error((await answer.json()).error || answer.statusText);
  return answer;
}
const talk = async (...asked) => (await answered(...asked)).json();

// Lines of JSON, as they come.
async function* lines(path, body, signal) {
  const reader = (await answered(path, body, "POST", {}, signal)).body.pipeThrough(new TextDecoderStream()).getReader();
  for (let rest = "", end = false; !end;) {
    const part = await reader.read(), whole = (rest + (part.value || "")).split("\n");
    [rest, end] = [whole.pop(), part.done];
    for (const said of whole.map(JSON.parse)) {
      if (said.error) throw new Error(said.error);
      yield said;
    }
  }
}

// What is being done, and for how long.
function progress(words) {
  const began = Date.now(), say = () => { $("progress").textContent = words && `${words}, ${Math.round((Date.now() - began) / 1000)} s`; };
  clearInterval(clock);
  if (words) clock = setInterval(say, 1000);
  say();
}

// A fault of the form is said, and its fields are marked; what was answered before stays only if it still holds.
function fail(error, holds = false) {
  if (!holds) for (const id of ["verdict", "answer", "remarks", "same", "loads"]) $(id).hidden = true;
  $("error").hidden = false;
  $("error").textContent = error.message;
  if (!holds) progress("");
  for (const input of form.elements) input.classList.toggle("asked", Boolean(input.name) && error.message.includes(`\`${input.name}\``));
}

function showLayers() {
  const all = [...layers.map, ...layers.solved], before = $("layer").value;
  $("layer").replaceChildren(...all.map(({ name }) => new Option(name)));
  if (all.some(({ name }) => name === before)) $("layer").value = before;
  showLayer();
}

function showLayer() {
  const layer = [...layers.map, ...layers.solved].find(({ name }) => name === $("layer").value);
  if (!layer) return;
  $("layer").value = layer.name;
  const bytes = (one) => new Float32Array(Uint8Array.from(atob(one.values), (letter) => letter.charCodeAt(0)).buffer);
  const values = bytes(layer), unit = lacks.includes("size") ? [layer.lengths[0] / layer.points[0], "pixels"] : unitOf(Math.max(...layer.lengths));
  let key = [1, "|∂w_c/∂h|, log10 over the largest"], more = { values };
  if (layer.kind === "contact") {
    const under = [...layers.solved, ...layers.map].find(({ kind, shape }) => kind === "height" && String(shape) === String(layer.shape));
    more = { values: under && bytes(under), kinds: values, names: ["neither", "attracts", "repels"] };
  } else if (layer.kind === "height") {
    key = lacks.includes("unit") ? [1, "height, as in the file"] : unitOf(values.reduce((most, value) => Math.max(most, Math.abs(value)), 0));
    if (!lacks.includes("unit")) key = [key[0], `height (${key[1]})`];
  }
  drawMap($("map"), { ...layer, ...more, unit, key, title: layer.name, said: (i, j, k) => {
    const at = [i, j].map((n, axis) => text((n + 0.5) / layer.shape[axis] * layer.lengths[axis] / unit[0], 3));
    $("under").textContent = `x = ${at[0]}, y = ${at[1]} ${unit[1]}: ${more.kinds ? more.names[values[k]] : `${text(values[k] / key[0], 3)}, ${key[1]}`}`;
  } });
}

// Faults of the map, each with what corrects it.
function showFaults(said) {
  layers.map.push(...said.layers);
  $("faults").replaceChildren(...said.faults.map((fault) => element("li", { textContent: `${fault.text} ` },
    ...(Object.keys(fault.set).length ? [element("button", { type: "button", textContent: "correct", onclick: () => {
      fill(fault.set);
      ask();
    } })] : []), " ",
    ...(fault.layer ? [element("button", { type: "button", textContent: "show", onclick: () => { $("layer").value = fault.layer; showLayer(); $("map").scrollIntoView({ block: "nearest" }); } })] : []))));
  $("faulty").hidden = !said.faults.length;
  showLayers();
}

// The map and its roughness, before anything is known of the bodies.
function showMap(said) {
  layers = { map: said.layers, solved: [] };
  lacks = said.lacks;
  $("rough").replaceChildren(...said.rows.map((row) => element("tr", {}, ...row.map((words) => element("td", { textContent: words })))));
  const size = lacks.includes("unit") ? [1, "as in the file"] : unitOf(Math.max(...said.bearing[0].slice(1)));
  const curves = [1, 2, 3].map((k) => said.bearing.map((row) => [row[0], row[k] / size[0]])), all = curves.flat().map(([, value]) => value);
  $("bearing").replaceChildren();
  drawCurves($("bearing"), { x: { ends: [0, 100], label: "area above the height (%)" }, y: { ends: [Math.min(...all), Math.max(...all)], label: `height (${size[1]})` }, curves, title: "bearing curve" });
  $("bearing").append(element("p", { className: "key", textContent: "line: as judged, dashed: as measured, dotted: Gaussian" }));
  $("seen").hidden = false;
  showFaults({ faults: [], layers: [] });
}

function drawRanges({ row, curve }) {
  $("ranges").replaceChildren();
  const points = (curve || []).filter(({ work }) => work).map((one) => [1e9 * one.range, 1e3 * one.work, 1e3 * (one.low || 0), one.high === null ? Infinity : 1e3 * one.high]);
  if (points.length < 2) return;
  const here = [1e9 * row.range_m, 1e3 * row["work_of_adhesion_J/m2"]], works = [here[1], ...points.map((one) => one[1])], ranges = [here[0], ...points.map((one) => one[0])];
  drawCurves($("ranges"), {
    title: "threshold against the range of the attraction", curves: [points], band: points.map(([a, , low, high]) => [a, low, high]), dots: [[...here, { class: "here", r: 6 }]],
    x: { ends: [Math.min(...ranges), Math.max(...ranges)], log: true, label: "range of the attraction (nm)" },
    y: { ends: [Math.min(...works) / 2, 2 * Math.max(...works)], log: true, label: "threshold w_c (mJ/m²)" },
  });
  $("ranges").append(element("p", { className: "key", textContent: "line: w_c, shaded: undecided, dot: this contact" }));
}

// Mean pressure against the contact area: with w and the error of w_c, at the threshold, and without adhesion; in MPa.
function drawLoads({ row, adhesion }) {
  $("loads").hidden = !adhesion;
  $("curve").replaceChildren();
  if (!adhesion) return;
  const loaded = row["area at the load"], gap = row["mean gap at the load_m"];
  if (loaded) say($("load"), `${text(row.pressure_Pa / 1e6, 3)} MPa: ${text(100 * loaded, 3)} % touch at a mean gap of ${text(gap / unitOf(gap)[0], 3)} ${unitOf(gap)[1]}`);
  const areas = adhesion.area.map((area) => 100 * area), loads = Object.fromEntries(Object.entries(adhesion.pressure_Pa).map(([name, all]) => [name, all.map((one) => one / 1e6)]));
  const points = (name) => areas.map((area, i) => [area, loads[name][i]]), seen = loads.none[Math.max(0, areas.findLastIndex((area) => area <= 3))];
  const most = Math.max(seen, 2e-6 * row["pull-off stress_Pa"], 1.5e-6 * (row.pressure_Pa || 0)), dots = [];
  for (const [name, load] of [["area at pull-off", -row["pull-off stress_Pa"]], ["area without load", 0], ["area at the load", row.pressure_Pa]])
    if (row[name] && 100 * row[name] >= areas[0]) dots.push([100 * row[name], load / 1e6, { class: "here", r: 5 }]);
  drawCurves($("curve"), {
    title: "mean pressure against the contact area", curves: ["w", "w_c", "none"].map(points), dots,
    band: areas.map((area, i) => [area, loads["w low"][i], loads["w high"][i]]),
    x: { ends: [areas[0], areas.at(-1)], log: true, label: "contact area (%)" },
    y: { ends: [1.3 * Math.min(-0.1 * most, ...loads["w high"]), most], label: "mean pressure (MPa)" },
  });
}

function showAnswer(said) {
  const [first, ...rest] = said.statements, measured = said.row["w_c as measured_J/m2"];
  $("error").hidden = true;
  $("verdict").hidden = $("answer").hidden = false;
  $("verdict").textContent = said.verdict;
  $("verdict").style.background = said.colour;
  $("works").innerHTML = said.axis; // drawn by the program, of numbers alone
  $("statements").replaceChildren(...[first, ...rest].map((line) => element("p", { textContent: line })));
  $("measured").textContent = measured ? `The answer is that of the map with its faults corrected; as measured w_c = ${text(1e3 * measured, 3)} mJ/m².` : "";
  $("doubts").replaceChildren(...said.doubts.map((line) => element("li", { textContent: line })));
  $("remarks").hidden = !said.doubts.length;
  drawRanges(said);
  drawLoads(said);
  for (const input of form.elements) input.classList.remove("asked");
}

// Ask for the answer, by a search with adhesion from "/solve"; after a slider the map is the same.
async function ask(path = "/predict", look = true) {
  clearTimeout(later);
  asking.abort();
  const mine = asking = new AbortController(), body = JSON.stringify(fields());
  let seen = !look;
  $("answer").classList.toggle("old", path === "/predict"); // it belongs to what was asked before
  $("report").hidden = $("save").hidden = true;
  $("all").disabled = true;
  $("stop").hidden = false;
  progress("reading");
  try {
    if (look) for await (const said of lines("/look", body, mine.signal)) {
      if (said.rows) showMap(said);
      else showFaults(said);
      seen = true;
    }
    for await (const said of lines(path, body, mine.signal)) {
      if (said.told) progress(said.told);
      if (said.layers) { layers.solved = said.layers; showLayers(); }
      if (said.answer) take(said.answer, look);
    }
  } catch (error) {
    if (mine.signal.aborted) return;
    $("seen").hidden = !seen;
    fail(error);
  }
  if (mine === asking) $("stop").hidden = true;
}

function take(said, first) {
  $("answer").classList.remove("old");
  progress("");
  $("command").textContent = said.command;
  $("solve").disabled = $("all").disabled = $("same").hidden = false;
  if (first) {
    middle = said.values;
    for (const slider of sliders) {
      slider.value = 0;
      slider.disabled = !split(middle[slider.dataset.for] || "");
      say(slider, middle[slider.dataset.for] || "");
    }
  }
  showAnswer(said);
  if (first) $("verdict").scrollIntoView({ block: "nearest" });
}

function showReport(html) {
  URL.revokeObjectURL($("save").href);
  $("save").href = URL.createObjectURL(new Blob([html], { type: "text/html" }));
  $("report").srcdoc = html;
  $("report").hidden = $("save").hidden = false;
}

const say = (slider, words) => { const place = slider.parentElement.querySelector("output"); if (place) place.textContent = words; };
const split = (words) => { const found = /^([0-9.eE+-]+)(.*)$/.exec(words); return found && [Number(found[1]), found[2]]; };

// Another map has nothing of the one before, not its size, not its bodies, unless that is asked for.
function forget() {
  const before = Object.entries(fields()).filter(([, value]) => value);
  if (before.length) entered = Object.fromEntries(before);
  form.reset();
  middle = {};
  asking.abort();
  progress("");
  for (const slider of sliders) slider.disabled = true;
  for (const id of ["verdict", "answer", "remarks", "same", "seen", "stop"]) $(id).hidden = true;
  $("solve").disabled = true;
  $("again").hidden = !Object.keys(entered).length;
}

function fill(values) {
  for (const [name, value] of Object.entries(values)) {
    const input = form.elements[name];
    if (input.type === "checkbox") input.checked = Boolean(value);
    else input.value = value;
  }
}

// The first file takes the place of what is open, unless it is added; others are added to it.  Until a file has been
// read, and if it cannot be, the map that is open keeps its name, its answer and its buttons.
async function open(files, beside = false) {
  let taken = 0, fault = null;
  try {
    for (const [i, file] of files.entries()) {
      $("reading").textContent = `reading ${file.name}`;
      const said = await talk("/map", file, "PUT", { "X-Name": encodeURIComponent(file.name), ...(beside || i ? { "X-Beside": "1" } : {}) });
      if (said.states) { location = "/states"; return; }
      if (!beside && !i) forget();
      names = said.opened;
      showNames();
      taken += 1;
    }
  } catch (error) { fault = error; }
  $("reading").textContent = "";
  if (taken) await ask();
  if (fault) fail(fault, true);
}

function showNames() {
  $("name").textContent = names.join(form.elements.join.checked ? " + " : " on ");
  $("more").hidden = false;
}

const button = (id, work) => $(id).addEventListener("click", async () => { try { await work(); } catch (error) { fail(error); } });
form.addEventListener("submit", (event) => { event.preventDefault(); ask(); });
document.addEventListener("input", ({ target: slider }) => {
  const name = slider.dataset.for;
  if (!name) return;
  const [value, unit] = split(middle[name]);
  if (name === "contact_modulus") {
    // E* itself instead of the bodies, which also say w and the range.
    for (const other of ["work", "range"]) form.elements[other].value ||= middle[other];
    for (const other of ["material", "modulus", "poisson"]) form.elements[other].value = "";
  }
  if (name === "pressure") form.elements.load.value = "";
  form.elements[name].value = `${Number((value * 10 ** slider.value).toPrecision(3))}${unit}`;
  for (const other of sliders) if (other.dataset.for === name) { other.value = slider.value; say(other, form.elements[name].value); }
  clearTimeout(later);
  later = setTimeout(() => ask("/predict", name === "cutoff"), 150);
});
button("solve", () => ask("/solve", false));
button("stop", () => { asking.abort(); progress(""); $("stop").hidden = true; $("all").disabled = $("answer").hidden; });
button("all", async () => showReport((await talk("/report")).page));
button("example", async () => {
  const said = await talk("/example");
  forget();
  fill(said.form);
  names = said.opened;
  showNames();
  await ask();
});
button("again", async () => { fill(entered); $("again").hidden = true; await ask(); });
$("layer").addEventListener("change", showLayer);
form.elements.join.addEventListener("change", showNames);
for (const id of ["file", "another"]) $(id).addEventListener("change", ({ target }) => {
  const files = [...target.files];
  target.value = ""; // so that the same file can be chosen again
  open(files, id === "another");
});
for (const kind of ["dragover", "dragleave", "drop"]) {
  document.addEventListener(kind, (event) => {
    event.preventDefault();
    $("drop").classList.toggle("over", kind === "dragover");
    if (kind === "drop") open([...event.dataTransfer.files]);
  });
}
if (names.length) { showNames(); ask(); }
