"""Each command that a user can call does its work once, on the smallest input.

The commands are those of the programs, so that a new one fails here until it has a test.  Beside these: each button of
the page of `continuum view` is pressed in tests/doors/continuum/view/test_view.py; each public class is made, copied
and sent to another process in tests/doors/test_pickle.py; each public function is called in the tests of doors of both
packages.
"""

from __future__ import annotations

import http.client
import os
import signal
from collections.abc import Iterator
from pathlib import Path
from threading import Thread
from urllib.parse import urlsplit

import numpy as np
import pytest
from cyclopts import App

import atomistic.front.cli
import continuum.front.cli
from continuum.model.grid import Grid
from continuum.model.surface import SelfAffine
from tests.problems import SMALL
from tests.tasks import tasks_here

MAINS = {"continuum": continuum.front.cli.main, "atomistic": atomistic.front.cli.main}
CONTACT = """
[interatomic]
kind = "springs"
[slab]
n = 8
depth = 2.0
"""
DECK = f"""separation = 1.2
{CONTACT}
[surface]
kind = "sine"
amplitude = 0.1
waves = [1, 1]
[wall]
law = "lennard-jones-spline"
adhesion_length = 0.005
"""
VALIDATE = f"""{CONTACT}
[surface]
hurst = 0.8
lambda_s = 4.0
lambda_L = 8.0
seeds = [1]
[[case]]
name = "one"
adhesion_length = 0.0
rms_slopes = [0.1]
areas = [0.3]
"""
MAP = "map.txt --size 32nm --unit nm --estar 1GPa --work 1mJ/m2 --range 0.5nm --periodic --no-solve"
COMMANDS = {
    # Its words, a text in what it prints, and the command before, whose files it reads.
    "continuum check": ("small.toml", "states of the path", ""),
    "continuum run": ("small.toml", "Points of the path", ""),
    "continuum threshold": ("small.toml --area 0.05 -o searched", "searched/small", ""),
    "continuum plot": ("results/small.h5 --format png -o drawn", "drawn/small-contact.png", "continuum run"),
    "continuum analyse": ("results/small.h5 --format png -o analysed", "patches", "continuum run"),
    "continuum certify": ("results/small.h5", "sound", "continuum run"),
    "continuum predict": (f"{MAP} --format png", "map-predict.html", ""),
    "continuum view": ("results/small.h5", "", "continuum run"),
    "continuum doctor": ("", "usable", ""),
    "continuum init": ("sweep", "[sweep.axes]", ""),
    "continuum schema": ("run", '"loading"', ""),
    "continuum examples": ("", "rubber", ""),
    "continuum completion": ("bash", "complete", ""),
    "continuum sweep run": ("many.toml", "2 systems done", ""),
    "continuum sweep slurm": ("many.toml", "#SBATCH --cpus-per-task=2", ""),
    "continuum sweep status": ("results/many", "left      0", "continuum sweep run"),
    "continuum sweep collect": ("results/many", "results/many/table.csv", "continuum sweep run"),
    "continuum sweep publish": ("results/many -o published", "published", "continuum sweep run"),
    "continuum sweep verify": ("results/many", "2 files, 0 of them damaged", "continuum sweep run"),
    "atomistic check": ("deck.toml", "atoms", ""),
    "atomistic deck": ("deck.toml --run", "decks/deck: ", ""),
    "atomistic read": ("decks/deck --format png", "results/deck.h5", "atomistic deck"),
    "atomistic wall": (
        "map.txt --size 80Å --unit Å --edges periodic --a0 2.5Å --estar 1GPa --work 1mJ/m2",
        "wall/in.wall",
        "",
    ),
    "atomistic validate": ("validate.toml -j 1", "bounds hold", ""),
    "atomistic elastic": ("inputs/crystals/springs.toml --format png", "C11", ""),
    "atomistic doctor": ("", "usable", ""),
    "atomistic init": ("deck", "[interatomic]", ""),
    "atomistic schema": ("validate", '"case"', ""),
    "atomistic completion": ("fish", "complete", ""),
}
DONE = dict[str, str]()
"""What the commands that were called in this process have printed."""


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with an input of each kind."""
    folder = tmp_path_factory.mktemp("doors")
    inputs = {
        "small": SMALL, "many": f'{SMALL}[sweep.axes]\n"surface.seed" = [1, 2]\n', "deck": DECK, "validate": VALIDATE
    }  # fmt: skip
    for name, text in inputs.items():
        (folder / f"{name}.toml").write_text(text)
    np.savetxt(
        folder / "map.txt", SelfAffine(0.8, 0.02, 8.0, 32.0).synthesise(Grid.square(32), np.random.default_rng(1))
    )
    DONE.clear()
    return folder


@pytest.fixture(autouse=True)
def here(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A user's folder, and one worker of sweeps and validations is this process."""
    monkeypatch.chdir(place)
    for name in ("continuum.front.sweeps", "atomistic.front.validation"):
        monkeypatch.setattr(f"{name}.run_tasks", tasks_here)


@pytest.fixture
def seen(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[int]]:
    """What a browser gets that `view` opens; then the user presses Ctrl-C."""
    found = list[int]()

    def load(address: str) -> None:
        url = urlsplit(address)
        connection = http.client.HTTPConnection(url.netloc, timeout=60)
        connection.request("GET", f"{url.path}?{url.query}")
        found.append(connection.getresponse().status)
        connection.close()
        os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr("webbrowser.open", lambda address: Thread(target=load, args=(address,)).start())
    # Who runs the tests in the background of a shell has it ignored.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield found
    signal.signal(signal.SIGINT, before)


def commands(app: App, name: str) -> Iterator[str]:
    """Names of the commands of a program, and of those under them."""
    for word, command in app.resolved_commands().items():
        if not word.startswith("-"):
            inner = list(commands(command, f"{name} {word}"))
            yield from inner or [f"{name} {word}"]


def called(command: str, capsys: pytest.CaptureFixture[str]) -> str:
    """What a command prints that ends well."""
    words, _, before = COMMANDS[command]
    if before and before not in DONE:
        called(before, capsys)
    program, *names = command.split()
    assert MAINS[program]([*names, *words.split()]) == 0, "".join(capsys.readouterr())
    DONE[command] = capsys.readouterr().out
    return DONE[command]


def test_every_command_has_a_test_here() -> None:
    apps = {"continuum": continuum.front.cli.app, "atomistic": atomistic.front.cli.app}
    assert {name for program, app in apps.items() for name in commands(app, program)} == set(COMMANDS)


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_does_its_work(command: str, seen: list[int], capsys: pytest.CaptureFixture[str]) -> None:
    assert COMMANDS[command][1] in (DONE.get(command) or called(command, capsys))
    assert seen == ([302] if command == "continuum view" else [])  # to the page, with a cookie
