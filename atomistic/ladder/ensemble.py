"""Bounds for new surfaces and metals, from quantiles of an ensemble of earlier runs.

``ensemble.csv``, made by ``docs/studies/ensemble.py``, has the differences of neighbouring rungs, and of half-space and
atoms, in each state of eight surfaces on springs and on three metals, of sixteen on deeper springs, and of eight on
deeper slabs of two metals and of Lennard-Jones.  A step without
``[[tolerance]]`` is judged by similar cases: depth, anisotropy, discreteness and the total by |N difference|/(N_rep +
N_att) = a, the nonlinearity without adhesion by |N difference|/N_rep = a h' and |u difference| = b a0 h'², with it by
c h' of all that acts.

Each surface and crystal has a coefficient, that of its worst state.  Over the surfaces of one crystal the logarithms of
those of the nonlinearity are taken as normal, and of the other steps, whose differences have either sign and may be
about zero, the coefficients themselves: the limit is that which a further surface exceeds with the probability
:data:`RARE` (Student's t, G. J. Hahn, J. Am. Stat. Assoc. 64, 878 (1969)), shared among the surfaces of the case.  For
metals the largest limit is taken: of k + 1 similar ones, a given one has the largest with the probability 1/(k + 1).
The judged case is left out of its own bound: its crystal, or for springs and Lennard-Jones its surfaces.
"""

from collections import defaultdict
from collections.abc import Mapping
from functools import cache
from importlib import resources
from typing import NamedTuple

import numpy as np
import scipy

from atomistic.inputs.validate import BoundTable, CaseTable, Compared, Step, ValidateConfig

RARE = 0.01
"""Probability with which one of the surfaces of a case breaks a bound that is right."""
FEWEST = 8
"""Smallest number of surfaces of a crystal for a bound."""
SPRINGS = "springs"
ALONE = (SPRINGS, "lennard-jones")
"""Crystals that no other is like: they are judged by other surfaces of their own."""
HURST, LAMBDA_S, ROLL_OFF, PERIOD = 0.8, 8.0, 2.0, 4.0
"""Parameters of the surfaces of the ensemble: H, λ_s in a0; λ_L and period in λ_s."""
LINEAR: tuple[Step, ...] = ("depth", "anisotropy", "discreteness", "total")
"""Steps whose differences do not vanish with the slope."""
_PLAIN: tuple[tuple[Step, Compared, int], ...] = (("nonlinearity", "load", 1), ("nonlinearity", "displacement", 2))
_STICKY: tuple[tuple[Step, Compared, int], ...] = (("nonlinearity", "gross_load", 1),)
"""Step, quantity and power of the slope of the nonlinearity, without and with adhesion."""


class Row(NamedTuple):
    """One state of the ensemble: differences of lattice response and atoms, and of all other rungs."""

    crystal: str
    """``springs``, ``lennard-jones``, or the name of the file of the potential."""
    depth: float
    """Depth of the slab, in λ_s."""
    adhesion_length: float
    """In a0."""
    seed: int
    rms_slope: float
    area: float
    branch: str
    load: float
    """|N difference|/N_rep."""
    gross_load: float
    """|N difference|/(N_rep + N_att)."""
    displacement: float
    """Largest |u difference|, in a0."""
    depth_gross_load: float
    """|N difference|/(N_rep + N_att) of half-space and layer."""
    anisotropy_gross_load: float
    """The same of layer and cubic layer."""
    discreteness_gross_load: float
    """The same of cubic layer and lattice response."""
    total_gross_load: float
    """The same of half-space and atoms."""


@cache
def rows() -> tuple[Row, ...]:
    """The states of the ensemble."""
    file = resources.files("atomistic.ladder") / "ensemble.csv"
    with file.open(encoding="utf-8") as lines:
        table = np.genfromtxt(lines, delimiter=",", names=True, dtype=None, encoding="utf-8")
    return tuple(Row(*row) for row in table[list(Row._fields)].tolist())


def limit(
    coefficients: Mapping[str, Mapping[int, float]], surfaces: int, *, logarithms: bool = True
) -> tuple[float, str]:
    """Largest limit of all crystals, which a further surface rarely exceeds, and the crystal that has it.

    Parameters
    ----------
    coefficients : coefficients of each crystal, by the seed of the surface.
    surfaces : number of surfaces judged together.
    logarithms : whether the logarithms of the coefficients are normal, or the coefficients themselves.
    """
    found = {}
    for crystal, by_seed in coefficients.items():
        values = np.array(list(by_seed.values()))
        values = np.log(values) if logarithms else values
        # scipy.stats, which has it too, takes a second to import.
        quantile = float(scipy.special.stdtrit(len(values) - 1, 1 - RARE / surfaces))
        most = float(values.mean() + quantile * values.std(ddof=1) * np.sqrt(1 + 1 / len(values)))
        found[crystal] = float(np.exp(most)) if logarithms else most
    largest = max(found, key=lambda crystal: found[crystal])
    return found[largest], largest


def carried_bounds(config: ValidateConfig, case: CaseTable) -> tuple[BoundTable, ...]:
    """Bounds of all steps of a case; empty if the ensemble does not cover it: see :func:`untested`."""
    alike, outside = _alike(config, case)
    if outside:
        return ()
    nonlinear = _STICKY if case.adhesion_length > 0 else _PLAIN
    found = []
    linear: tuple[tuple[Step, Compared, int], ...] = tuple((step, "gross_load", 0) for step in LINEAR)
    for step, quantity, power in (*linear, *nonlinear):
        name = quantity if step == "nonlinearity" else f"{step}_{quantity}"
        worst: defaultdict[str, dict[int, float]] = defaultdict(dict)
        for row in alike:
            scaled = float(getattr(row, name)) / row.rms_slope**power
            worst[row.crystal][row.seed] = max(scaled, worst[row.crystal].get(row.seed, 0.0))
        coefficient, crystal = limit(worst, len(config.surface.seeds), logarithms=step == "nonlinearity")
        crystals = crystal if len(worst) == 1 else f"each of {len(worst)} crystals, the largest that of {crystal}"
        reason = (
            f"from {min(map(len, worst.values()))} other surfaces of {crystals}; similar surfaces exceed a bound "
            f"with a probability of {RARE:g}"
        )
        found.append(BoundTable(step=step, quantity=quantity, coefficient=coefficient, power=power, reason=reason))
    return tuple(found)


def untested(config: ValidateConfig, case: CaseTable) -> str:
    """Reason why the ensemble has no bounds for a case; empty if it has."""
    return "; ".join(_alike(config, case)[1])


def _alike(config: ValidateConfig, case: CaseTable) -> tuple[list[Row], tuple[str, ...]]:
    """States of the ensemble for a case, and the properties of the case outside the ensemble.

    Judged ones are left out: for metals their crystal, for others their surfaces.
    """
    own, judged = config.interatomic.crystal_name, config.surface.seeds
    if (alone := config.interatomic.kind) in ALONE:
        alike = [row for row in rows() if row.crystal == alone and row.seed not in judged]
    else:
        alike = [row for row in rows() if row.crystal not in (*ALONE, own)]
    shortest, longest = config.wavelengths(case)
    conditions: list[tuple[bool, str]] = []
    conditions.append(
        (config.interatomic.kind in (*ALONE, "eam", "pair-style"), "it is of springs, Lennard-Jones and metals")
    )
    for value, of_ensemble, name in (
        (config.surface.hurst, HURST, "H"),
        (shortest, LAMBDA_S, "λ_s/a0"),
        (longest / shortest, ROLL_OFF, "λ_L/λ_s"),
        (config.slab.n / shortest, PERIOD, "period/λ_s"),
    ):
        conditions.append((bool(np.isclose(value, of_ensemble)), f"its {name} is {of_ensemble:g}, here {value:g}"))
    conditions.append((not case.jump, "it has no states beside a jump"))
    for value, column, name in (
        (config.slab.depth / shortest, "depth", "depth/λ_s"),
        (case.adhesion_length, "adhesion_length", "l_a/a0"),
    ):
        known = sorted({float(getattr(row, column)) for row in alike})
        alike = [row for row in alike if np.isclose(getattr(row, column), value)]
        words = " or ".join(f"{each:g}" for each in known)
        conditions.append((bool(alike) or not known, f"its {name} is {words}, here {value:g}"))
    if case.adhesion_length > 0:
        followed = {*case.branches} <= {row.branch for row in alike}
        conditions.append((followed or not alike, "with adhesion it approaches only"))
        alike = [row for row in alike if row.branch in case.branches]
    for values, column, name in ((case.areas, "area", "A_rep/A0"), (case.rms_slopes, "rms_slope", "h'")):
        known = sorted({float(getattr(row, column)) for row in alike})
        inside = not known or all(known[0] <= value <= known[-1] for value in values)
        conditions.append(
            (inside, f"its {name} is {' to '.join(f'{each:g}' for each in known[:: len(known) - 1 or 1])}")
        )
    seeds: defaultdict[str, set[int]] = defaultdict(set)
    for row in alike:
        seeds[row.crystal].add(row.seed)
    enough = bool(seeds) and min(map(len, seeds.values())) >= FEWEST
    outside = tuple(said for inside, said in conditions if not inside)
    return alike, outside or (() if enough else (f"it has fewer than {FEWEST} surfaces that are not judged here",))
