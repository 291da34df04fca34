"use strict";
// The page of stored results: the map of one state, its numbers, and the curves on which it lies.
const $ = (id) => document.getElementById(id);
const known = JSON.parse($("known").textContent);
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

const text = (value, digits = 4) => value === null ? "-" : String(Number(value.toPrecision(digits)));

// A number in a0 or E*, and in real units where they are known.
function readable(value, quantity) {
  if (value === null || !quantity) return text(value);
  const [name, size, unit] = quantity === "length" ? ["a0", Number($("a0").value), "nm"] : ["E*", Number($("modulus").value), "GPa"];
  return `${text(value)} ${name}${size > 0 ? ` = ${text(value * size)} ${unit}` : ""}`;
}

function drawMap() {
  const [nx, ny] = run.shape, canvas = $("map"), colours = known.colours[$("kind").value];
  const rgb = colours.map((colour) => parseInt(colour.slice(1), 16));
  canvas.width = nx;
  canvas.height = ny;
  canvas.style.aspectRatio = `${run.lengths[0]} / ${run.lengths[1]}`;
  let low = 0, high = colours.length - 1;
  if ($("kind").value === "gap") {
    [low, high] = [Infinity, -Infinity];
    for (const value of field) { if (value < low) low = value; if (value > high) high = value; }
  }
  const image = canvas.getContext("2d").createImageData(nx, ny);
  for (let i = 0; i < nx; i++) for (let j = 0; j < ny; j++) {
    const share = high > low ? (field[i * ny + j] - low) / (high - low) : 0;
    const colour = rgb[Math.round(share * (rgb.length - 1))], at = 4 * ((ny - 1 - j) * nx + i);
    image.data.set([colour >> 16, (colour >> 8) & 255, colour & 255, 255], at);
  }
  canvas.getContext("2d").putImageData(image, 0, 0);
  $("key").textContent = $("kind").value === "gap" ? `dark ${readable(low, "length")}, bright ${readable(high, "length")}` : "orange repulsive, black attracted";
}

function drawCurve(x, y) {
  const [width, height, left, low] = [380, 250, 70, 40], make = (name, of, words) => {
    const node = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(of)) node.setAttribute(key, value);
    if (words !== undefined) node.textContent = words;
    return node;
  };
  const svg = make("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": `${NAMES[y]} against ${NAMES[x]}` });
  const points = run.states.map((state, i) => [state[x], state[y], i]).filter(([a, b]) => a !== null && b !== null);
  if (!points.length) return;
  const ends = (k) => { const all = points.map((point) => point[k]), [a, b] = [Math.min(...all), Math.max(...all)]; return a < b ? [a, b] : [a - 1, b + 1]; };
  const [[x0, x1], [y0, y1]] = [ends(0), ends(1)];
  const across = (value) => left + (value - x0) / (x1 - x0) * (width - left - 20), up = (value) => height - low - (value - y0) / (y1 - y0) * (height - low - 12);
  if (y0 < 0 && y1 > 0) svg.append(make("line", { x1: left, x2: width, y1: up(0), y2: up(0), stroke: "#bbb" }));
  svg.append(make("polyline", { points: points.map(([a, b]) => `${across(a)},${up(b)}`).join(" "), fill: "none", stroke: "#888" }));
  for (const [a, b, i] of points) {
    const here = i === Number($("step").value);
    const dot = make("circle", { cx: across(a), cy: up(b), r: here ? 6 : 3.5, class: "state", fill: here ? "#f08000" : run.states[i].branch === "retract" ? "#fff" : "#05a", stroke: "#05a" });
    dot.addEventListener("click", () => choose(i));
    svg.append(dot);
  }
  for (const [value, at] of [[x0, "start"], [x1, "end"]]) svg.append(make("text", { x: across(value), y: height - 22, "text-anchor": at }, text(value, 3)));
  for (const value of [y0, y1]) svg.append(make("text", { x: left - 6, y: up(value) + 4, "text-anchor": "end" }, text(value, 3)));
  svg.append(make("text", { x: (width + left) / 2, y: height - 6, "text-anchor": "middle" }, `${NAMES[x]}${QUANTITIES[x] === "length" ? " (a0)" : ""}`));
  svg.append(make("text", { x: 12, y: height / 2 - 20, "text-anchor": "middle", transform: `rotate(-90 12 ${height / 2 - 20})` }, `${NAMES[y]}${QUANTITIES[y] ? " (E*)" : ""}`));
  $("curves").append(svg);
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
  drawCurve("mean_gap", "load");
  drawCurve("load", "area_rep");
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
    drawMap();
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

$("map").addEventListener("mousemove", (event) => {
  if (!field) return;
  const box = $("map").getBoundingClientRect(), [nx, ny] = run.shape;
  const i = Math.min(nx - 1, Math.floor((event.clientX - box.left) / box.width * nx));
  const j = Math.min(ny - 1, Math.max(0, ny - 1 - Math.floor((event.clientY - box.top) / box.height * ny)));
  const value = field[i * ny + j];
  const words = $("kind").value === "gap" ? `gap ${readable(value, "length")}` : KINDS[value];
  $("under").textContent = `x = ${readable(i * run.lengths[0] / nx, "length")}, y = ${readable(j * run.lengths[1] / ny, "length")}: ${words}`;
});
$("run").addEventListener("change", open);
$("step").addEventListener("input", () => choose(Number($("step").value)));
$("kind").addEventListener("change", () => choose(Number($("step").value)));
for (const id of ["a0", "modulus"]) $(id).addEventListener("input", () => { showNumbers(); if (field) drawMap(); });
$("form").addEventListener("submit", (event) => event.preventDefault());
if (known.results) {
  $("name").textContent = `States of ${known.results}`;
  $("run").replaceChildren(...known.runs.map((name) => new Option(name)));
  open();
} else fail(new Error("no results are open: drop a stored run on the other page"));
