"""Absolute checks of a ladder, which need no other run: its responses at long waves, and the law of its decks.

At long waves all rungs tend to one elastic crystal.  The lattice, from its measured force constants, has the stiffness
K_q = E*(θ) q/2 (1 + O(q)) of its own half-space.  With K at q and q/2 the first order is eliminated.  The cubic
crystal must have these limits along <110> and <100>, and the isotropic half-space the mean compliance over directions,
1/<1/E*>.  The traction that LAMMPS gives atoms at known gaps must be that of the wall law.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from atomistic.crystal.crystal import LAYER_SPACING, Slab
from atomistic.ladder.rungs import RungName, continuum_response
from atomistic.lammps.deck import Deck, write_deck
from atomistic.lammps.result import DeckResult
from atomistic.relax.specimen import Specimen
from atomistic.response.force_constants import ForceConstants, least_width
from atomistic.response.lattice import half_space_stiffness
from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.model.substrates.crystal import CubicConstants
from continuum.model.walls import Wall

LONGEST, DEEP = 512.0, 4096.0
"""Longest wave, and depth of a layer that is a half-space for it to all digits, in a0."""
_DIRECTIONS = ((1, 0), (2, 1), (1, 1))
"""Mode numbers (m, n) of the longest wave of each direction: <110>, between, <100>.  1/E*(θ) is read from them as
a + b cos 4θ + c cos 8θ; of copper, the most anisotropic of our crystals, a is then right to 7e-4."""
GAPS = 100
"""Smallest number of gaps at which a law is looked at."""
SMALLEST_GAP = 0.8
"""In a0: there the wall pushes with 0.6 E*, harder than any contact of these inputs."""
LONG_WAVES, LAW = 0.005, 1e-9
"""Largest relative difference of stiffnesses at long waves, and of tractions.

The first has room for the error of extrapolation and of measured constants: 1.4e-4 along a direction for aluminium,
7e-4 of the mean for copper.  A crystal turned by 45 degrees differs by 1.5 % (aluminium) to 6.6 % (copper).  The second
is of rounding: formulas of LAMMPS and ours agree to 1e-15 of the tractions, gaps in Å to 1e-13.
"""


class LadderCheck(NamedTuple):
    """One check: what was compared, the largest relative difference, the allowed one and the number of values."""

    step: str
    quantity: str
    measured: float
    limit: float
    points: int
    reason: str


def checks_of(
    specimen: Specimen, laws: Mapping[str, Wall], run: Callable[[Path], DeckResult]
) -> tuple[LadderCheck, ...]:
    """The checks of a substrate and of the laws that are pressed on it.

    Parameters
    ----------
    laws : by name.
    run : runs a deck, as :func:`atomistic.lammps.engine.runner` gives it.
    """
    model = specimen.model
    limits = _limits(specimen.response.force_constants)
    reason = "both tend to the crystal's elastic limit; room for extrapolation and for measured constants"
    cubic = (_of_rung("crystal", model.elastic_constants) / limits)[[0, 2]]
    found = [
        LadderCheck(
            "crystal", f"K_q of long waves along {name} against the lattice", abs(ratio - 1), LONG_WAVES, 2, reason
        )
        for name, ratio in zip(("<110>", "<100>"), cubic.tolist(), strict=True)
    ]
    half_space = _mean(_of_rung("half-space", model.elastic_constants)) / _mean(limits)
    what = "K_q/q against the mean of the lattice's long waves"
    found.append(LadderCheck("half-space", what, abs(half_space - 1), LONG_WAVES, 2 * len(_DIRECTIONS), reason))
    for name, wall in laws.items():
        measured, points = law_error(specimen, wall, run)
        what, why = f"traction in LAMMPS under {name}", "the same formula: rounding, and digits of the gap"
        found.append(LadderCheck("law", what, measured, LAW, points, why))
    return tuple(found)


def _limits(constants: ForceConstants) -> Real:
    """Limit of K_q/q of the lattice for long waves in each direction, in E*."""
    m, n = np.array(_DIRECTIONS).T * (2 * np.pi / LONGEST)
    return _extrapolated(*(half_space_stiffness(constants, k * m, k * n) / (k * np.hypot(m, n)) for k in (1, 2)))


def _of_rung(name: RungName, constants: CubicConstants) -> Real:
    """The same of a rung of the ladder, whose base is too deep to be felt."""
    grid = Grid((16, 16), (LONGEST, LONGEST))
    ratio = continuum_response(name, DEEP, constants).stiffness(grid) / np.where(
        grid.wavenumber > 0, grid.wavenumber, 1
    )
    m, n = np.array(_DIRECTIONS).T
    return _extrapolated(ratio[m, n], ratio[2 * m, 2 * n])


def _extrapolated(long: Real, half_as_long: Real) -> Real:
    return np.asarray(2 * long - half_as_long)


def _mean(stiffness: Real) -> float:
    """1/<1/stiffness> over directions, of that along each of the three."""
    angle = np.arctan2(*np.array(_DIRECTIONS).T[::-1])
    series = np.cos(4 * np.outer(angle, np.arange(3)))
    return float(1 / np.linalg.solve(series, 1 / stiffness)[0])


def law_error(specimen: Specimen, wall: Wall, run: Callable[[Path], DeckResult]) -> tuple[float, int]:
    """Largest error of the traction of a deck at known gaps, and their number.

    Relative to the traction, or to the largest tension if that is larger.
    """
    model = specimen.model
    n, layers = max(least_width(model), int(np.ceil(np.sqrt(GAPS)))), model.coupled_layers
    slab, rise = Slab((n, n), layers, layers), np.zeros(2 * layers)
    rise[:layers] = specimen.rise[:layers]
    # Where the law reaches the second layer, 5 % nearer as it may relax, the first has only its part of it.
    nearest = max(SMALLEST_GAP, wall.zero_gap + wall.range - 0.95 * LAYER_SPACING)
    gap = np.linspace(nearest, wall.zero_gap + 1.1 * max(wall.range, 0.1), n * n).reshape(n, n)
    separation = float(gap.mean())
    # Nothing is to move: any force is within the tolerance.
    deck = Deck(slab, model, wall, gap - separation, separation, tolerance=1e9, rise=rise)
    with tempfile.TemporaryDirectory() as folder:
        found = run(write_deck(Path(folder) / "deck", deck))
    expected = wall.evaluate(gap).traction
    scale = np.maximum(np.abs(expected), max(0.0, -float(expected.min())))
    error = np.abs(found.traction - expected)
    relative = np.divide(error, scale, out=np.where(error > 0, np.inf, 0.0), where=scale > 0)
    return float(relative.max()), gap.size
