"use strict";
// The page of `continuum view`: it sends the form, shows what is said, and draws nothing itself.
const $ = (id) => document.getElementById(id);
const known = JSON.parse($("known").textContent);
const form = $("form");
let middle = {}; // the values at which the sliders began, each a number and its unit
let turn = 0; // answers that come late, after another was asked for, are left out
let later = null;

for (const name of known.materials) $("materials").append(new Option(name));

const fields = () => Object.fromEntries([...new FormData(form)].map(([name, value]) => [name, value.trim()]));

async function talk(method, path, body, headers) {
  const answer = await fetch(path, { method, body, headers });
  const text = await answer.text();
  const json = (answer.headers.get("Content-Type") || "").startsWith("application/json");
  const said = json ? JSON.parse(text) : { text };
  if (!answer.ok) throw new Error(said.error || answer.statusText);
  return said;
}

function say(lines, error = false) {
  $("answer").classList.toggle("error", error);
  $("answer").replaceChildren(...lines.map((line) => Object.assign(document.createElement("p"), { textContent: line })));
}

function fail(error) {
  say([error.message], true);
  for (const id of ["doubts"]) $(id).replaceChildren();
  for (const id of ["command", "export", "report", "mending"]) $(id).hidden = true;
}

function show(html) {
  const url = URL.createObjectURL(new Blob([html], { type: "text/html" }));
  URL.revokeObjectURL($("save").href);
  $("save").href = url;
  $("report").srcdoc = html;
  $("report").classList.remove("old");
  $("report").hidden = $("export").hidden = false;
}

const split = (text) => { const found = /^([0-9.eE+-]+)(.*)$/.exec(text); return found && [Number(found[1]), found[2]]; };

async function ask(sliding = false) {
  const mine = ++turn;
  clearTimeout(later);
  $("report").classList.add("old"); // it belongs to what was asked before
  $("export").hidden = true;
  const body = JSON.stringify(fields());
  try {
    const said = await talk("POST", "/predict", body);
    if (mine !== turn) return;
    say(said.statements);
    $("doubts").replaceChildren(...said.doubts.map((text) => Object.assign(document.createElement("li"), { textContent: text })));
    $("command").hidden = false;
    $("command").querySelector("code").textContent = said.command;
    $("solve").disabled = false;
    if (!sliding) {
      middle = said.values;
      for (const slider of document.querySelectorAll("input[type=range]")) {
        slider.value = 0;
        slider.disabled = !split(middle[slider.dataset.for] || "");
      }
    }
    // The figures take a second or two: they follow when nothing else is asked for.
    later = setTimeout(async () => {
      try {
        const page = await talk("POST", "/report", body);
        if (mine !== turn) return;
        show(page.page);
        $("mending").querySelector("img").src = page.mending;
        $("mending").hidden = false;
      } catch (error) { if (mine === turn) fail(error); }
    }, sliding ? 700 : 0);
  } catch (error) { if (mine === turn) fail(error); }
}

async function open(file) {
  if (!file) return;
  $("name").textContent = `reading ${file.name}`;
  try {
    const said = await talk("PUT", "/map", file, { "X-Name": encodeURIComponent(file.name) });
    if (said.states) { location = "/states"; return; }
    $("name").textContent = said.opened;
    await ask();
  } catch (error) { $("name").textContent = "Drop a height map, or a stored run, here"; fail(error); }
}

async function follow() {
  let said = { solving: true };
  while (said.solving) {
    await new Promise((done) => setTimeout(done, 500));
    said = await talk("GET", "/solve");
    $("progress").textContent = `${said.seconds ?? 0} s: ${(said.said || "").trim().split("\n").pop()}`;
  }
  $("stop").hidden = true;
  if (said.code === 0 || said.code === 1) {
    const page = await talk("GET", "/solved");
    ++turn;
    show(page.text);
    const answer = new DOMParser().parseFromString(page.text, "text/html").querySelector("p.verdict");
    say(answer.textContent.split(/(?<=\.)  /));
  } else if (said.code !== undefined) fail(new Error(said.said));
}

form.addEventListener("submit", (event) => { event.preventDefault(); ask(); });
form.addEventListener("input", (event) => {
  const slider = event.target;
  if (slider.type !== "range") return;
  const name = slider.dataset.for, [value, unit] = split(middle[name]);
  if (name === "contact_modulus") {
    // E* itself instead of the bodies, which also say w and the range.
    for (const other of ["work", "range"]) form.elements[other].value ||= middle[other];
    for (const other of ["material", "modulus", "poisson"]) form.elements[other].value = "";
  }
  form.elements[name].value = `${Number((value * 10 ** slider.value).toPrecision(3))}${unit}`;
  clearTimeout(later);
  later = setTimeout(() => ask(true), 150);
});
$("solve").addEventListener("click", async () => {
  $("progress").textContent = "begins";
  try {
    await talk("POST", "/solve", JSON.stringify(fields()));
    $("stop").hidden = false;
    await follow();
  } catch (error) { fail(error); }
});
$("print").addEventListener("click", () => $("report").contentWindow.print());
$("stop").addEventListener("click", async () => { await talk("DELETE", "/solve"); $("progress").textContent = "stopped"; });
$("file").addEventListener("change", (event) => open(event.target.files[0]));
for (const kind of ["dragover", "dragleave", "drop"]) {
  document.addEventListener(kind, (event) => {
    event.preventDefault();
    $("drop").classList.toggle("over", kind === "dragover");
    if (kind === "drop") open(event.dataTransfer.files[0]);
  });
}
if (known.opened) { $("name").textContent = known.opened; ask(); }
