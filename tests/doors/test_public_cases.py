"""Thirteen things that a stranger tried, from the outside: an input, a command, and what is right.

Each was wrong or failed once.  `make long` runs them; what they rest on has short tests beside the code.
"""

from __future__ import annotations

import os
import pickle
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from ase.build import fcc111

import atomistic as a
import atomistic.front.cli
import continuum as c
import continuum.front.cli
from atomistic.lammps.engine import script
from tests.problems import SMALL

pytestmark = pytest.mark.long
ROOT = Path(__file__).parents[2]
KNOWN = {"contact_modulus": "1GPa", "work": "20mJ/m2", "range": "0.5nm", "solve": False}
WORDS = ["--estar", "1GPa", "--work", "20mJ/m2", "--range", "0.5nm", "--no-solve"]
SPHERE = """
[slab]
n = 10
depth = 5.0
[surface]
kind = "sphere"
radius = 40.0
[wall]
law = "lennard-jones-spline"
adhesion_length = 0.005
"""
DECK = """
[interatomic]
kind = "springs"
[slab]
n = 8
depth = 4.0
[surface]
kind = "sine"
amplitude = 0.3
waves = [1, 1]
[wall]
law = "lennard-jones-spline"
adhesion_length = 0.005
[protocol]
kind = "separations"
separations = [1.3]
"""


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.toml").write_text(SMALL)
    return tmp_path


def called(*words: str, **variables: str) -> subprocess.CompletedProcess[str]:
    """A process of this environment and of these variables."""
    return subprocess.run(
        words, env=os.environ | {"PYTHONPATH": str(ROOT)} | variables, timeout=300, capture_output=True, text=True,
        check=False,
    )  # fmt: skip


def surface(n: int, spacing: float = 1.0) -> np.ndarray:
    return c.SelfAffine(0.8, 0.1, 4 * spacing, 16 * spacing).synthesise(
        c.Grid.square(n, spacing), np.random.default_rng(1)
    )


def test_1_a_row_of_units_below_other_names(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = [f"{0.5 * i:.1f},{height:.2f}" for i, height in enumerate(surface(512)[0] * 100)]
    (here / "line.csv").write_text("\n".join(["Sample,A1", "Lateral,Total Profile", "µm,Å", *rows]))
    assert continuum.front.cli.main(["predict", "line.csv", *WORDS]) == 0
    assert continuum.front.cli.main(["predict", "line.csv", "--unit", "nm", *WORDS]) == 2
    assert "the file itself says the unit" in capsys.readouterr().err


SLAB = fcc111("Cu", (6, 6, 4), vacuum=8, periodic=True)


def wall(modulus: float | str = 0.85) -> a.RoughWall:
    return a.RoughWall(
        np.zeros((12, 12)), SLAB, 0.9, c.LennardJonesSpline(adhesion_length=0.005), a0=2.55, contact_modulus=modulus
    )


def test_2_a_modulus_in_another_unit() -> None:
    with pytest.raises(ValueError, match="no solid has this"):
        wall(136.0)
    assert wall("136GPa").get_forces(SLAB) == pytest.approx(wall(136 / 160.2177).get_forces(SLAB), rel=1e-6)


def test_3_the_atoms_in_another_order() -> None:
    """As LAMMPS, `sort` and `read` leave them: the wall acts on whatever is there."""
    order = np.argsort(-SLAB.positions[:, 2], kind="stable")
    found, sorted_first = wall().get_forces(SLAB), wall().get_forces(SLAB[order])
    assert np.abs(found).max() > 0.1
    np.testing.assert_allclose(sorted_first[:, 2].sum(), found[:, 2].sum(), rtol=1e-12)


def test_4_the_unit_of_an_array() -> None:
    xarray = pytest.importorskip("xarray")
    array = xarray.DataArray(surface(64), dims=("y", "x"), attrs={"units": "um"})
    with pytest.raises(ValueError, match="says the unit"):
        c.predict(array, unit="nm", size="0.32um", **KNOWN)


def test_5_atoms_under_the_name_of_another_element(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "element.toml").write_text(
        'separation = 0.95\n[interatomic]\nkind = "pair-style"\nstyle = "adp"\nelement = "Cu"\nmass = 63.546\n'
        'cutoff = 6.3\nlattice_constant = 4.0\nfiles = ["AlCu.adp"]\n'
        f'coefficients = [["*", "*", "AlCu.adp", "Al"]]\n{SPHERE}'
    )
    assert atomistic.front.cli.main(["deck", "element.toml"]) == 2
    assert "the elements of the input, Cu" in capsys.readouterr().err
    assert not (here / "decks").exists()


def test_6_an_installation_that_cannot_be_written_and_no_home(here: Path) -> None:
    for name in ("continuum", "atomistic"):
        shutil.copytree(ROOT / name, here / "installed" / name, ignore=shutil.ignore_patterns("__pycache__"))
    run = f"{sys.executable} -m continuum run small.toml -o out && {sys.executable} -m atomistic doctor"
    mounted = "mount --bind installed installed && mount -o remount,ro,bind installed"
    if called("unshare", "-m", "bash", "-c", mounted).returncode:
        pytest.skip("nothing can be mounted here")
    names = {"HOME": "/proc/none", "PYTHONPATH": str(here / "installed"), "TMPDIR": str(here)}
    inside = f"{mounted} && ! touch installed/continuum/new && {run}"
    done = called("env", "-u", "XDG_CACHE_HOME", "unshare", "-m", "bash", "-c", inside, **names)
    assert done.returncode == 0, done.stderr
    assert "converged" in done.stdout
    assert done.stdout.splitlines()[-1] == "usable"


def test_7_a_cache_that_a_killed_job_left(here: Path) -> None:
    words, variables = (
        [sys.executable, "-m", "continuum", "run", "small.toml", "-o"],
        {"NUMBA_CACHE_DIR": str(here / "n")},
    )
    called(*words, "one", **variables)
    kept = [path for path in (here / "n").rglob("*") if path.is_file()]
    for path in kept:
        path.write_bytes(b"")
    done = called(*words, "two", **variables)
    assert done.returncode == 0, done.stderr
    assert kept
    assert all(path.stat().st_size for path in kept), "written again"


def test_8_latex_in_the_settings_of_figures(here: Path) -> None:
    (here / "matplotlibrc").write_text("text.usetex : True\n")
    silicon = ["--material", "silicon", "--material", "silicon", "--fill", "5%", "--no-solve"]
    words = ["predict", "inputs/maps/wafer.txt", "--size", "384nm", "--unit", "nm", *silicon]
    done = called(sys.executable, "-m", "continuum", *words, MPLCONFIGDIR=str(here))
    assert done.returncode == 0, done.stderr
    assert (here / "results" / "wafer-predict.html").is_file()


def test_9_one_process_of_two_calls_lammps(here: Path) -> None:
    """A script, in which the first one does; and a deck that each of two writes and runs where the other does."""
    (here / "deck.toml").write_text(DECK)
    program = "import os, sys\nif os.environ['PMI_RANK'] == '0':\n"
    program += "    from atomistic.front.cli import main\n    sys.exit(main())\n"
    (here / "rank0.py").write_text(program)
    start = [script("mpiexec"), "-n", "2", sys.executable]
    done = called(*start, "rank0.py", "deck", "deck.toml", "-o", "one", "--run")
    assert done.returncode == 0, done.stderr
    done = called(*start, "-m", "atomistic", "deck", "deck.toml", "-o", "both", "--run")
    assert "Traceback" not in done.stderr


def test_10_a_prediction_crosses_to_another_process() -> None:
    found = c.predict(surface(64), unit="nm", size="0.32um", **KNOWN)
    assert pickle.loads(pickle.dumps(found)).sentence == found.sentence


def test_11_a_fourth_column(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    heights = surface(20)
    rows = [f"{x / 100:.3f}\t{y / 100:.3f}\t{heights[y, x]:.5f}\t{100 + x}" for y in range(20) for x in range(20)]
    (here / "four.txt").write_text("\n".join(["X (um)\tY (um)\tZ (nm)\tIntensity", *rows]))
    assert continuum.front.cli.main(["predict", "four.txt", "--verbose", *WORDS]) == 0
    assert "Intensity" in "".join(capsys.readouterr())


def test_12_the_names_that_the_user_gave(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "names.toml").write_text(
        'separation = 0.95\n[interatomic]\nkind = "pair-style"\nstyle = "hybrid/overlay"\nelement = "Ni"\n'
        'mass = 58.69\ncutoff = 6.0\nlattice_constant = 3.52\nfiles = ["library.meam"]\n'
        'arguments = ["meam", "zbl", "0.5", "1.0"]\n'
        'coefficients = [["*", "*", "library.meam", "Ni", "NULL", "Ni"], ["1", "1", "zbl", "28", "28"]]\n'
        f"{SPHERE}"
    )
    assert atomistic.front.cli.main(["deck", "names.toml"]) == 2
    said = capsys.readouterr().err
    assert "Expected hybrid sub-style instead of library.meam" in said
    assert "doctor" not in said


def test_13_jobs_of_two_systems(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "many.toml").write_text(f'{SMALL}[sweep.axes]\n"surface.seed" = [1, 2, 3, 4, 5, 6]\n')
    assert continuum.front.cli.main(["sweep", "slurm", "many.toml", "--array", "3"]) == 0
    assert "#SBATCH --cpus-per-task=2\n" in capsys.readouterr().out
