"use strict";
// The page of stored results: the map of one state, its numbers, and the curves on which it lies.
const NAMES = { separation: "separation", mean_gap: "mean gap", load: "load N/A0", area_rep: "A_rep/A0", area_att: "A_att/A0" };
const QUANTITIES = { separation: "length", mean_gap: "length", load: "pressure" };
const KINDS = ["out of range", "attracted", "repulsive"];
let run = null; // the run that is shown
let field = null; // the map that is shown, x slowest
let asked = 0; // maps that come late, after another was asked for, are left out

async function get(path) {
  const answer = await fetch(path);
  if (!answer.ok) throw new Error((await answer.json()).error);
  return answer;
}

function fail(error) { $("error").textContent = error.message; $("error").hidden = false; }

// A number in a0 or E*, and in real units where they are known.
function readable(value, quantity) {
  if (value === null || !quantity) return text(value);
  const [name, size, unit] = quantity === "length" ? ["a0", Number($("a0").value), "nm"] : ["E*", Number($("modulus").value), "GPa"];
  return `${text(value)} ${name}${size > 0 ? ` = ${text(value * size)} ${unit}` : ""}`;
}

const unit = () => Number($("a0").value) > 0 ? [1 / Number($("a0").value), "nm"] : [1, "a0"];

function showMap() {
  const kind = $("kind").value, more = kind === "contact" ? { kinds: field, names: KINDS } : { values: field };
  drawMap($("map"), {
    shape: run.shape, lengths: run.lengths, unit: unit(), key: [unit()[0], `gap (${unit()[1]})`], title: kind, ...more,
    said: (i, j, k) => {
      const words = kind === "gap" ? `gap ${readable(field[k], "length")}` : KINDS[field[k]];
      $("under").textContent = `x = ${readable(i * run.lengths[0] / run.shape[0], "length")}, y = ${readable(j * run.lengths[1] / run.shape[1], "length")}: ${words}`;
    },
  });
}

function showCurve(x, y) {
  const points = run.states.map((state, i) => [state[x], state[y], i]).filter(([a, b]) => a !== null && b !== null);
  if (!points.length) return;
  const ends = (k) => { const all = points.map((point) => point[k]), [a, b] = [Math.min(...all), Math.max(...all)]; return a < b ? [a, b] : [a - 1, b + 1]; };
  const axis = (name, k) => ({ ends: ends(k), label: `${NAMES[name]}${{ length: " (a0)", pressure: " (E*)" }[QUANTITIES[name]] || ""}` });
  drawCurves($("curves"), {
    x: axis(x, 0), y: axis(y, 1), title: `${NAMES[y]} against ${NAMES[x]}`, curves: [points],
    dots: points.map(([a, b, i]) => {
      const here = i === Number($("step").value), fill = here ? "#f08000" : run.states[i].branch === "retract" ? "#fff" : "#05a";
      return [a, b, { r: here ? 6 : 3.5, class: "state", fill }, () => choose(i)];
    }),
  });
}

function showNumbers() {
  const state = run.states[Number($("step").value)];
  const rows = [["status", state.status], ...(state.branch ? [["branch", state.branch]] : []), ...Object.keys(NAMES).map((name) => [NAMES[name], readable(state[name], QUANTITIES[name])])];
  $("numbers").replaceChildren(...rows.map((row) => {
    const line = document.createElement("tr");
    for (const words of row) line.append(Object.assign(document.createElement("td"), { textContent: words }));
    return line;
  }));
  $("which").textContent = `${Number($("step").value) + 1} of ${run.states.length}`;
  $("curves").replaceChildren();
  showCurve("mean_gap", "load");
  showCurve("load", "area_rep");
}

async function choose(step) {
  const mine = ++asked, kind = $("kind").value;
  $("step").value = step;
  showNumbers();
  if (!kind) return;
  try {
    const data = await (await get(`/runs/${$("run").selectedIndex}/${step}/${kind}`)).arrayBuffer();
    if (mine !== asked) return;
    field = kind === "contact" ? new Uint8Array(data) : new Float32Array(data);
    showMap();
    $("map").dataset.shown = `${kind} ${step}`;
  } catch (error) { fail(error); }
}

async function open() {
  $("error").hidden = true;
  try {
    run = await (await get(`/runs/${$("run").selectedIndex}`)).json();
    $("step").max = run.states.length - 1;
    $("kind").replaceChildren(...run.maps.map((name) => new Option(name === "gap" ? "gap between the bodies" : "contact", name)));
    if (run.units.a0) $("a0").value = text(run.units.a0 * 1e9);
    if (run.units.contact_modulus) $("modulus").value = text(run.units.contact_modulus * 1e-9);
    const most = run.states.reduce((best, state, i) => state.area_rep > run.states[best].area_rep ? i : best, 0);
    await choose(most);
  } catch (error) { fail(error); }
}

$("run").addEventListener("change", open);
$("step").addEventListener("input", () => choose(Number($("step").value)));
$("kind").addEventListener("change", () => choose(Number($("step").value)));
for (const id of ["a0", "modulus"]) $(id).addEventListener("input", () => { showNumbers(); if (field) showMap(); });
$("form").addEventListener("submit", (event) => event.preventDefault());
if (known.results) {
  $("name").textContent = `States of ${known.results}`;
  $("run").replaceChildren(...known.runs.map((name) => new Option(name)));
  open();
} else fail(new Error("no results are open: drop a stored run on the other page"));
