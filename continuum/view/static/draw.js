"use strict";
// What both pages draw: maps with axes, a key and a scale bar, and curves, each an SVG.
const $ = (id) => document.getElementById(id);
const known = JSON.parse($("known").textContent);
const LENGTHS = [[1e-12, "pm"], [1e-9, "nm"], [1e-6, "µm"], [1e-3, "mm"], [1, "m"]];
const SIDE = 330, WHOLE = SIDE + 175; // widths of a map and of its picture

const text = (value, digits = 4) => value === null ? "-" : String(Number(value.toPrecision(digits)));
const element = (name, of = {}, ...inside) => {
  const node = Object.assign(document.createElement(name), of);
  node.append(...inside);
  return node;
};

function make(name, of, words) {
  const node = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(of)) node.setAttribute(key, value);
  if (words !== undefined) node.textContent = words;
  return node;
}

// The unit in which a length has one to three digits before the point.
const unitOf = (value) => LENGTHS.findLast(([size]) => size <= 1.001 * Math.abs(value)) || LENGTHS[0];

// Numbers with one digit, at most so many between two ends.
function ticks([low, high], log = false, most = 6) {
  const found = [];
  if (log && high > 3 * low) {
    const digits = high > 300 * low ? [1] : [1, 2, 5];
    for (let k = Math.floor(Math.log10(low)); k <= Math.log10(high); k++) for (const digit of digits) found.push(digit * 10 ** k);
  } else {
    const least = (high - low) / most, power = 10 ** Math.floor(Math.log10(least));
    const step = power * [1, 2, 5, 10].find((digit) => digit * power >= least);
    for (let k = Math.ceil(low / step); k * step <= high * (1 + 1e-9); k++) found.push(k * step);
  }
  return found.filter((value) => value >= low && value <= high * (1 + 1e-9)).map((value) => Number(value.toPrecision(6)));
}

// The frame of a picture with its ticks; returns where numbers lie in it.
function axes(svg, [left, top, width, height], x, y) {
  const placed = ({ ends, log }, from, size) => {
    const [a, b] = log ? ends.map(Math.log) : ends;
    return (value) => from + ((log ? Math.log(value) : value) - a) / (b - a) * size;
  };
  const across = placed(x, left, width), up = placed(y, top + height, -height);
  svg.append(make("rect", { x: left, y: top, width, height, class: "frame" }));
  for (const value of ticks(x.ends, x.log)) svg.append(
    make("line", { x1: across(value), x2: across(value), y1: top + height, y2: top + height + 4, class: "frame" }),
    make("text", { x: across(value), y: top + height + 18, "text-anchor": "middle" }, text(value)));
  for (const value of ticks(y.ends, y.log)) svg.append(
    make("line", { x1: left - 4, x2: left, y1: up(value), y2: up(value), class: "frame" }),
    make("text", { x: left - 7, y: up(value) + 4, "text-anchor": "end" }, text(value)));
  svg.append(make("text", { x: left + width / 2, y: top + height + 36, "text-anchor": "middle" }, x.label));
  svg.append(make("text", { transform: `translate(12 ${top + height / 2}) rotate(-90)`, "text-anchor": "middle" }, y.label));
  return [across, up];
}

// A map of numbers, x slowest: `unit` and `key` are [size, name] of lengths and of the numbers.  `kinds`, with their
// names, are whole numbers in place of them; above heights only those beyond the first are coloured.
function drawMap(place, { shape, lengths, values, unit, key, title, kinds, names, said }) {
  const [nx, ny] = shape, colours = known.colours, canvas = element("canvas", { width: nx, height: ny });
  let low = Infinity, high = -Infinity;
  for (const value of values || []) { if (value < low) low = value; if (value > high) high = value; }
  const rgb = (list) => list.map((colour) => parseInt(colour.slice(1), 16)), numbers = rgb(colours.numbers), kind = rgb(colours.contact);
  const scale = kinds ? Array.from({ length: 256 }, (_, i) => 0x010101 * Math.round(90 + 0.6 * i)) : numbers;
  const image = canvas.getContext("2d").createImageData(nx, ny);
  for (let i = 0; i < nx; i++) for (let j = 0; j < ny; j++) {
    const k = i * ny + j, share = high > low ? (values[k] - low) / (high - low) : 0;
    const colour = kinds && (kinds[k] || !values) ? kind[kinds[k]] : scale[Math.round(share * (scale.length - 1))];
    image.data.set([colour >> 16, (colour >> 8) & 255, colour & 255, 255], 4 * ((ny - 1 - j) * nx + i));
  }
  canvas.getContext("2d").putImageData(image, 0, 0);
  const height = SIDE * Math.min(1.6, Math.max(0.1, lengths[1] / lengths[0])), [left, top] = [60, 8];
  const svg = make("svg", { viewBox: `0 0 ${WHOLE} ${height + 50}`, role: "img", "aria-label": title });
  svg.append(make("image", { href: canvas.toDataURL(), x: left, y: top, width: SIDE, height, preserveAspectRatio: "none" }));
  const [across] = axes(svg, [left, top, SIDE, height],
    { ends: [0, lengths[0] / unit[0]], label: `x (${unit[1]})` }, { ends: [0, lengths[1] / unit[0]], label: `y (${unit[1]})` });
  const bar = ticks([0, lengths[0] / unit[0] / 3], false, 4).at(-1), end = left + SIDE - 10, start = end - (across(bar) - left);
  svg.append(make("rect", { x: start - 5, y: top + height - 30, width: end - start + 10, height: 25, class: "plate" }),
    make("rect", { x: start, y: top + height - 13, width: end - start, height: 4 }),
    make("text", { x: (start + end) / 2, y: top + height - 17, "text-anchor": "middle" }, `${text(bar)} ${unit[1]}`));
  const beside = left + SIDE + 12;
  if (kinds) names.forEach((name, k) => svg.append(
    make("rect", { x: beside, y: top + 20 * k, width: 12, height: 12, fill: k || !values ? colours.contact[k] : "#999", stroke: "#666" }),
    make("text", { x: beside + 17, y: top + 11 + 20 * k }, name)));
  else if (high > low) {
    const ends = [low / key[0], high / key[0]], steps = 64;
    for (let k = 0; k < steps; k++) svg.append(make("rect", {
      x: beside, y: top + height * (1 - (k + 1) / steps), width: 12, height: height / steps + 0.5, fill: colours.numbers[Math.round(k / (steps - 1) * 255)] }));
    for (const value of ticks(ends)) svg.append(
      make("text", { x: beside + 16, y: top + 4 + height * (1 - (value - ends[0]) / (ends[1] - ends[0])) }, text(value)));
    svg.append(make("text", { transform: `translate(${beside + 65} ${top + height / 2}) rotate(-90)`, "text-anchor": "middle" }, key[1]));
  }
  svg.addEventListener("mousemove", (event) => {
    const box = svg.getBoundingClientRect(), size = WHOLE / box.width;
    const i = Math.floor(((event.clientX - box.left) * size - left) / SIDE * nx);
    const j = Math.floor((1 - ((event.clientY - box.top) * size - top) / height) * ny);
    if (said && i >= 0 && i < nx && j >= 0 && j < ny) said(i, j, i * ny + j);
  });
  place.replaceChildren(svg);
}

// Curves and a band on two axes; `dots` are [x, y, attributes, what a click does].
function drawCurves(place, { x, y, curves = [], band = [], dots = [], title }) {
  const frame = [70, 10, 300, 200], svg = make("svg", { viewBox: "0 0 385 250", role: "img", "aria-label": title });
  const layer = make("g", {}), [across, up] = axes(svg, frame, x, y), [low, high] = y.ends;
  const within = (value) => up(Math.min(high, Math.max(low, value)));
  const path = (points) => points.map(([a, b]) => `${across(a)},${within(b)}`).join(" ");
  if (band.length) layer.append(make("polygon", { points: path([...band.map(([a, b]) => [a, b]), ...band.map(([a, , c]) => [a, c]).reverse()]), class: "band" }));
  curves.forEach((points, k) => layer.append(make("polyline", { points: path(points), class: `curve c${k}` })));
  for (const [a, b, of, click] of dots) {
    const dot = make("circle", { cx: across(a), cy: within(b), r: 4, ...of });
    if (click) dot.addEventListener("click", click);
    layer.append(dot);
  }
  svg.append(layer);
  place.append(svg);
}
