"""A wall that keeps a load above warm atoms: a bath at their temperature, whose energy is counted."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import atomistic as a
import continuum as c
from atomistic.front.functions import DeckRun
from atomistic.lammps.protocol import SAMPLED, largest_timestep
from atomistic.lammps.result import read_result

TEMPERATURE = 0.0018
"""k_B T, in E* a0³: copper at 300 K."""
TABLE = {
    "kind": "sliding", "pressure": 0.05, "distance": 0.5, "velocity": 0.05, "temperature": TEMPERATURE,
    "window": 10.0, "hold": 2, "dwell": 8, "thermostat_layers": 1,
}  # fmt: skip


def run(
    folder: Path, noise: bool = True, amplitude: float = 0.002, waves: tuple[int, int] = (1, 0), **changes: Any
) -> DeckRun:
    heights = c.sine(c.Grid.square(4), amplitude, waves)
    # A formula, also of the shortest wave, of which a deck by itself would make a spline, at three times the cost.
    follows = a.Waves((4.0, 4.0), amplitude, ((-amplitude, *waves, 0.0),))
    contact = c.Contact(heights, c.InversePowers((9, 3), adhesion_length=0.02))
    table = {name: value for name, value in (TABLE | changes).items() if value is not None}
    directory = a.deck(contact, protocol=table, depth=2.2, follows=follows).write(folder)
    if noise:
        return a.run_deck(directory)
    script = directory / "in.motion"
    text = script.read_text()
    line = next(line for line in text.splitlines() if line.startswith("fix             noise"))
    warm = f"langevin {TEMPERATURE} {TEMPERATURE} "
    assert warm in line
    script.write_text(text.replace(line, line.replace(warm, "langevin 0.0 0.0 ")))
    return a.run_deck(directory)


def taken(found: DeckRun) -> tuple[float, float]:
    """Energy that the wall took in a window while it did not slide, of the whole, in k_B T, and its standard error."""
    hold, dwell = found.description.hold, found.description.dwell
    each = np.array([step.taken_by_wall for step in found.steps[hold : hold + dwell]]) * 16 / TEMPERATURE
    return float(each.mean()), float(each.std(ddof=1) / np.sqrt(len(each)))


def test_a_wall_that_keeps_a_load_takes_nothing_from_atoms_at_rest_and_its_energy_balances(tmp_path: Path) -> None:
    warm = run(tmp_path / "warm")
    found, error = taken(warm)
    assert abs(found) < 3 * error
    # A drag without noise takes A <δp²>/(ρ c), as a bath at T = 0.
    drained, error = taken(run(tmp_path / "cold", noise=False, dwell=4))
    assert drained > 4 * error
    # Heat passes slowly through the one layer of the thermostat: temperatures scatter by more than the errors
    # of the blocks of a window, and by as much as those of the steps say.
    first = warm.description.hold
    scatter = np.std([step.temperature for step in warm.steps[first:]], ddof=1)
    own = [
        read_result(warm.directory, step).averages["temperature"][1] for step in range(first + 1, len(warm.steps) + 1)
    ]
    assert scatter > 2 * np.sqrt(np.mean(np.square(own)))
    assert np.mean([step.temperature_error for step in warm.steps[first:]]) == pytest.approx(scatter, rel=0.1)
    # Means are of the windows in which it slides, also in a deck of an earlier version, which does not say so.
    assert replace(warm, description=replace(warm.description, averaged=())).averaged == warm.averaged
    assert warm.averaged == warm.steps[first + warm.description.dwell :]
    balance = warm.balance
    assert balance is not None
    got = balance.along, balance.up, -balance.taken, balance.heat
    assert balance.kept == pytest.approx(sum(got) + balance.left, abs=1e-15)
    # Velocity Verlet errs by (ω Δt)²/4 = 0.3 % of the energy of the fastest modes: 3 k_B T an atom, of three layers.
    assert abs(balance.left) < 0.003 * 9 * TEMPERATURE < 0.05 * max(map(abs, got))
    text = warm.sheets()[1].text()
    for row in (
        "work of the wall along x",
        "work of the load, up and down",
        "from the wall that keeps it",
        "heat from",
    ):
        assert row in text


@pytest.mark.filterwarnings("ignore:.*fewer than 4 points")
def test_the_work_of_a_sliding_wall_is_in_the_balance(tmp_path: Path) -> None:
    changes = {"pressure": None, "separation": 0.8, "dwell": 0, "velocity": 0.02, "distance": 0.2, "temperature": 1e-4}
    found = run(tmp_path / "deck", amplitude=0.09, waves=(2, 0), **changes)
    balance = found.balance
    assert balance is not None
    assert balance.taken == balance.up == 0
    # As above; and of samples of every tenth step the last stands for half a stretch too much.
    half = SAMPLED / 2 * largest_timestep(a.Springs(), found.wall) * changes["velocity"]
    end = half * abs(found.last.lateral_x) / 16
    assert abs(balance.left) < 0.003 * 9 * changes["temperature"] + end
    assert abs(balance.along) > 20 * abs(balance.left)
    assert "from the wall that keeps it" not in found.sheets()[1].text()
