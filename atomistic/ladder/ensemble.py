"""Bounds that carry over from surface to surface and from metal to metal: quantiles of an ensemble that ran before.

``ensemble.csv``, made by ``tests/studies/ensemble.py``, holds by how much the lattice Green's function and the atoms
differ in each state of eight surfaces on springs and on three metals.  A case without ``[[tolerance]]`` is judged by
it: without adhesion by |N difference|/N_rep = a h' and |u difference| = b a0 h'², with it by c h' of all that acts.

A coefficient belongs to the surface and to the crystal.  Of a surface, its worst state counts.  Over the surfaces of
one crystal their logarithms are taken as normal: the limit is that which a further surface exceeds with the probability
:data:`RARE` (Student's t, G. J. Hahn, J. Am. Stat. Assoc. 64, 878 (1969)), shared among the surfaces of the case.  Of
metals the largest limit is taken: of k + 1 that are alike, another one has the largest with the probability 1/(k + 1).
What is judged is never in its own bound: its crystal is left out, or of springs its surfaces are.
"""

from __future__ import annotations

import csv
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from importlib import resources
from typing import NamedTuple

import numpy as np
from scipy import stats

from atomistic.config.crystal import EmbeddedAtomTable, Interatomic
from atomistic.config.validate import BoundTable, CaseTable, Compared, ValidateConfig

RARE = 0.01
"""Probability with which one of the surfaces of a case breaks a bound that is right."""
FEWEST = 8
"""Surfaces of a crystal below which there is no bound."""
SPRINGS = "springs"
HURST, LAMBDA_S, ROLL_OFF, PERIOD, DEPTH = 0.8, 8.0, 2.0, 4.0, 2.0
"""Of the surfaces of the ensemble: H, λ_s in a0; λ_L, period and depth of the slab in λ_s."""
AREAS = (0.1, 0.25)
PLAIN_SLOPES = (0.1, 0.01)
"""Slopes without adhesion."""
STICKY_SLOPE, ADHESION_LENGTH = 0.1, 0.005
"""With adhesion."""


class Row(NamedTuple):
    """One state of the ensemble: differences of lattice response and atoms."""

    crystal: str
    """``springs``, or the name of the file of the potential."""
    adhesion_length: float
    """In a0."""
    seed: int
    rms_slope: float
    area: float
    load: float
    """|N difference|/N_rep."""
    gross_load: float
    """|N difference|/(N_rep + N_att)."""
    displacement: float
    """Largest |u difference|, in a0."""


class PredictionLimit(NamedTuple):
    """What a further surface exceeds rarely."""

    coefficient: float
    crystal: str
    """Whose limit is the largest."""
    crystals: int
    surfaces: int
    """Of each crystal, at least."""


@cache
def rows() -> tuple[Row, ...]:
    """The states of the ensemble."""
    text = (resources.files("atomistic.ladder") / "ensemble.csv").read_text(encoding="utf-8")
    return tuple(
        Row(r["crystal"], float(r["adhesion_length"]), int(r["seed"]), *(float(r[name]) for name in Row._fields[3:]))
        for r in csv.DictReader(text.splitlines())
    )


def limit(coefficients: Mapping[str, Mapping[int, float]], surfaces: int) -> PredictionLimit:
    """Largest limit of all crystals.

    Parameters
    ----------
    coefficients : of each crystal, by the seed of the surface.
    surfaces : that are judged together.
    """
    found = {}
    for crystal, by_seed in coefficients.items():
        logs = np.log(list(by_seed.values()))
        quantile = float(stats.t.ppf(1 - RARE / surfaces, len(logs) - 1))
        found[crystal] = float(np.exp(logs.mean() + quantile * logs.std(ddof=1) * np.sqrt(1 + 1 / len(logs))))
    largest = max(found, key=lambda crystal: found[crystal])
    return PredictionLimit(found[largest], largest, len(found), min(map(len, coefficients.values())))


def carried_bounds(
    config: ValidateConfig, case: CaseTable, ensemble: Sequence[Row] | None = None
) -> tuple[BoundTable, ...]:
    """Bounds of a case that gives none; none where the ensemble says nothing: see :func:`untested`.

    Parameters
    ----------
    ensemble : states to judge by; those of the file if None.
    """
    if untested(config, case, ensemble):
        return ()
    sticky, left = case.adhesion_length > 0, _others(config, case, ensemble)
    scalings: tuple[tuple[Compared, int], ...] = (("gross_load", 1),) if sticky else (("load", 1), ("displacement", 2))
    found = []
    for quantity, power in scalings:
        worst: defaultdict[str, dict[int, float]] = defaultdict(dict)
        for row in left:
            scaled = float(getattr(row, quantity)) / row.rms_slope**power
            worst[row.crystal][row.seed] = max(scaled, worst[row.crystal].get(row.seed, 0.0))
        most = limit(worst, len(config.surface.seeds))
        many = "crystals" if most.crystals > 1 else "crystal"
        reason = (
            f"of {most.surfaces} other surfaces on {most.crystals} {many}, the largest that of {most.crystal}: "
            f"surfaces alike exceed it with a probability of {RARE:g}"
        )
        found.append(BoundTable(quantity=quantity, coefficient=most.coefficient, power=power, reason=reason))
    return tuple(found)


def untested(config: ValidateConfig, case: CaseTable, ensemble: Sequence[Row] | None = None) -> str:
    """Why the ensemble has no bounds for a case, in words: what is outside of it; empty if it has."""
    return "; ".join(said for inside, said in _conditions(config, case, ensemble) if not inside)


def _conditions(config: ValidateConfig, case: CaseTable, ensemble: Sequence[Row] | None) -> Iterator[tuple[bool, str]]:
    """Whether a case is as those of the ensemble, and what it should be."""
    shortest, longest = config.wavelengths(case)
    yield config.interatomic.kind in (SPRINGS, "eam", "pair-style"), "it is of springs and metals"
    for value, of_ensemble, name in (
        (config.surface.hurst, HURST, "H"),
        (shortest, LAMBDA_S, "λ_s/a0"),
        (longest / shortest, ROLL_OFF, "λ_L/λ_s"),
        (config.slab.n / shortest, PERIOD, "period/λ_s"),
        (config.slab.depth / shortest, DEPTH, "depth/λ_s"),
    ):
        yield bool(np.isclose(value, of_ensemble)), f"its {name} is {of_ensemble:g}, here {value:g}"
    low, high = min(AREAS), max(AREAS)
    yield all(low <= area <= high for area in case.areas), f"its A_rep/A0 are {low:g} to {high:g}"
    yield not case.jump, "it has no states beside a jump"
    if case.adhesion_length > 0:
        yield bool(np.isclose(case.adhesion_length, ADHESION_LENGTH)), f"its l_a is 0 or {ADHESION_LENGTH:g} a0"
        yield bool(np.allclose(case.rms_slopes, STICKY_SLOPE)), f"its h' with adhesion is {STICKY_SLOPE:g}"
        yield case.branches == ("approach",), "with adhesion it approaches only"
    else:
        least, most = min(PLAIN_SLOPES), max(PLAIN_SLOPES)
        yield all(least <= slope <= most for slope in case.rms_slopes), f"its h' is {least:g} to {most:g}"
    seeds: defaultdict[str, set[int]] = defaultdict(set)
    for row in _others(config, case, ensemble):
        seeds[row.crystal].add(row.seed)
    enough = bool(seeds) and min(map(len, seeds.values())) >= FEWEST
    yield enough, f"it has fewer than {FEWEST} surfaces that are not judged here"


def _others(config: ValidateConfig, case: CaseTable, ensemble: Sequence[Row] | None) -> list[Row]:
    """States of the ensemble like those of a case: not of its crystal, and of springs not of its surfaces."""
    springs, own = config.interatomic.kind == SPRINGS, _crystal_of(config.interatomic)
    return [
        row
        for row in (rows() if ensemble is None else ensemble)
        if (row.adhesion_length > 0) == (case.adhesion_length > 0)
        and (row.crystal == SPRINGS) == springs
        and (row.seed not in config.surface.seeds if springs else row.crystal != own)
    ]


def _crystal_of(interatomic: Interatomic) -> str:
    """How the ensemble calls a crystal: ``springs``, or the name of the file of embedded atoms."""
    return interatomic.file.name if isinstance(interatomic, EmbeddedAtomTable) else interatomic.kind
