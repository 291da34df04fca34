"""A wall that slides at a given normal load: the load that it keeps, its height, friction coefficients, restarts."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import atomistic as a
import continuum as c
from atomistic.crystal.interatomic import Springs
from atomistic.front.cli import main
from atomistic.front.functions import DeckRun
from atomistic.lammps.directory import finished_steps
from atomistic.lammps.engine import run_command, run_in_process
from atomistic.lammps.protocol import Motion, impedance, swing
from atomistic.lammps.result import read_result
from atomistic.lammps.trace import WindowMean
from continuum.inputs.errors import StickinessError
from continuum.inputs.units import Units
from tests.problems import lmp

PRESSURE = 0.05
TABLE = {
    "kind": "sliding", "pressure": PRESSURE, "distance": 0.5, "velocity": 0.1, "temperature": 1e-6, "window": 2.5,
    "hold": 2, "dwell": 2, "thermostat_layers": 1,
}  # fmt: skip
CONTACT = c.Contact(c.sine(c.Grid.square(8), 0.15, (2, 0)), c.InversePowers((9, 3), adhesion_length=0.02))


@cache
def deck() -> a.Deck:
    return a.deck(CONTACT, protocol=TABLE, depth=2.2, follows="atom")


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> DeckRun:
    return a.run_deck(deck().write(tmp_path_factory.mktemp("load") / "slide"))


def test_the_load_is_kept_but_for_the_way_that_the_height_makes(run: DeckRun) -> None:
    motion = deck().protocol
    assert isinstance(motion, Motion)
    assert run.finished
    assert run.converged
    heights = [motion.separations[0], *(read_result(run.directory, i + 1).separation for i in range(len(run.steps)))]
    for step, time, way in zip(run.steps, motion.durations, np.diff(heights), strict=True):
        # A mean of samples at the ends of ten stretches misses half of one stretch of what drifts by twice the miss.
        miss = step.load - PRESSURE
        expected = impedance(Springs()) * way / time
        # The wall also moves by its noise, whose mean over a time t has the variance 2 k_B T ρ c/(A t) of a pressure.
        noise = np.sqrt(2 * motion.temperature * impedance(Springs()) / (run.last.gap.size * time))
        assert miss == pytest.approx(expected, abs=step.load_error + 0.1 * abs(miss) + 3 * noise)
    assert abs(run.averaged[-1].load - PRESSURE) < 0.3 * abs(run.steps[0].load - PRESSURE)
    assert run.description.pressure == PRESSURE
    assert len(run.averaged) == 2


@pytest.mark.long
@pytest.mark.parametrize("temperature", [1e-6, 0.0018])  # cold, and copper at 300 K
def test_the_mean_load_is_the_one_asked_for_within_its_error(tmp_path: Path, temperature: float) -> None:
    heights = c.SelfAffine(0.8, 0.1, 4, 16).synthesise(c.Grid.square(16), np.random.default_rng(3))
    contact = c.Contact(heights, c.LennardJonesSpline(adhesion_length=0.005))
    table = TABLE | {"pressure": 0.02, "distance": 8.0, "velocity": 0.04, "window": 25.0, "hold": 4, "dwell": 4}
    made = a.deck(contact, protocol=table | {"temperature": temperature}, depth=8, follows="atom", wall_force="plugin")
    run = a.run_deck(made.write(tmp_path / "slide"))
    load = run.mean("load")
    assert load.error < 0.01 * 0.02
    assert load.mean == pytest.approx(0.02, abs=3 * load.error)


def test_a_wall_follows_a_slab_within_the_time_that_sound_takes_to_cross_it() -> None:
    # ρ c/(C11/depth) = depth/c; the slowest vibration of the slab is a quarter of a wave: ω = π c/(2 depth).
    c11, depth = Springs().elastic_constants[0], 7.0
    assert impedance(Springs()) * depth / c11 == pytest.approx(np.pi / (2 * swing(Springs(), depth)), rel=1e-12)


def test_a_killed_run_goes_on_at_the_height_that_it_had(run: DeckRun, tmp_path: Path) -> None:
    stopped = deck().write(tmp_path / "stopped")
    run_command(stopped, command=f"{lmp()} -var last 4")
    assert finished_steps(stopped) == (1, 2, 3, 4)
    # A window that was killed as it wrote: its height is there, its result is not.
    (stopped / "height.5.txt").write_text("9.9")
    (stopped / "result.part").write_text("half")
    run_in_process(stopped)
    for step in range(1, run.expected + 1):
        for name in (f"state.{step}.dump", f"height.{step}.txt", f"result.{step}.json"):
            assert (stopped / name).read_bytes() == (run.directory / name).read_bytes(), name
    # A deck that is written anew over it leaves no height behind.
    other = a.deck(CONTACT, protocol=TABLE | {"pressure": 0.04}, depth=2.2, follows="atom")
    other.write(stopped, force=True)
    assert not list(stopped.glob("height.*"))


def test_the_table_has_height_load_friction_and_their_ratio(run: DeckRun) -> None:
    steps, *_, friction, _ = run.sheets()
    assert {"separation (a0)", "N/A0 (E*)", "± N/A0", "friction/A0 (E*)"} < set(steps.head)
    assert "friction/N" in friction.head
    assert "Friction coefficient: " in (text := steps.text())
    assert "was to keep N/A0 = 0.05 E*: its height is" in text
    assert "nN" not in text
    # Of a crystal with a size, in GPa and nN, too: 64 atoms of 0.25 nm under 5 GPa are 20 nN.
    sized = replace(run, description=replace(run.description, real_units=Units(2.5e-10, 100e9)))
    steps, *_, friction, _ = sized.sheets()
    row = dict(zip(friction.head, friction.rows[-1], strict=True))
    assert row["N (nN)"] == pytest.approx(run.steps[-1].load * 64 * 0.25**2 * 100, rel=1e-9)
    assert row["friction (nN)"] == pytest.approx(run.steps[-1].lateral_x * 64 * 0.25**2 * 100, rel=1e-9)
    assert row["friction/A0 (GPa)"] == pytest.approx(run.steps[-1].lateral_x * 100, rel=1e-9)
    assert row["friction/N"] == pytest.approx(run.steps[-1].lateral_x / run.steps[-1].load)
    assert " nN)." in steps.text()
    # A load that is not the one asked for is said to be none.
    missed = replace(run, description=replace(run.description, pressure=0.2))
    assert "standard errors from it" in missed.sheets()[0].text()


def test_the_error_of_a_ratio_is_its_scatter(rng: np.random.Generator) -> None:
    series, count, size = 300, 8, 0.02
    loads = 2.0 + size * rng.standard_normal((series, count))
    # Friction that goes with the load, and noise of its own.
    friction = 0.3 * loads + 0.3 * size * rng.standard_normal((series, count))
    errors = np.full(count, 1e-9)  # so that the scatter decides
    found = [WindowMean.of_ratio(f, errors, n, errors) for f, n in zip(friction, loads, strict=True)]
    truth = 0.3 * size / np.sqrt(count) / 2.0  # what goes with the load is no error of the ratio
    assert np.mean([each.mean for each in found]) == pytest.approx(0.3, abs=4 * truth / np.sqrt(series))
    # A variance from 300 x 7 degrees of freedom scatters by sqrt(2/2100) = 3 %, and a ratio is linear to 1 %; what is
    # correlated by chance adds a sixth to eight independent windows, seen in 500 series.
    assert 0.88 < np.mean([each.error**2 for each in found]) / truth**2 < 1.12 + 1 / 6
    # Windows that do not scatter: the propagation of independent errors.
    single = WindowMean.of_ratio(np.full(4, 0.6), np.full(4, 0.02), np.full(4, 2.0), np.full(4, 0.04))
    assert single.mean == pytest.approx(0.3)
    assert single.error == pytest.approx(0.3 * np.hypot(0.01 / 0.6, 0.02 / 2.0), rel=1e-12)
    with pytest.raises(ValueError, match="no ratio"):
        WindowMean.of_ratio(np.ones(4), np.ones(4), np.full(4, 0.1), np.ones(4))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"pressure": float("nan")}, "pressure = nan"),
        ({"pressure": float("inf")}, "pressure = inf"),
        ({"pressure": 5.0}, "from -1 to 1 E.*, the strength of crystals"),
        ({"separation": 1.0}, "exactly one of separation and pressure"),
        ({"pressure": None}, "neither is given"),
        ({"pressure": "1GPa"}, "this crystal has no length scale"),
        ({"pressure": -0.5}, r"does not hold a mean tension of 0\.5 E\*: the largest that it holds is"),
    ],
)
def test_a_load_that_makes_no_sense_is_one_message(changes: dict[str, object], words: str) -> None:
    with pytest.raises((StickinessError, ValueError), match=words):
        a.deck(CONTACT, protocol=TABLE | changes, depth=2.2, follows="atom")


def test_check_says_the_pressure_in_gigapascal(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], expanded: float
) -> None:
    path = tmp_path / "copper.toml"
    path.write_text(
        'follows = "atom"\n[interatomic]\nkind = "eam"\nfile = "Cu_mishin1.eam.alloy"\n[slab]\nn = 10\ndepth = 6.0\n'
        '[surface]\nkind = "sine"\namplitude = 0.05\nwaves = [2, 0]\n'
        '[wall]\nlaw = "lennard-jones-9-3"\nadhesion_length = 0.02\n'
        '[protocol]\nkind = "sliding"\npressure = "1GPa"\ndistance = 1.0\nvelocity = 0.1\ntemperature = "300K"\n'
        "window = 5.0\n"
    )
    assert main(["check", str(path)]) == 0
    assert "E* = 1 GPa" in capsys.readouterr().out
