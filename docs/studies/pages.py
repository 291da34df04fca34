"""What the pages show of stored data: ``python -m docs.studies.pages`` makes it anew, in all pages of ``docs/``.

A page has it between ``<!--made:NAME-->`` and ``<!--end-->``: a table on lines of its own, or a number within a
sentence.  :data:`MADE` says from which study each comes; a test makes all of them again and compares.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
from pandas import DataFrame, Series, concat, read_csv

from continuum.store.sheet import Sheet
from continuum.theory.paper import PERIMETER_FACTOR
from continuum.theory.rough import KAPPA_BGT, KAPPA_PERSSON
from docs.benchmarks import random_searches
from docs.studies import (
    adhesion_curve_judged,
    bandwidth,
    claims,
    classes,
    decades,
    ensemble,
    exponents,
    figure2,
    figure4,
    first_yield,
    joined_spots,
    judgement,
    law,
    law_bandwidth,
    one_state_judged,
    own_size,
    periods,
    pull_off_judged,
    spots,
    threshold_of_atoms,
)
from docs.studies.judgement import MEASURED, Mean
from docs.studies.tables import KEPT, QUOTED, shown

DOCS = Path(__file__).parents[1]
_MARKED = re.compile(r"<!--made:([\w.-]+)-->(.*?)<!--end-->", re.DOTALL)


@cache
def _stored(name: str) -> DataFrame:
    return read_csv(MEASURED / name)


@cache
def _own() -> dict[str, str]:
    return own_size.quoted()


@cache
def _judged() -> DataFrame:
    return judgement.with_ratios(_stored("law.csv.gz"))


def _largest() -> DataFrame:
    """Of the thresholds that judged the law those on the largest grid, at 1 % of the area."""
    rows = _judged()
    return rows[rows.n == rows.n.max()]


@cache
def _by_moment() -> dict[float, float]:
    return judgement.by_moment(_largest())


def _periods() -> DataFrame:
    return concat([periods.alike(_stored("law.csv.gz")), _stored(periods.FILE)], ignore_index=True)


@cache
def _bandwidths() -> DataFrame:
    return law_bandwidth.with_theories(_stored(law_bandwidth.FILE))


def _period(count: int) -> Mean:
    """w/(U F) on periods of so many λ_L."""
    rows = judgement.with_ratios(_periods())
    return Mean.of(rows[(rows.n / rows.lambda_L).round() == count].groupby("seed").left.mean().to_numpy())


def _change(shape: str, area: float, narrow: int) -> Mean:
    """w/(U F) at four times a bandwidth over that at it."""
    found = law_bandwidth.changes(_bandwidths(), "law")
    (change,) = (mean for *key, mean in found if key == [shape, area, narrow])
    return change


def _of_area(area: float) -> str:
    """Least and largest factor of w at an area over that at 1 %."""
    values = [mean.value for key, mean in judgement.larger(_judged()).items() if key[0] == area]
    return f"{min(values):.1f} to {max(values):.1f}"


def _levels(n: int) -> str:
    """Least and largest mean of w/(U F), of each shape and range."""
    rows = _judged()
    groups = rows[(rows.n == n) & (rows.area == rows.area.min())].groupby(["shape", "delta"])
    values = [Mean.of(part.groupby("seed").left.mean().to_numpy()).value for _, part in groups]
    return f"{min(values):.2f} to {max(values):.2f}"


def _scatter() -> str:
    rows = _largest()
    return f"{100 * (judgement.scatter(rows.left.to_numpy(), rows.seed.to_numpy()) - 1):.0f} %"


def _percent(power: float) -> str:
    return f"{100 * (_by_moment()[power] - 1):.0f} %"


def _atoms(rung: str) -> str:
    """Least and largest mean of the works on a rung over those of the half-space, of a crystal."""
    rows, found = _stored("threshold-atoms.csv"), []
    for _, part in rows.groupby("crystal"):
        wide = np.log(part.pivot(index="seed", columns="rung", values="over_energy"))
        found.append(float(np.exp((wide[rung] - wide["half-space"]).mean())))
    return f"{min(found):.2f} to {max(found):.2f}"


def _one_state(name: str) -> str:
    """Of the thresholds in the range of the statement."""
    rows = one_state_judged.read()
    inside = rows[(rows.how == "threshold") & rows.within]
    return {
        "count": str(len(inside)), "inside": str(inside.inside.sum()),
        "scatter": f"{100 * (one_state_judged.scatter(inside.ratio) - 1):.1f} %",
    }[name]  # fmt: skip


def _bandwidth(wall: str, column: str, width: int) -> str:
    """A mean over surfaces at λ_s = 8."""
    rows = bandwidth.means(bandwidth.stored())
    (row,) = rows[(rows.wall == wall) & (rows.width == width) & (rows.lambda_s == 8)].itertuples()
    return f"{getattr(row, column):.2f}"


def _on_a_gpu(name: str, work: float) -> str:
    """Largest relative difference between a GPU and the CPU, of states of Figure 2 at a work of adhesion."""
    rows = read_csv(KEPT["gpu-3"])
    found = rows[rows["l_a (a0)"] == work][f"{name} over the CPU's, less 1"]
    return f"{found.abs().max():.1e}"


def _claim(sweep: str, claim: str, number: str) -> str:
    """What was found for a claim of the paper in a sweep, from the page of all verdicts: its first such number."""
    text = (MEASURED / "paper.md").read_text(encoding="utf-8").partition(f"### Verdicts of `{sweep}`")[2]
    (row,) = re.findall(rf"^\| {re.escape(claim)} \|(.*)\|$", text.partition("\n### ")[0], re.MULTILINE)
    found = re.search(number, row.split(" | ")[2])
    assert found is not None, row
    return found[1]


def _by_width(claim: str) -> str:
    """Of the systems of Figure 4 on 1024² what was found at the least and at the largest bandwidth."""
    least, most = (_claim("figure4-1024", claim, rf"λ_L/λ_s = {width}: ([\d.]+)") for width in (16, 128))
    return f"{least} to {most}"


_STICKY = "sticky if and only if 1/kappa_att of theory > 1/kappa_rep"


def _missed() -> str:
    """Of the same those that stick and are not predicted to, with κ_rep = 2."""
    numbers = r"(\d+) sticky and predicted", r"(\d+) sticky but not predicted"
    found, missed = (int(_claim("figure4-1024", _STICKY, number)) for number in numbers)
    return f"{missed} of {found + missed}"


def _table(name: str) -> DataFrame:
    """A kept table; numbers without their scatter, percentages as numbers."""

    def value(cell: object) -> object:
        found = re.fullmatch(r"([+-]?[\d.]+)(?: ±.*| %)", str(cell))
        return float(found[1]) if found else cell

    return read_csv(KEPT[name]).map(value)


def _hertz(column: str) -> Series:
    """Relative error of the area of Hertz contacts, by radius in cells."""
    return _table("geometry-2").set_index("a/a0")[column] - 1


def _discs() -> float:
    """Largest relative error of stepped perimeter and chord, of discs with a radius of at least 8 cells."""
    rows = _table("geometry-1")
    return float((rows[rows["R/a0"] >= 8][["P, edges", "chord"]] - 1).abs().max(axis=None))


def _narrow() -> float:
    """Largest deficit of P chord below π A_rep."""
    return 1 - min(float(span.partition(" - ")[0]) for span in _table("geometry-3")["P chord/(π A_rep)"])


def _classical(column: str) -> float:
    """Largest difference, in per cent, between classical contacts and atoms, 64 a side."""
    rows = _table("contacts_of_atoms")
    return float(rows[rows["atoms a side"] == 64][column].abs().max())


def _warm() -> str:
    """Least and largest difference of the load of warm atoms from theory, over it."""
    rows = _table("warm_sphere")
    found = 100 * (rows["N/A0, atoms (E*)"] / rows["theory at 300 K"] - 1).abs()
    return f"{found.min():.1f} to {found.max():.1f} %"


def _peer(grid: str, code: str) -> str:
    """Median of the CPU time of another code over ours, of states on a grid, from the table of the manual."""
    text = (DOCS / "benchmarks.md").read_text(encoding="utf-8")
    (row,) = re.findall(rf"^\|[^|]*\| {grid} \| {code} \|[^|]*\| ([\d.]+),", text, re.MULTILINE)
    return str(row)


@cache
def _optimizers() -> list[dict[str, str]]:
    """The slabs on which all optimizers of ASE were counted in double precision, by column of the benchmarks' table."""
    rows = _sections("benchmarks.md", r"^### (.*)$")["Optimizers"]
    head, _, *rows = [row for row in rows if len(row) == len(rows[0])]
    named = [dict(zip(head, row, strict=True)) for row in rows]
    return [row for row in named if row["LBFGS"] and "float32" not in row["slab"]]


def _evaluations(column: str) -> str:
    """Least and largest number of evaluations: the last number of a cell."""
    found = [float(re.findall(r"[\d.]+", row[column])[-1]) for row in _optimizers()]
    return f"{min(found):.0f} to {max(found):.0f}"


def _halves() -> str:
    """Slabs on which the optimizer and its response take at most half of the evaluations of PreconLBFGS."""

    def of(row: dict[str, str], column: str) -> float:
        return float(re.findall(r"[\d.]+", row[column])[-1])

    ours = [of(row, "GreensRelaxation") + of(row, "response, of a small slab (of the whole)") for row in _optimizers()]
    theirs = [of(row, "PreconLBFGS") for row in _optimizers()]
    count = sum(here <= there / 2 for here, there in zip(ours, theirs, strict=True))
    faces = {
        "(100)" in row["slab"]
        for row, here, there in zip(_optimizers(), ours, theirs, strict=True)
        if here <= there / 2
    }
    assert faces == {True}  # as the page says
    return str(count)


_EXAMPLES = "../measured/examples"
_SAID = {
    "paper.range-9-3": (_EXAMPLES, r"9-3 law \| Δr/a0 \| \S+ \| ([\d.]+)"),
    "paper.range-12-6": (_EXAMPLES, r"12-6 law \| Δr/a0 \| \S+ \| ([\d.]+)"),
    "paper.range-spline": (_EXAMPLES, r"effective over actual range \| within 6 % \| ([\d.]+)"),
    "paths.steps": ("paths", r"With steps of a fifth (\w+ of \d+ states are off by [\d and]+ %)"),
    "paths.yield": ("paths", r"plastic system finds the same points in contact and tractions within (\S+) E\*"),
    "paths.load": ("paths", r"carry a mean load of (\S+) E\*"),
    "paths.scatter": ("paths", r"with a standard deviation of (\S+) E\*"),
    "gradients.differences": ("verification", r"Finite differences agree to (1e-\d+)"),
    "gradients.removed": ("verification", r"taking off a mean of (\S+) a0 makes it stick"),
    "commands.counts": ("benchmarks", r"`atomistic check` were right within a factor of ([\d.]+)"),
    "commands.runs": ("benchmarks", r"For the (\w+) decks of `inputs/lammps` the counts"),
    "commands.times": ("benchmarks", r"and the times within (\w+)\."),
    "substrates.hard": ("verification", r"a solve takes (\d+) times the transforms of a periodic surface"),
    "substrates.law": ("verification", r"under a hard wall, and ([\d.]+ to \d+) times"),
    "substrates.digits": ("verification", r"K_q agrees to (1e-\d+)"),
}
"""Numbers that the text of a study states, each by its page and the words before or after it."""


def _left() -> dict[str, str]:
    """Numbers of studies that have left the tree, by the names that pages have for them."""
    rooms = tomllib.loads((MEASURED / "numbers.toml").read_text(encoding="utf-8"))
    return {f"{room}.{name}": row["value"] for room, rows in rooms.items() for name, row in rows.items()}


def _said(page: str, words: str) -> str:
    text = " ".join((DOCS / "studies" / f"{page}.md").read_text(encoding="utf-8").split())
    (found,) = re.findall(words, text)
    return str(found)


def _power(sweep: str) -> str:
    """Exponent of w in 1/κ_att under weak adhesion."""
    return next(claims.powers(claims.points(sweep)))[1].partition(" of ")[0]


def _sections(page: str, heading: str) -> dict[str, list[list[str]]]:
    """Rows of the tables of a page of studies, under each heading."""
    parts = re.split(heading, (DOCS / "studies" / page).read_text(encoding="utf-8"), flags=re.MULTILINE)
    rows = (re.findall(r"^\|(.*)\|$", part, re.MULTILINE) for part in parts[2::2])
    return {
        name: [[cell.strip() for cell in row.split(" | ")] for row in found]
        for name, found in zip(parts[1::2], rows, strict=True)
    }


def _stress() -> tuple[str, str]:
    """At H = 0.8 and twice the bandwidth, the factor of the pull-off stress at the two largest works, and that of U."""
    rows = pull_off_judged.reduced(_stored(pull_off_judged.FILE))
    falls = [np.exp(pull_off_judged.shortened(rows, 0.8, work).mean()) for work in pull_off_judged.UPPER]
    grows = np.exp(pull_off_judged.grown(rows, 0.8).mean())
    return f"{min(falls):.2f} to {max(falls):.2f}", f"{grows:.2f}"


_CRYSTALS = ("springs", "lennard-jones", "copper", "aluminium", "nickel")


def _budget() -> str:
    """Parts of the load without adhesion at the largest slope, of each crystal, from the budgets in full."""
    found = _sections("budgets.md", r"^## `inputs/validate/([\w-]+)\.toml`$")
    columns = ("depth", "anisotropy", "discreteness", "nonlinearity", "total")
    lines = [f"| crystal | {' | '.join(columns)} |", "|---|---|---|---|---|---|"]
    for name in _CRYSTALS:
        head, _, *rows = found[name]
        (row,) = (row for row in rows if row[:3] == ["nonadhesive", "8", "0.1"])
        lines.append(f"| {name} | {' | '.join(row[head.index(column)] for column in columns)} |")
    return "\n".join(lines)


def _totals(*cases: tuple[str, str, str]) -> str:
    """Least and largest difference of the load between half-space and atoms, by input, case and slope."""
    found = _sections("budgets.md", r"^## `inputs/validate/([\w-]+)\.toml`$")
    totals = [
        float(row[found[name][0].index("total")].removesuffix(" %"))
        for name, *case in cases
        for row in found[name]
        if [row[0], row[2]] == case
    ]
    return f"{min(totals):.0f} to {max(totals):.0f} %"


def _verdicts() -> tuple[int, int]:
    """Verdicts on classes of surfaces: how many, and how many of them wrong."""
    said = [row.said(factor) for row in classes.read() for factor in classes.FACTORS if np.isfinite(row.work)]
    return len(said), said.count("wrong")


def _border() -> str:
    """1/κ_att by theory of the thresholds on surfaces of many slopes, a geometric mean."""
    rows = _stored("paper-slope-figure4.csv")
    return f"{np.exp(np.log(rows[rows.threshold]['1/kappa_att theory']).mean()):.2f}"


_CLAIMS = {
    "linear": ("area is linear in load at low load", r": ([\d.]+ ± [\d.]+)"),
    "pressure": ("the repulsive pressure is unchanged by adhesion", r": ([\d.]+ ± [\d.]+)"),
    "attraction": ("N_att = (w/range) A_att", r": ([\d.]+ ± [\d.]+)"),
    "strip": ("A_att is a strip of width d_att along the perimeter", r": ([\d.]+ ± [\d.]+)"),
    "perimeter": ("P d = pi A_rep where d > 10 a0", r": ([\d.]+ ± [\d.]+)"),
    "same-diameter": ("d_rep is unchanged by adhesion", r": ([\d.]+ ± [\d.]+)"),
    "constant-diameter": ("d_rep changes by less than 25 % with area", r": ([\d.]+ ± [\d.]+)"),
    "constant-ratio": ("A_rep/A_att does not change with load", r": ([\d.]+ ± [\d.]+)"),
    "stiffness": ("the stiffness is lowered by kappa_rep/kappa, where not sticky", r": ([\d.]+ ± [\d.]+)"),
    "gap": ("mean gap against N_rep is unchanged by adhesion, where not sticky", r": ([\d.]+ ± [\d.]+)"),
    "asperities": ("Greenwood-Williamson theories fall orders of magnitude below N_max", r": ([\d.]+ ± [\d.]+)"),
}
"""Claims of the paper, each with the number that the table of the manual quotes."""


def _deck_costs() -> str:
    """Atoms, evaluations of the forces and core-seconds in the heads of the inputs of decks."""
    rows = []
    for path in sorted((DOCS.parent / "inputs" / "lammps").glob("*.toml")):
        found = re.search(
            r"# Cost +([\d.]+) core-seconds?, ([\d ]+) force evaluations of ([\d ]+) atoms",
            path.read_text(encoding="utf-8"),
        )
        assert found is not None, path
        rows.append([f"`{path.name}`", found[3], found[2], found[1]])
    return Sheet.of("costs", ["input", "atoms", "force evaluations", "core-seconds"], rows).markdown()


MADE: dict[str, Callable[[], str]] = {
    "deck-costs.inputs": _deck_costs,
    **{f"table.{name}": lambda file=file: shown(file) for name, file in KEPT.items() if name not in QUOTED},
    **{
        f"gpu.{name}-{work}": lambda name=name, work=work: _on_a_gpu(name, work)
        for name in ("load", "area")
        for work in (0.0, 0.005)
    },
    "ensemble.limits": ensemble.limits,
    "judgement": lambda: judgement.tables(_judged()),
    "law_bandwidth": lambda: "\n".join(law_bandwidth.judged(_bandwidths())),
    "pull_off": lambda: pull_off_judged.tables(_stored(pull_off_judged.FILE)),
    "threshold_of_atoms": lambda: threshold_of_atoms.table(_stored("threshold-atoms.csv")),
    "one_state": lambda: "\n".join(one_state_judged.shown(one_state_judged.read())),
    "adhesion_curve": lambda: adhesion_curve_judged.verdicts(adhesion_curve_judged.read()).markdown(),
    "adhesion_curve.probe": lambda: adhesion_curve_judged.by_unloaded(adhesion_curve_judged.read()).markdown(),
    "adhesion_curve.kinds": lambda: adhesion_curve_judged.by_kind(adhesion_curve_judged.read()).markdown(),
    "adhesion_curve.worst": lambda: adhesion_curve_judged.whole(adhesion_curve_judged.read()),
    "adhesion_curve.loops": lambda: str(len(adhesion_curve_judged.read())),
    "spots": lambda: spots.judged(_stored("spots.csv")).markdown(),
    "spots.states": lambda: spots.states(_stored("roll-offs.csv")).markdown(),
    "joined_spots": lambda: joined_spots.by_kind(joined_spots.read()).markdown(),
    "joined_spots.verdicts": lambda: joined_spots.verdicts(joined_spots.read()),
    "spots.verdicts": lambda: spots.verdicts(_stored("spots.csv")),
    "classes": lambda: classes.verdicts(classes.read()).markdown(),
    "bandwidth": lambda: bandwidth.found(bandwidth.stored()),
    "figure2": lambda: "\n".join(figure2.lines()),
    "figure2.returns": lambda: "\n".join(figure2.returns()),
    "figure2.judged": lambda: "\n".join(figure2.judged()),
    **{
        f"first_yield.{run}-steps": lambda run=run: first_yield.table(_stored(first_yield.STEPS), run)
        for run in ("yield", "deeper")
    },
    **{
        f"first_yield.{run}-{name}": lambda run=run, name=name: first_yield.quoted(_stored(first_yield.FILE), run, name)
        for run, names in (("yield", first_yield.QUOTED), ("deeper", first_yield.QUOTED[4:7] + first_yield.QUOTED[-3:]))
        for name in names
    },
    # An exponent of zero has no sign.
    "exponents": lambda: exponents.tables().replace("-0.00 (", "+0.00 ("),
    "dispute.limits": exponents.limits,
    **{f"dispute.{name}": lambda name=name: exponents.quoted()[name] for name in exponents.QUOTED},
    "dispute.stress": lambda: _stress()[0],
    "dispute.energy": lambda: _stress()[1],
    "figure4.ratios": lambda: "\n".join(figure4.ratios()),
    "figure4.sticky": lambda: "\n".join(figure4.sticky()),
    "figure4.off-1024": lambda: figure4.off_by_two("figure4-1024"),
    "figure4.off-2048": lambda: figure4.off_by_two("figure4-2048"),
    "figure4.kappa": figure4.kappa_rep,
    "figure4.roll-off": figure4.roll_off,
    "figure4.pressure": lambda: _claim("figure4-1024", *_CLAIMS["pressure"]),
    "figure4.asperities": lambda: _claim("figure4-2048", *_CLAIMS["asperities"]),
    "figure4.lambda-L": lambda: _claim("bandwidth", "kappa does not depend on lambda_L", r"at most ([\d.]+)"),
    "budget": _budget,
    "searches.random": lambda: random_searches.table(
        {"three searches": MEASURED / "random-searches-before.csv", "one search": MEASURED / "random-searches.csv"}
    ),
    "searches.dearer": lambda: random_searches.dearer(
        MEASURED / "random-searches-before.csv", MEASURED / "random-searches.csv"
    ),
    "claims": lambda: "\n".join(claims.lines()),
    "law.values": law.values,
    "law.count": lambda: str(len(_largest())),
    "law.surfaces": lambda: str(_largest().seed.nunique()),
    "law.scatter": _scatter,
    "law.height": lambda: _percent(0),
    "law.slope": lambda: _percent(2),
    "law.curvature": lambda: _percent(4),
    "law.moment": lambda: str(judgement.moment(_largest())),
    "law.exponent": lambda: str(judgement.exponent(_largest())),
    "law.level": lambda: _levels(1024),
    "law.level-512": lambda: _levels(512),
    "law.area-2": lambda: _of_area(0.02),
    "law.area-4": lambda: _of_area(0.04),
    "law.wide": lambda: str(_change("spline", 0.01, 128)),
    "law.atoms": lambda: _atoms("atoms"),
    **{
        f"paper.{name}": lambda name=name: _claim("figure2-4096", *_CLAIMS[name])
        for name in ("strip", "constant-diameter", "constant-ratio", "stiffness", "gap", "asperities")
    },
    **{
        f"paper.{name}-by-width": lambda name=name: _by_width(_CLAIMS[name][0])
        for name in ("pressure", "attraction", "strip", "same-diameter")
    },
    "paper.linear-1024": lambda: _claim("figure4-1024", *_CLAIMS["linear"]),
    "paper.perimeter-1024": lambda: _claim("figure4-1024", *_CLAIMS["perimeter"]),
    "paper.asperities-1024": lambda: _claim("figure4-1024", *_CLAIMS["asperities"]),
    "paper.asperities-2048": lambda: _claim("figure4-2048", *_CLAIMS["asperities"]),
    "paper.missed": _missed,
    "paper.missed-where": lambda: _claim("figure4-1024", _STICKY, r"but not predicted \((λ_s = [^)]*)\)"),
    "paper.missed-measured": lambda: _claim("figure4-1024", _STICKY, r"κ_rep as measured: .*?, (\d+) sticky but"),
    "paper.asperity-kappa": lambda: f"{KAPPA_BGT:.2f}",
    "paper.persson-kappa": lambda: f"{KAPPA_PERSSON:.2f}",
    "paper.beta": lambda: f"{PERIMETER_FACTOR:.4f}",
    "own": lambda: "\n".join(own_size.table()),
    "own.widths": lambda: "\n".join(own_size.widths()),
    "own.systems": lambda: "\n".join(own_size.systems()),
    **{f"own.{name}": lambda name=name: _own()[name] for name in own_size.QUOTED},
    "decades": lambda: "\n".join(decades.table()),
    **{f"decades.{name}": lambda name=name: decades.quoted()[name] for name in decades.QUOTED},
    "claims.power-1024": lambda: _power("figure4-1024"),
    "budget.half-space": lambda: _totals(*((name, "nonadhesive", "0.1") for name in _CRYSTALS)),
    "budget.strong": lambda: _totals(("springs", "strong-adhesion", "0.05"), ("lennard-jones", "jump-in", "0.1")),
    "classes.count": lambda: str(_verdicts()[0]),
    "classes.wrong": lambda: str(_verdicts()[1] or "none"),
    "slope.border": _border,
    "paper.lambda-L": lambda: _claim("bandwidth", "kappa does not depend on lambda_L", r"at most ([\d.]+)"),
    "claims.necessary": lambda: claims.necessary(claims.points("figure4-1024")),
    "claims.apart": lambda: claims.tensions(claims.points("figure4-1024"))[0],
    "claims.ranks": lambda: claims.tensions(claims.points("figure4-1024"))[1],
    "claims.within": lambda: ", ".join(claims.within_range()),
    "paper.profile": lambda: _claim(
        "stiffness-reduced",
        "the gap outside a contact is that of Eq. (S-1), x^(3/2), where it reaches the range",
        r": ([\d.]+ ± [\d.]+)",
    ),
    **{name: lambda asked=asked: _said(*asked) for name, asked in _SAID.items()},
    **{name: lambda value=value: value for name, value in _left().items()},
    **{
        f"peers.{name}-{n}": lambda n=n, code=code: _peer(f"{n}²", code)
        for name, code in (("aspher", "ASPHER"), ("adhesion", "Adhesion"), ("tamaas", "ContactMechanics, Tamaas"))
        for n in (512, 1024)
    },
    "atoms.slabs": lambda: str(len(_optimizers())),
    "atoms.halves": _halves,
    "atoms.response": lambda: _evaluations("response, of a small slab (of the whole)"),
    **{f"atoms.{name}": lambda name=name: _evaluations(name) for name in ("GreensRelaxation", "PreconLBFGS")},
    "trust.peak": lambda: f"{_classical('theory: peak'):.0f} %",
    "trust.lattice": lambda: f"{_classical('lattice: load'):.2f} %",
    "trust.warm": _warm,
    "geometry.discs": lambda: f"{100 * _discs():.1f} %",
    "geometry.hertz-2": lambda: f"{100 * _hertz('cells')[2]:.0f} %",
    "geometry.hertz-8": lambda: f"{100 * _hertz('cells')[8]:.0f} %",
    "geometry.corrected": lambda: f"{100 * _hertz('corrected').abs().max():.0f} %",
    "geometry.narrow": lambda: f"{100 * _narrow():.0f} %",
    **{f"law.period-{count}": lambda count=count: str(_period(count)) for count in (16, 2, 1)},
    **{f"one_state.{name}": lambda name=name: _one_state(name) for name in ("count", "inside", "scatter")},
    **{
        f"bandwidth.{name}-{width}": lambda wall=wall, column=column, width=width: _bandwidth(wall, column, width)
        for name, wall, column in (
            ("hard", "hard", "kappa_rep"),
            ("ratio", "lennard-jones-spline, l_a = 0.005", "ratio"),
            ("diameter", "hard", "diameter_ratio"),
            ("attraction", "lennard-jones-spline, l_a = 0.005", "attraction"),
        )
        for width in (16, 256)
    },
}


def marked(text: str) -> list[tuple[str, str]]:
    """Names of what a page has made, each with what stands there."""
    return [(name, held.strip()) for name, held in _MARKED.findall(text)]


def made_anew(text: str) -> str:
    """A page with all that is made in it made again."""

    def again(found: re.Match[str]) -> str:
        new, old = MADE[found[1]]().strip(), found[2]
        # A table needs lines of its own.
        new = f"\n\n{new}\n\n" if "\n" in new or old.startswith("\n") else new
        return f"<!--made:{found[1]}-->{new}<!--end-->"

    return _MARKED.sub(again, text)


def pages() -> list[Path]:
    """Of the site, without what is made with it."""
    return [path for path in sorted(DOCS.rglob("*.md")) if "reference" not in path.relative_to(DOCS).parts]


def main() -> None:
    """Rewrite the pages in which something has changed."""
    for page in pages():
        text = page.read_text(encoding="utf-8")
        if (new := made_anew(text)) != text:
            page.write_text(new, encoding="utf-8")


if __name__ == "__main__":
    main()
