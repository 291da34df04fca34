"""The page of `continuum view`: what it answers, and what hostile requests, names and files get."""

from __future__ import annotations

import asyncio
import base64
import http.client
import json
import re
import threading
import time
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
from continuum.app import server
from continuum.app.opened import EXAMPLE, EXAMPLE_FORM, arguments, safe_name
from continuum.app.server import View, listen
from continuum.cli import main
from continuum.errors import InputError
from continuum.files.toml import find
from continuum.front.commands import run
from continuum.front.sweeps import sweep
from continuum.model.grid import Grid
from continuum.model.surface import SelfAffine
from continuum.runs.result import Result
from continuum.show.answer import statements
from continuum.sticky.tables import OPTIONS

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
    view.stop()


def asked(client: Client, form: dict[str, str]) -> dict[str, Any]:
    """The lines of an answer, together."""
    said = client("POST", "/predict", form)
    assert said.status == 200, said.body
    return {name: value for line in said.body.splitlines() for name, value in json.loads(line).items()}


def heights_of(layer: dict[str, Any]) -> np.ndarray:
    return np.frombuffer(base64.b64decode(layer["values"]), "<f4").reshape(layer["shape"])


def test_a_map_is_dropped_and_asked_about(client: Client) -> None:
    """With the answer of the command for the same words."""
    assert client("POST", "/predict", FORM).status == 409  # no map is open
    wafer, form = find(EXAMPLE), EXAMPLE_FORM | {"fill": "5%"}
    words: dict[str, Any] = form | {"material": ("silicon", "silicon")}
    opened = client("PUT", "/map", wafer.read_bytes(), X_Name="wafer.txt").json
    assert opened == {"opened": ["wafer.txt"], "states": False}
    assert client("POST", "/report").status == 409  # nothing has been answered
    said = asked(client, form)
    found = continuum.predict(wafer, **words)
    answer, threshold = said["answer"], found.threshold
    assert threshold is not None
    assert answer["statements"] == [f"{line}." for line in statements(found)]
    assert said["told"].startswith("pressing wafer.txt")
    assert answer["row"] == json.loads(found.json())["row"]
    assert [one["work"] for one in answer["curve"]] == [one.work for one in threshold.curve]
    assert answer["values"] == {"work": "100mJ/m2", "contact_modulus": "82.4GPa", "range": "350pm", "cutoff": "8nm"}
    assert answer["command"].startswith("continuum predict wafer.txt --size 384nm --unit nm --material silicon --mat")
    contact, deciding = map(heights_of, said["layers"])
    assert contact.shape == deciding.shape == (192, 192)
    assert (contact == 2).mean() == pytest.approx(threshold.area_rep, rel=0.05)  # of the map and of its mirror images
    # A slider: the threshold does not depend on w, so that it is not pressed again, and the answer is the same.
    less = asked(client, form | {"work": "10mJ/m2"})
    assert less["told"].startswith("looking at wafer.txt"), "and it was not pressed"
    assert less["answer"]["statements"][0].startswith("Not sticky")
    again = continuum.predict(wafer, **words, work="10mJ/m2")
    assert less["answer"]["statements"] == [f"{line}." for line in statements(again)]
    report = client("POST", "/report")
    assert "data:image/png" in report.json["page"]
    assert less["answer"]["statements"][0] in report.json["page"]
    assert str(client.view.folder).encode() not in report.body
    assert client("GET", "/solved").status == 422  # it has not been solved


def test_a_map_is_seen_before_any_field_is_filled(client: Client, map_file: Path) -> None:
    """In pixels and in the numbers of its file, with the roughness that is known."""
    client("PUT", "/map", map_file.read_bytes(), X_Name="map.npy")
    said = client("POST", "/look", {}).json
    assert said["lacks"] == ["size", "unit"]
    heights = np.load(map_file)
    np.testing.assert_allclose(
        heights_of(said["layers"][1]), heights - heights.mean(), atol=1e-6 * np.abs(heights).max()
    )
    rows = dict(said["rows"])
    assert rows["points"] == "64 x 64"
    assert "Sdq" not in rows
    assert rows["Sq"] == f"{heights_of(said['layers'][0]).std():.3g}"
    known = client("POST", "/look", {"size": "1um", "unit": "nm"}).json
    assert known["lacks"] == []
    assert dict(known["rows"])["Sq"] == f"{rows['Sq']} nm"
    assert "Sdq" in dict(known["rows"])
    client("PUT", "/map", b"no map at all", X_Name="map.npy")
    assert client("POST", "/look", {}).status == 422


def test_a_fault_can_be_shown_and_corrected(client: Client) -> None:
    """Of the example: what its correction takes off are its scars, and with its fields the fault is gone."""
    opened = client("POST", "/example").json
    assert opened["opened"] == [EXAMPLE]
    (fault,) = (said := client("POST", "/look", opened["form"]).json)["faults"]
    assert "scars" in fault["text"]
    assert fault["set"] == {"fill": "5%"}
    taken = heights_of(next(layer for layer in said["layers"] if layer["name"] == fault["layer"]))
    assert (taken != 0).mean() == pytest.approx(0.012, abs=0.001)  # as many points as the fault says
    assert client("POST", "/look", opened["form"] | fault["set"]).json["faults"] == []


def test_two_bodies_or_joined_maps_are_of_two_files(client: Client, map_file: Path) -> None:
    for more in ({}, {"X_Beside": "1"}):
        opened = client("PUT", "/map", map_file.read_bytes(), X_Name="map.npy", **more).json["opened"]
    assert opened == ["map.npy", "map.npy"]
    view = client.view
    assert view.opened is not None
    of_two = view.opened.command(FORM | {"size": "1um; 2um", "join": "on"})
    assert of_two[:8] == ["continuum", "predict", "map.npy", "map.npy", "--size", "1um", "--size", "2um"]
    assert of_two[-1] == "--join"
    assert len(client("POST", "/look", FORM).json["layers"]) == 4
    assert len(client("POST", "/look", FORM | {"join": "on"}).json["layers"]) == 2
    client("PUT", "/map", map_file.read_bytes(), X_Name="map.npy")
    assert len(list(view.folder.glob("map-*"))) == 1


def test_of_waiting_questions_the_last_is_answered(client: Client, map_file: Path) -> None:
    client.view.open(map_file, "map.npy")
    opened = client.view.opened
    assert opened is not None

    def told(text: str) -> None:
        raise InputError(text)

    with pytest.raises(InputError, match="looking"):  # before the work begins
        opened.predict(FORM, told=told)


def test_the_page_has_a_field_for_every_key_that_it_may_send() -> None:
    static = resources.files("continuum.app") / "static"
    page = (static / "index.html").read_text()
    names = set(re.findall(r'name="(\w+)"', page)) - {"viewport"}
    # A size that the file says, a dataset, and a0, which decides nothing, are for the command.
    assert names == OPTIONS.keys() - {"override_size", "dataset", "spacing"}
    ids = set(re.findall(r'id="(\w+)"', page))
    for script in ("view.js", "draw.js"):
        assert set(re.findall(r'\$\("(\w+)"\)', (static / script).read_text())) <= ids, script
    assert page.index("<section>") < page.index("<form"), "on a narrow screen the answer comes first"


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
    assert said[1].status == (200 if harm == "shape" else 422)
    assert all(str(client.view.folder) not in one.body.decode(errors="replace") for one in said)


@pytest.mark.long  # the whole command, with its figures, in a process of its own
def test_a_map_is_solved(client: Client, map_file: Path) -> None:
    client("PUT", "/map", map_file.read_bytes(), X_Name="map.npy")
    assert client("POST", "/solve", FORM).json == {"solving": True}
    while (state := client("GET", "/solve").json)["solving"]:
        time.sleep(0.1)
    assert state["code"] == 0, state
    assert "searching for the threshold" in state["said"]
    said = client("GET", "/solved").json
    assert said["answer"]["row"]["w_c from"] == "search"
    assert "by a search with adhesion" in said["answer"]["statements"][1]
    assert str(client.view.folder) not in json.dumps(said["answer"])
    assert said["answer"]["statements"][1] in said["page"]


def test_the_solver_is_stopped(client: Client, map_file: Path) -> None:
    client("PUT", "/map", map_file.read_bytes(), X_Name="map.npy")
    client("POST", "/solve", FORM)
    assert client.view.solving is not None
    process = client.view.solving
    assert client("DELETE", "/solve").json == {"solving": False}
    assert process.poll() is not None
    assert client("GET", "/solve").json == {"solving": False}


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
        assert len(list(client.view.folder.glob("of-*"))) == 1
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
