"""CPU time of an evaluation of the forces in LAMMPS under a wall, by its law and by how it is written.

``python -m docs.studies.wall_costs [LMP ...]`` takes some minutes for each ``lmp``: that of the environment, and others
that are named.  Springs are the cheapest atoms, so that a wall weighs most there.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from pathlib import Path
from unittest import mock

import numpy as np

import continuum as c
from atomistic.crystal.crystal import Slab
from atomistic.crystal.interatomic import Springs
from atomistic.lammps import deck as decks
from atomistic.lammps.deck import Deck, write_deck
from atomistic.lammps.engine import script
from atomistic.lammps.law import TOLERANCE, in_pieces, law_of_atoms, native_law, with_core
from atomistic.lammps.law import NativeLaw as Lines
from continuum.model.walls import Exponential, InversePowers, LennardJonesSpline, TabulatedWall, Wall
from continuum.store.sheet import Column, Entry, Sheet
from docs.studies.tables import keep

N = (32,)
"""Surface atoms a side; the slab is as deep."""
FORMULAS, PIECES = "formulas", "pieces"
EVALUATIONS, RUNS = 30, 5
"""The least time of several runs is that of the work; the rest is what else the machine does."""
KEPT = 1.1
"""Ratio of CPU times of whole evaluations, pieces over formulas, from which on a law keeps its formulas."""

_SPLINE, _LONG = (LennardJonesSpline(adhesion_length=length) for length in (0.005, 0.05))
_TABLE = TabulatedWall(
    (_GAPS := np.linspace(0.7, 1.0 + _SPLINE.range, 1000)), np.append(_SPLINE.evaluate(_GAPS[:-1]).traction, 0.0)
)
LAWS: dict[str, Wall] = {
    "spline, l_a = 0.005 a0": _SPLINE,
    "spline, l_a = 0.05 a0": _LONG,
    "table of 1000 rows": _TABLE,
    "9-3": InversePowers((9, 3), adhesion_length=0.02),
    "12-6": InversePowers((12, 6), adhesion_length=0.02),
    "exponential": Exponential(0.02, 0.2, 3.0),
}


def _powers(wall: InversePowers, gap: str) -> tuple[str, str]:
    """Traction and energy of inverse powers, as LAMMPS would compute them without a table."""
    (m, n), strength = wall.powers, wall.minimum_stiffness / (wall.powers[0] - wall.powers[1])
    return (
        f"{strength}*({gap}^(-{m + 1})-{gap}^(-{n + 1}))",
        f"{strength}*({gap}^(-{m})/{m}.0-{gap}^(-{n})/{n}.0)",
    )


def _formulas(wall: Wall, layer: float) -> Lines:
    """The law of an atom by formulas; of inverse powers the difference of two of them, which decks do not write.

    Of a spline that reaches the second layer they were not written: the pieces were the cheaper ones already.
    """
    if not isinstance(wall, InversePowers):
        return native_law(law_of_atoms(wall, layer))
    deeper = f"(v_gap+{layer})"
    lines = (
        f'variable        {name} atom "{here}-{below}"'
        for name, here, below in zip(("law", "law_energy"), _powers(wall, "v_gap"), _powers(wall, deeper), strict=True)
    )
    return with_core(wall, "\n".join(lines))


def _in_pieces_only(wall: Wall, tolerance: float = TOLERANCE) -> Lines:
    return native_law(wall, tolerance) if isinstance(wall, TabulatedWall) else in_pieces(wall, tolerance)


def seconds(n: int, law: Wall | None, form: str, lmp: str) -> float:
    """CPU seconds of an evaluation on springs under a sphere in contact: the least of several runs."""
    grid, wall = c.Grid.square(n), law or _SPLINE
    slab = Slab.of_depth(grid, float(n))
    written = _in_pieces_only if form == PIECES else lambda *_: _formulas(wall, slab.layer)
    with tempfile.TemporaryDirectory() as folder, mock.patch.object(decks, "native_law", written):
        write_deck(Path(folder), Deck(slab, Springs(), wall, c.sphere(grid, 4.0 * n), wall.zero_gap - 0.02))
        lines = (Path(folder) / "in.contact").read_text().splitlines()
        kept = [line for line in lines if re.match(r"variable|include +in.slab", line)]
        kept += [] if law is None else ["include in.wall"]
        kept += ["thermo 1000000", f"run {EVALUATIONS} post no", *RUNS * [f"run {EVALUATIONS} pre no"]]
        (Path(folder) / "in.cost").write_text("\n".join(kept) + "\n")
        done = subprocess.run([lmp, "-in", "in.cost"], cwd=folder, capture_output=True, text=True, check=True)
    used = re.findall(r"^([\d.]+)% CPU use", done.stdout, re.MULTILINE)
    spent = re.findall(r"^Loop time of (\S+) on", done.stdout, re.MULTILINE)[-RUNS:]
    return min(float(s) * float(u) / 100 for s, u in zip(spent, used, strict=True)) / EVALUATIONS


def _version(lmp: str) -> str:
    found = re.search(r"Simulator - (.+)", subprocess.run([lmp, "-h"], capture_output=True, text=True).stdout)
    return found[1].strip() if found else lmp


def main(programs: list[str]) -> None:
    rows: list[tuple[Entry, ...]] = []
    for lmp in programs or [script("lmp")]:
        for n in N:
            none = seconds(n, None, FORMULAS, lmp)
            for name, law in LAWS.items():
                pieces = seconds(n, law, PIECES, lmp)
                formulas = None if law in (_TABLE, _LONG) else seconds(n, law, FORMULAS, lmp)
                ratio = "" if formulas is None else f"{pieces / formulas:.2f}"
                over = "" if formulas is None else f"{formulas / none:.2f}"
                rows.append((_version(lmp), f"{n}²", name, over, f"{pieces / none:.2f}", ratio))
                sys.stdout.write(f"{rows[-1]}\n")
                sys.stdout.flush()
    head = ("LAMMPS", "surface", "law", "formulas over no wall", "pieces over no wall", "pieces over formulas")
    keep("wall-costs", Sheet.of("wall-costs", tuple(map(Column, head)), rows))


if __name__ == "__main__":
    main(sys.argv[1:])
