"""The page of `continuum view`: what it answers, and what hostile requests, names and files get."""

from __future__ import annotations

import asyncio
import base64
import http.client
import inspect
import json
import os
import re
import shlex
import threading
from collections.abc import Iterator
from importlib import resources
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import quote

import h5py
import numpy as np
import pytest

pytest.importorskip("tornado", reason="needs the extra `app`")

import continuum
from continuum.front.cli import main
from continuum.front.options import as_options
from continuum.front.predict import Prediction
from continuum.front.runs import run
from continuum.front.sweeps import sweep
from continuum.inputs.errors import InputError
from continuum.maps.faults import MapFault
from continuum.maps.map import Topography
from continuum.maps.verdict.prediction import prediction_of
from continuum.maps.verdict.tables import OPTIONS
from continuum.model.grid import Grid
from continuum.model.surface import SelfAffine
from continuum.show.answer import statements
from continuum.store.runs.result import Result
from continuum.store.sweeps.workers import Worker
from continuum.view import server
from continuum.view.opened import OpenedMap, View, answer_of, arguments, correction_of, map_layer, safe_name
from continuum.view.server import EXAMPLE, listen

RUN: dict[str, Any] = {
    "grid": {"n": [12, 16]},
    "surface": {"kind": "self-affine", "hurst": 0.8, "rms_slope": 0.1, "lambda_s": 4.0, "lambda_L": 12.0, "seed": 1},
    "wall": {"law": "lennard-jones-spline", "adhesion_length": 0.05},
    "substrate": {"response": "half-space", "mean": "clamped"},
    "loading": {"control": "mean-gap", "targets": [1.2, 0.9]},
    "output": {"fields": True},
}
SWEEP = RUN | {"sweep": {"axes": {"wall.adhesion_length": [0.05, 0.1]}}}
FORM = {"size": "1um", "unit": "nm", "material": "silicon, silicon"}


class Said(NamedTuple):
    status: int
    body: bytes
    headers: http.client.HTTPMessage

    @property
    def json(self) -> dict[str, Any]:
        return dict(json.loads(self.body))


class Client:
    """Speaks to a view as a browser that has its cookie."""

    def __init__(self, view: View) -> None:
        self.view = view

    def __call__(self, method: str, path: str, body: bytes | dict[str, str] | None = None, **headers: str) -> Said:
        connection = http.client.HTTPConnection("127.0.0.1", self.view.port, timeout=60)
        given = {"Cookie": f"stickiness={self.view.token}"} | {k.replace("_", "-"): v for k, v in headers.items()}
        sent = json.dumps(body).encode() if isinstance(body, dict) else body
        try:
            connection.request(method, path, sent, given)
            answer = connection.getresponse()
            return Said(answer.status, answer.read(), answer.headers)
        finally:
            connection.close()


@pytest.fixture(scope="module")
def map_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Heights in nm of a self-affine surface of 1 µm."""
    path = tmp_path_factory.mktemp("map") / "map.npy"
    np.save(path, 15.6 * SelfAffine(0.8, 0.02, 8.0, 32.0).synthesise(Grid.square(64), np.random.default_rng(1)))
    return path


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> Result:
    """A small run, with its gaps."""
    return run(RUN, output=tmp_path_factory.mktemp("run"))


@pytest.fixture
def client(tmp_path: Path) -> Iterator[Client]:
    view, ready, done = View(tmp_path), threading.Event(), asyncio.Event()
    loops = list[asyncio.AbstractEventLoop]()

    async def serve() -> None:
        loops.append(asyncio.get_running_loop())
        listening = listen(view, 0)
        ready.set()
        await done.wait()
        listening.stop()
        await listening.close_all_connections()

    thread = threading.Thread(target=asyncio.run, args=(serve(),))
    thread.start()
    ready.wait()
    yield Client(view)
    loops[0].call_soon_threadsafe(done.set)
    thread.join()
    view.ask()


def asked(client: Client, form: dict[str, str], path: str = "/predict") -> dict[str, Any]:
    """The lines of an answer, together; layers of all."""
    said = client("POST", path, form)
    assert said.status == 200, said.body
    lines = [json.loads(line) for line in said.body.splitlines()]
    found = {name: value for line in lines for name, value in line.items()}
    return found | {"layers": [layer for line in lines for layer in line.get("layers", [])]}


def heights_of(layer: dict[str, Any]) -> np.ndarray:
    return np.frombuffer(base64.b64decode(layer["values"]), "<f4").reshape(layer["shape"])


def test_a_map_is_dropped_and_asked_about(client: Client, map_file: Path) -> None:
    """With the answer of the command for the same words."""
    assert client("POST", "/predict", FORM).status == 409  # no map is open
    form = FORM | {"work": "5J/m2"}
    words: dict[str, Any] = form | {"material": ("silicon", "silicon")}
    opened = client("PUT", "/map", map_file.read_bytes(), X_Name="map.npy").json
    assert opened == {"opened": ["map.npy"], "states": False}
    assert client("POST", "/report").status == 409  # nothing has been answered
    said = asked(client, form)
    found = continuum.predict(map_file, **words)
    answer, threshold = said["answer"], found.threshold
    assert threshold is not None
    assert answer["statements"] == [f"{line}." for line in statements(found)]
    assert said["told"].startswith("pressing map.npy")
    assert answer["row"] == json.loads(found.json())["row"]
    assert [one["work"] for one in answer["curve"]] == [one.work for one in threshold.curve]
    values = {"work": "5J/m2", "contact_modulus": "82.4GPa", "range": "350pm", "cutoff": "62.5nm"}
    assert {name: answer["values"][name] for name in values} == values
    assert (answer["adhesion"] is None) is (found.adhesion is None)
    assert answer["command"].startswith("continuum predict map.npy --size 1um --unit nm --material silicon --mat")
    contact, deciding = map(heights_of, said["layers"])
    assert contact.shape == deciding.shape == (64, 64)
    assert (contact == 2).mean() == pytest.approx(threshold.area_rep, rel=0.1)  # of the map and of its mirror images
    # A slider: the threshold does not depend on w, so that it is not pressed again, and the answer is the same.
    less = asked(client, form | {"work": "1mJ/m2"})
    assert less["told"].startswith("looking at map.npy"), "and it was not pressed"
    assert less["answer"]["statements"][0].startswith("Not sticky")
    again = continuum.predict(map_file, **words | {"work": "1mJ/m2"})
    assert less["answer"]["statements"] == [f"{line}." for line in statements(again)]
    # Nor does it depend on the pressure, which is read off the curve.
    at = asked(client, form | {"work": "1mJ/m2", "pressure": "1MPa"})
    assert at["told"].startswith("looking at map.npy")
    assert at["answer"]["row"]["pressure_Pa"] == 1e6 or at["answer"]["adhesion"] is None
    report = client("POST", "/report")
    assert "data:image/png" in report.json["page"]
    assert less["answer"]["statements"][0] in report.json["page"]
    assert str(client.view.folder).encode() not in report.body


def test_a_map_is_seen_before_any_field_is_filled(client: Client, map_file: Path) -> None:
    """In pixels and in the numbers of its file, with the roughness that is known."""
    client("PUT", "/map", map_file.read_bytes(), X_Name="map.npy")
    said = asked(client, {}, "/look")
    assert said["lacks"] == ["size", "unit"]
    heights = np.load(map_file)
    np.testing.assert_allclose(
        heights_of(said["layers"][1]), heights - heights.mean(), atol=1e-6 * np.abs(heights).max()
    )
    rows = dict(said["rows"])
    assert rows["points"] == "64 x 64"
    assert "Sdq" not in rows
    assert rows["Sq"] == f"{heights_of(said['layers'][0]).std():.3g}"
    known = asked(client, {"size": "1um", "unit": "nm"}, "/look")
    assert known["lacks"] == []
    assert dict(known["rows"])["Sq"] == f"{rows['Sq']} nm"
    assert "Sdq" in dict(known["rows"])
    client("PUT", "/map", b"no map at all", X_Name="map.npy")
    assert client("POST", "/look", {}).status == 422
    # Of a line scan, here with positions of unknown unit, a surface with its spectrum is seen, and not as measured.
    line = np.stack([np.arange(256.0), np.random.default_rng(1).normal(size=256)], 1)
    client("PUT", "/map", "\n".join(f"{x} {h}" for x, h in line).encode(), X_Name="line.txt")
    scan = asked(client, {}, "/look")
    assert sorted(scan["lacks"]) == ["size", "unit"]
    assert [layer["name"] for layer in scan["layers"]] == ["a random surface with the measured spectrum"]


def test_a_fault_can_be_shown_and_corrected(client: Client) -> None:
    """Of the example: what its correction takes off are its scars, and with its fields the fault is gone."""
    opened = client("POST", "/example").json
    assert opened["opened"] == [EXAMPLE]
    (fault,) = (said := asked(client, opened["form"], "/look"))["faults"]
    assert "scars" in fault["text"]
    assert fault["set"] == {"fill": "5%"}
    taken = heights_of(next(layer for layer in said["layers"] if layer["name"] == fault["layer"]))
    assert (taken != 0).mean() == pytest.approx(0.012, abs=0.001)  # as many points as the fault says
    assert asked(client, opened["form"] | fault["set"], "/look")["faults"] == []


def test_a_spike_is_seen_on_a_map_of_more_points_than_are_drawn() -> None:
    heights = 1e-9 * np.random.default_rng(1).normal(size=(1030, 16))
    heights[517, 5] += 1e-6
    fault = MapFault("spikes", "", {"fill": "5%"})
    taken = correction_of(Topography(heights, (1e-6, 1e-6)), fault)
    assert taken is not None
    assert heights_of(map_layer("", Topography(heights, (1e-6, 1e-6)), taken)).max() == pytest.approx(1e-6, rel=0.01)


def test_two_bodies_or_joined_maps_are_of_two_files(client: Client, map_file: Path) -> None:
    for more in ({}, {"X_Beside": "1"}):
        opened = client("PUT", "/map", map_file.read_bytes(), X_Name="map.npy", **more).json["opened"]
    assert opened == ["map.npy", "map.npy"]
    view = client.view
    assert view.opened is not None
    of_two = shlex.split(view.opened.command(FORM | {"size": "1um; 2um", "join": "on"}))
    assert of_two[:8] == ["continuum", "predict", "map.npy", "map.npy", "--size", "1um", "--size", "2um"]
    assert of_two[-1] == "--join"
    first, _, second, _ = asked(client, FORM, "/look")["layers"]
    assert len(asked(client, FORM | {"join": "on"}, "/look")["layers"]) == 1
    # The contact is drawn on the heights of both.
    both, contact, _ = asked(client, FORM)["layers"]
    np.testing.assert_allclose(heights_of(both), heights_of(first) + heights_of(second)[::-1], rtol=1e-5, atol=1e-15)
    assert contact["shape"] == both["shape"]
    client("PUT", "/map", map_file.read_bytes(), X_Name="map.npy")
    assert len(list(view.folder.glob("*/map.npy"))) == 1


def test_of_waiting_questions_the_last_is_answered(client: Client, map_file: Path) -> None:
    client.view.open(map_file, "map.npy")
    opened = client.view.opened
    assert opened is not None

    def told(text: str) -> None:
        raise InputError(text)

    with pytest.raises(InputError, match="looking"):  # before the work begins
        opened.predict(FORM, told=told)


def test_the_page_has_a_field_for_every_key_that_it_may_send() -> None:
    static = resources.files("continuum.view") / "static"
    page = (static / "index.html").read_text()
    assert set(re.findall(r'name="(\w+)"', page)) - {"viewport"} == OPTIONS.keys()
    ids = set(re.findall(r'id="(\w+)"', page))
    for script in ("view.js", "draw.js"):
        assert set(re.findall(r'\$\("(\w+)"\)', (static / script).read_text())) <= ids, script
    assert page.index("<section>") < page.index("<form"), "on a narrow screen the answer comes first"


def example(name: str) -> str:
    """What the form suggests for an option."""
    page = (resources.files("continuum.view") / "static" / "index.html").read_text()
    (field,) = re.findall(rf'<\w+ [^>]*name="{name}".*?</label>', page)
    if "checkbox" in field:
        return "on"
    *_, found = re.findall(r"<option>(\w+)", field) or re.findall(r'placeholder="(.+?)"', field)
    return str(found)


@pytest.mark.usefixtures("unpressed")
@pytest.mark.parametrize("option", OPTIONS)
def test_an_option_has_the_answer_that_the_terminal_has_for_the_same_words(
    option: str, map_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Or the same refusal; of two maps, whose files say the unit, and that are not pressed.

    Where both ask the same of the same maps, one prediction is made for both.
    """
    made = dict[object, Any]()

    def once(maps: list[Topography], *of: object) -> Any:
        key = tuple((one.digest, one.lengths, one.steps, one.source) for one in maps), repr(of)
        return made[key] if key in made else made.setdefault(key, prediction_of(maps, *of))

    monkeypatch.setattr("continuum.front.predict.prediction_of", once)
    monkeypatch.setattr(Prediction, "write", lambda *given: ["page"])
    monkeypatch.chdir(tmp_path)
    names = ("one.h5", "two.h5")
    for name in names:
        with h5py.File(name, "w") as file:
            for dataset in ("heights", "others"):
                file[dataset] = np.load(map_file)[:48, :44]
                file[dataset].attrs["unit"] = "nm"
    opened = OpenedMap(tuple(map(Path, names)), names, tmp_path)
    # An overruled unit, and what cannot be given together.
    base = {
        "dataset": "heights",
        "size": "1um",
        "material": "silicon",
        "unit": "um" if option == "override_size" else "",
    }
    form = {option: example(option)}
    if option == "contact_modulus":
        base |= {"material": "", "work": "50mJ/m2", "range": "0.5nm"}
    form = base | form
    words = shlex.split(opened.command(form))[1:]
    refusal, said = "", {}
    try:
        said = answer_of(opened.predict(form))
    except InputError as error:
        refusal = as_options(str(error), inspect.signature(continuum.predict).parameters)
    assert bool(refusal) == (option == "part"), "there are no parts in these files"
    assert main([*words, "--json", "answer.json"]) == (2 if refusal else 0)
    told = capsys.readouterr()
    if refusal:
        assert refusal in told.err
        return
    data = json.loads(Path("answer.json").read_text())
    assert {name: data[name] for name in ("row", "curve")} == {name: said[name] for name in ("row", "curve")}
    assert data["warnings"] == said["doubts"]
    lines = told.out.splitlines()[:-2]  # the others name files
    # The page has buttons for faults.
    assert [line for line in lines if not line.startswith("Faulty map")] == said["statements"]


def test_states_of_a_run_are_those_that_are_stored(client: Client, stored: Result) -> None:
    assert client("GET", "/runs/0").status == 409
    assert client("PUT", "/map", stored.path.read_bytes(), X_Name="run.h5").json == {
        "opened": ["run.h5"],
        "states": True,
    }
    assert b'"runs": ["run.h5"]' in client("GET", "/states").body
    said = client("GET", "/runs/0").json
    assert said["shape"] == [12, 16]
    assert said["maps"] == ["contact", "gap"]
    assert [state["load"] for state in said["states"]] == [point.load for point in stored.points]
    step = len(stored.points) - 1
    contact = np.frombuffer(client("GET", f"/runs/0/{step}/contact").body, np.uint8)
    np.testing.assert_array_equal(contact.reshape(12, 16), stored.contact_map(step))
    gap = np.frombuffer(client("GET", f"/runs/0/{step}/gap").body, "<f4")
    np.testing.assert_array_equal(gap.reshape(12, 16), stored.gap(step))
    for path in ("/runs/1", f"/runs/0/{step + 1}/gap", "/runs/0/0/heights", "/runs/0/0/config"):
        assert client("GET", path).status == 422
    assert client("GET", "/runs/-1").status == 404
    # A map takes the place of no result, nor the other way round.
    assert client("POST", "/predict", FORM).status == 409


def test_states_of_a_sweep_are_chosen_by_its_axes(client: Client, tmp_path: Path) -> None:
    root = tmp_path / "sweep"
    sweep(SWEEP, output=tmp_path, name="sweep", workers=1)
    client.view.open(root, "sweep")
    assert client.view.results is not None
    assert list(client.view.results.runs) == ["adhesion_length 0.05", "adhesion_length 0.1"]
    loads = [client("GET", f"/runs/{i}").json["states"][0]["load"] for i in range(2)]
    assert loads[0] > loads[1]
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="not the folder of a sweep"):
        client.view.open(tmp_path / "empty", "empty")


@pytest.mark.parametrize("harm", ["link", "shape", "grid", "huge"])
def test_a_hostile_file_of_states_is_refused(client: Client, stored: Result, tmp_path: Path, harm: str) -> None:
    path = tmp_path / "hostile.h5"
    path.write_bytes(stored.path.read_bytes())
    with h5py.File(path, "r+") as file:
        if harm == "link":
            del file["gap"]
            file["gap"] = h5py.ExternalLink(str(stored.path), "gap")
        elif harm == "shape":
            del file["gap"]
            file["gap"] = np.zeros((2, 3, 3), np.float32)
        elif harm == "huge":  # in whole periods, as a grid may be
            text = file.attrs["config_resolved"].decode()
            file.attrs["config_resolved"] = text.replace("[12,16]", "[12000,16000]")
        else:
            file.attrs["config_resolved"] = file.attrs["config_resolved"].decode().replace("[12,16]", "[9999,9999]")
    client("PUT", "/map", path.read_bytes(), X_Name="hostile.h5")
    said = [client("GET", "/runs/0"), client("GET", "/runs/0/0/contact"), client("GET", "/runs/0/0/gap")]
    assert said[-1].status == 422
    # The contact map is a dataset of the file itself: a link beside it is not followed.
    assert said[1].status == (200 if harm in ("shape", "link") else 422)
    assert all(str(client.view.folder) not in one.body.decode(errors="replace") for one in said)


BUTTONS = {
    # What a button of the page asks of the program first; "" where it asks nothing.
    "example": "/example",
    "ask": "/predict",
    "solve": "/solve",
    "all": "/report",
    "again": "/predict",
    "stop": "",
}


def test_every_button_of_the_page_is_known_here() -> None:
    static = resources.files("continuum.view") / "static"
    assert set(re.findall(r'<button [^>]*id="(\w+)"', (static / "index.html").read_text())) == BUTTONS.keys()
    assert "<button" not in (static / "states.html").read_text()
    script = (static / "view.js").read_text()
    works = dict(re.findall(r'^button\("(\w+)", (.*?)\);$', script, re.MULTILINE | re.DOTALL))
    works["ask"] = re.findall(r'"submit", .*', script)[0]
    assert 'function ask(path = "/predict"' in script
    asks = {button: re.search(r'"(/\w+)"|\bask\(\)', work) for button, work in works.items()}
    assert {button: found[1] or "/predict" if found else "" for button, found in asks.items()} == BUTTONS


def test_every_button_is_answered(client: Client) -> None:
    """Solving is in a process of its own, from which the prediction comes back: on a map so small that it is short."""
    opened = client("POST", BUTTONS["example"])
    assert (opened.status, opened.json["opened"]) == (200, [EXAMPLE])
    heights = 4.0 * SelfAffine(0.8, 0.02, 4.0, 16.0).synthesise(Grid.square(16), np.random.default_rng(1))
    client("PUT", "/map", "\n".join(" ".join(map(str, row)) for row in heights).encode(), X_Name="map.txt")
    form = FORM | {"size": "16nm", "work": "1mJ/m2", "periodic": "on"}
    pressed = asked(client, form, BUTTONS["ask"])
    assert pressed["answer"]["row"]["w_c from"] != "search"
    said = asked(client, form, BUTTONS["solve"])
    assert said["told"].startswith("searching for the threshold")
    assert said["answer"]["row"]["w_c from"] == "search"
    assert "by a search with adhesion" in said["answer"]["statements"][1]
    assert said["answer"]["command"].endswith("--solve")
    assert [layer["kind"] for layer in said["layers"]] == ["contact", "deciding"]
    assert said["answer"]["statements"][1] in client("POST", BUTTONS["all"]).json["page"]


@pytest.mark.parametrize("how", ["asked", "closed"])
def test_the_solver_is_stopped(client: Client, map_file: Path, how: str) -> None:
    """By another question, or by the browser that asked."""
    client("PUT", "/map", map_file.read_bytes(), X_Name="map.npy")
    view, began = client.view, threading.Event()

    class Begins(Worker):
        def give(self, work: Any, task: Any) -> None:
            super().give(work, task)
            began.set()

    view.searching = Begins(os.environ)
    connection = http.client.HTTPConnection("127.0.0.1", view.port, timeout=60)
    connection.request("POST", "/solve", json.dumps(FORM), {"Cookie": f"stickiness={view.token}"})
    assert began.wait(60)
    process = view.searching._process
    assert process is not None
    if how == "asked":
        assert client("POST", "/predict", {"size": "1"}).status == 422
        assert b"the search has ended" in connection.getresponse().read()
    connection.close()
    assert process.wait(60) != 0


def test_what_is_wrong_is_said_as_the_command_says_it(client: Client, map_file: Path) -> None:
    client("PUT", "/map", map_file.read_bytes(), X_Name="map.npy")
    for form, words in (
        ({"material": "silicon"}, "size"),
        (FORM | {"work": "50"}, "unit"),
        (FORM | {"material": "cheese"}, "cheese"),
        (FORM | {"detrend": "everything"}, "everything"),
        (FORM | {"output": "/etc"}, "output"),
        (FORM | {"size": 3}, "size"),
    ):
        said = client("POST", "/predict", form)
        assert said.status == 422
        assert words in said.json["error"]
        assert str(client.view.folder) not in said.json["error"]
    client("PUT", "/map", b"no map at all", X_Name="map.npy")
    assert client("POST", "/predict", FORM).status == 422
    assert client("POST", "/predict", b"[1]").status == 400


def test_nobody_else_is_answered(client: Client) -> None:
    port = client.view.port
    assert client("GET", "/").status == 200
    assert client("GET", "/", Cookie="").status == 403
    assert client("GET", "/", Cookie="stickiness=guess").status == 403
    assert client("GET", "/?token=guess", Cookie="").status == 403
    assert client("GET", "/", Host="rebound.example").status == 403
    assert client("POST", "/predict", FORM, Origin="http://other.example").status == 403
    assert client("GET", "/", Host=f"localhost:{port}", Origin=f"http://localhost:{port}").status == 200
    # The token is in the address once, then in a cookie that no script reads.
    said = client("GET", f"/?token={client.view.token}", Cookie="")
    assert said.status == 302
    assert said.headers["Location"] == "/"
    assert {"HttpOnly", "SameSite=Strict"} <= set(said.headers["Set-Cookie"].split("; "))
    assert "default-src 'none'" in said.headers["Content-Security-Policy"]


@pytest.mark.parametrize(
    "path", ["/../server.py", "/view.js/../../server.py", "/etc/passwd", "/%2e%2e/opened.py", "/index.html"]
)
def test_no_file_of_the_disk_is_handed_out(client: Client, path: str) -> None:
    assert client("GET", path).status == 404


@pytest.mark.parametrize(
    ("name", "kept"),
    [
        ("../../etc/passwd", "passwd"), ("..\\..\\boot.ini", "boot.ini"), ("a b;rm -rf ~.npy", "a_b_rm_-rf_.npy"),
        ("", "map"), ("...", "map"), ("/", "map"), (".bashrc", "bashrc"), ("Höhe.txt", "H_he.txt"),
        ("x" * 500, "x" * 80),
    ],
)  # fmt: skip
def test_a_name_is_never_a_place(client: Client, name: str, kept: str) -> None:
    assert safe_name(name) == kept
    if len(name) < 200:
        assert client("PUT", "/map", b"1 2\n3 4\n", X_Name=quote(name)).json["opened"] == [kept]
    assert client.view.opened is None or client.view.folder in client.view.opened.paths[0].parents


def test_an_upload_has_a_size_and_is_a_map(client: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("mine.TOML", "mine.toml~", "mine.toml.", "mine.toml _", "there/mine.toml~"):
        said = client("PUT", "/map", b"[topography]", X_Name=quote(name))
        assert (said.status, list(client.view.folder.iterdir())) == (422, []), name
    monkeypatch.setattr(server, "LARGEST", 1000)
    assert client("PUT", "/map", b"0" * 1001, X_Name="map.txt").status == 413
    assert client.view.opened is None


def test_a_map_is_never_read_as_an_input_that_names_other_files(client: Client, tmp_path: Path) -> None:
    """Whatever it is called."""
    np.savetxt(tmp_path / "secret.txt", np.random.default_rng(1).normal(size=(16, 16)))
    described = f'[topography]\nmaps = ["{tmp_path}/secret.txt"]\n[interface]\nmaterial = ["silicon"]\n'
    (tmp_path / "mine.toml").write_text(described)
    client.view.open(tmp_path / "mine.toml", "mine.toml")
    said = client("POST", "/predict", FORM)
    assert said.status == 422
    assert "mine.toml" in said.json["error"]


def test_what_is_replaced_or_refused_is_deleted_and_nothing_of_the_user(
    client: Client, stored: Result, map_file: Path
) -> None:
    client.view.open(map_file, "map.npy")
    client.view.open(stored.path, "run.h5")
    kept = []
    for _ in range(2):
        client("PUT", "/map", b"1 2\n3 4\n", X_Name="map.txt")
        client("PUT", "/map", stored.path.read_bytes(), X_Name="run.h5")
        assert client("POST", "/map", b"1 2\n3 4\n", X_Name="map.txt").status == 405
        assert client("PUT", "/map", None, X_Name="map.txt", Content_Length="abc").status == 411
        kept.append(sorted(file.name for file in client.view.folder.glob("*/*")))
        assert len(list(client.view.folder.iterdir())) == 3, "of the map, of what was made of it, and of the run"
    assert kept == [["map.txt", "run.h5"]] * 2
    assert map_file.is_file()
    assert stored.path.is_file()


def test_no_request_is_a_fault_of_the_server(client: Client, caplog: pytest.LogCaptureFixture) -> None:
    client("PUT", "/map", b"1 2\n3 4\n", X_Name="map.txt")
    requests: list[tuple[str, str, bytes | None, dict[str, str]]] = [
        ("POST", "/predict", b"[" * 100_000, {}),
        ("POST", "/predict", b'{"size": "\\ud800"}', {}),
        ("POST", "/predict", b"\xff", {}),
        *(("PUT", "/map", None, {"Content_Length": length}) for length in ("abc", "-1", "9" * 5000, "\xb2")),
        ("PUT", "/map", None, {"Transfer_Encoding": "chunked"}),
        ("POST", "/predict", None, {"Content_Length": "abc"}),
        *((method, path, None, {}) for method in ("FOO", "TRACE", "DELETE", "HEAD") for path in ("/", "/map")),
        ("GET", "/?token=%ff", None, {}),
    ]
    for method, path, body, headers in requests:
        said = client(method, path, body, **headers)
        assert 400 <= said.status < 500, (method, path, headers)
        assert not said.body or said.json["error"]
    assert not [record for record in caplog.records if record.levelname == "ERROR"]


def test_a_page_that_says_script_is_shown_as_text(client: Client) -> None:
    heights = "\n".join(" ".join(map(str, row)) for row in np.random.default_rng(1).normal(size=(16, 16)).round(3))
    client("PUT", "/map", heights.encode(), X_Name=quote("<script>alert(1)</script>.txt"))
    assert b"<script>alert" not in client("GET", "/").body
    assert b"<script>alert" not in client("POST", "/look", FORM).body


def test_fields_are_those_of_the_form() -> None:
    assert arguments({"material": "gold, silica", "work": " 1mJ/m2 ", "fill": ""}) == {
        "material": ("gold", "silica"),
        "work": "1mJ/m2",
    }
    several = {"size": "1um,2um; 3um", "periodic": "on", "void": "99999"}
    assert arguments(several) == {"size": ("1um,2um", "3um"), "periodic": True, "void": "99999"}
    for form in ({"solve": "1"}, {"work": "1" * 201}, {"threads": "8"}):
        with pytest.raises(InputError):
            arguments(form)


def test_the_command_refuses_what_cannot_be_opened(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["view", str(tmp_path / "none.npy"), "--no-browser"]) == 2
    assert "no such file" in capsys.readouterr().err
    assert main(["view", "a", "b"]) == 2
    assert main(["view", "--port", "99999"]) == 2
