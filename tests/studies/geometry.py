"""The measurements behind docs/geometry.md: ``python -m tests.studies.geometry PART ...``.

Each part takes one to four minutes on one core, draws docs/geometry-PART.png and writes its table to the terminal.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from continuum.measure.contact import totals_of
from continuum.measure.curve import Adhesion, Curve, adhesion
from continuum.measure.outline import areas, outline
from continuum.measure.profile import GapProfile, gap_profile
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem
from continuum.model.substrates import HalfSpace
from continuum.model.surface import moments
from continuum.model.walls import HardWall
from continuum.path.loading import follow
from continuum.runs.analysis import gap_ratio
from continuum.show import plot
from continuum.solve.solution import Settings
from continuum.solve.solver import Solver
from continuum.theory import paper
from tests.problems import Rough
from tests.studies.contacts import RoughContact, contacts

DOCS = Path(__file__).parents[2] / "docs"
MARKERS = {0.3: "^", 0.5: "s", 0.8: "o"}
COLOURS = {0.0005: "black", 0.005: "#0072b2", 0.05: "#d55e00", 0.0: "0.5"}


def table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
    """Write a table as markdown."""
    cells = [[f"{c:.3g}" if isinstance(c, float) else str(c) for c in row] for row in rows]
    lines = [head, ["---"] * len(head), *cells]
    sys.stdout.write("\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n\n")


# --- perimeter: the paper's Fig. S-2 -----------------------------------------------------------------------


def perimeter_contacts(target: float = 0.01) -> Iterator[RoughContact]:
    """The paper's surfaces at 1 % area; half the size is as many asperities where λ_s is small."""
    for lambda_s in (4, 8, 16, 32, 64):
        for slope in (0.1, 0.3):
            for hurst in (0.3, 0.5, 0.8):
                for length in (0.0005, 0.005, 0.05):
                    yield from contacts(
                        Rough(512 if lambda_s < 16 else 1024, length, lambda_s, hurst=hurst, slope=slope),
                        [target],
                        within=0.2,
                    )


def perimeter_ratio(contact: RoughContact) -> float:
    """P chord/(π A_rep) with the paper's correction."""
    n = contact.numbers
    return n.perimeter * n.chord / (np.pi * n.area_rep * contact.grid.area)


@plot.styled
def perimeter() -> None:
    """P chord/(π A_rep) against the chord."""
    figure = plot.new_figure(plot.PAGE, 3.2)
    left, right = figure.subplots(1, 2)
    found: dict[float, list[RoughContact]] = {}
    for c in perimeter_contacts():
        found.setdefault(c.rough.lambda_s, []).append(c)
        filled = COLOURS[c.rough.adhesion_length] if c.rough.slope == 0.1 else "none"
        style = {
            "marker": MARKERS[c.rough.hurst],
            "color": COLOURS[c.rough.adhesion_length],
            "markerfacecolor": filled,
            "markersize": 1.5 + np.log2(c.rough.lambda_s),
            "alpha": 1.0 if c.numbers.area_rep * c.grid.area >= 10 * c.rough.lambda_s**2 else 0.3,
        }
        left.semilogx(c.numbers.chord, perimeter_ratio(c), **style)
        right.loglog(c.expected_diameter, c.numbers.diameter, **style)
    rows = []
    for lambda_s, group in found.items():
        chord, ratio = np.array([[c.numbers.chord, perimeter_ratio(c)] for c in group]).T
        width = np.array([c.numbers.diameter / c.expected_diameter for c in group])
        rows.append(
            [
                lambda_s,
                f"{chord.min():.3g} - {chord.max():.3g}",
                f"{ratio.min():.3f} - {ratio.max():.3f}",
                f"{ratio.mean():.3f}",
                f"{width.min():.2f} - {width.max():.2f}",
            ]
        )
    table(["λ_s", "chord", "P chord/(π A_rep)", "mean", "d_rep/(4h'/h'')"], rows)
    left.axhspan(0.9, 1.1, color="0.92", zorder=0)
    left.axvline(10, color="0.7", linewidth=0.6)  # ten a0: above, the cells count little
    for hurst, marker in MARKERS.items():
        left.plot([], [], marker, color="0.3", label=f"H = {hurst}")
    for length in (0.0005, 0.005, 0.05):
        left.plot([], [], "o", color=COLOURS[length], label=rf"$\ell_a$ = {length:g} $a_0$")
    left.plot([], [], "o", color="0.3", label="$h'_{rms}$ = 0.1")
    left.plot([], [], "o", color="0.3", markerfacecolor="none", label="$h'_{rms}$ = 0.3")
    left.plot([], [], "o", color="0.3", alpha=0.3, label=r"$A_{rep} < 10\lambda_s^2$")
    left.legend(ncols=3, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    for lambda_s in found:
        right.plot(
            [], [], "o", color="0.3", markersize=1.5 + np.log2(lambda_s), label=rf"$\lambda_s$ = {lambda_s:g} $a_0$"
        )
    right.plot([], [], color="0.6", linewidth=0.8, label="equal (band: factor of two)")
    right.legend(ncols=2, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    left.set_xticks([3, 5, 10, 20, 50], labels=["3", "5", "10", "20", "50"])
    left.minorticks_off()
    left.set_xlabel("mean chord ($a_0$)")
    left.set_ylabel(r"$P\,\ell/(\pi A_{rep})$")
    ends = np.array([3.0, 120.0])
    right.loglog(ends, ends, "-", color="0.6", linewidth=0.8)
    right.fill_between(ends, ends / 2, ends * 2, color="0.92", zorder=0)
    right.set_xlabel(r"$4h'_{rms}/h''_{rms}$ ($a_0$)")
    right.set_ylabel(r"$d_{rep} = \pi A_{rep}/P$ ($a_0$)")
    plot.save(figure, DOCS / "geometry-perimeter")


# --- diameter: d_rep over decades of area -------------------------------------------------------------------

AREAS = (0.001, 0.003, 0.01, 0.03, 0.1)


@plot.styled
def diameter() -> None:
    """d_rep against the area."""
    figure = plot.new_figure(plot.COLUMN, 2.8)
    axis = figure.subplots()
    rows = []
    cases = (
        Rough(2048, 0.0, 16),
        Rough(2048, 0.005, 16),
        Rough(1024, 0.0, 8),
        Rough(1024, 0.0, 8, hurst=0.3),
        Rough(1024, 0.0, 8, hard=True),
    )
    for i, rough in enumerate(cases):
        measured = list(contacts(rough, AREAS, within=0.1))
        d = np.array([c.numbers.diameter for c in measured])
        area = np.array([c.numbers.area_rep for c in measured])
        expected = measured[0].expected_diameter
        name = "hard" if rough.hard else f"l_a = {rough.adhesion_length:g}"
        rows.append([rough.lambda_s, rough.hurst, name, expected, *d.tolist(), float(d.max() / d.min())])
        label = rf"$\lambda_s$ = {rough.lambda_s:g}, H = {rough.hurst}, {name.replace('l_a', '$l_a$')}"
        axis.semilogx(area, d / expected, "o-", color=plot.SERIES[i], markerfacecolor="none", label=label)
    table(["λ_s", "H", "wall", "4h'/h''", *(f"A = {a:g}" for a in AREAS), "max/min"], rows)
    axis.axhspan(0.5, 2, color="0.94", zorder=0)
    axis.set_ylim(0, 2.2)
    axis.set_xlabel(r"$A_{rep}/A_0$")
    axis.set_ylabel(r"$d_{rep}/(4h'_{rms}/h''_{rms})$")
    axis.legend()
    plot.save(figure, DOCS / "geometry-diameter")


# --- gap: the profile outside the contact, and d_att --------------------------------------------------------


def profile_of(contact: RoughContact) -> GapProfile:
    """Gap profile up to the mean diameter."""
    zero = contact.rough.wall.zero_gap
    return gap_profile(contact.grid, contact.gap, contact.repulsive, contact.numbers.diameter, zero)


def ratio(contact: RoughContact, profile: GapProfile, *, centres: bool) -> tuple[float, float]:
    """Smallest and largest ratio to Eq. (S-1), counted from the edge or from the centres of the perimeter cells."""
    return gap_ratio(profile, contact.moments.rms_slope, contact.numbers.diameter, from_perimeter_cells=centres)


@plot.styled
def gap() -> None:
    """Ratio of the gap to Eq. (S-1); d_att against Eq. (S-2)."""
    figure = plot.new_figure(plot.PAGE, 3.2)
    left, right = figure.subplots(1, 2)
    rows = []
    cases = [Rough(2048, 0.0, s, hard=True, seed=seed) for s in (32, 64) for seed in (1, 2)]
    cases += [Rough(2048, length, s) for s in (32, 64) for length in (0.0, 0.0005, 0.005, 0.05)]
    for rough in cases:
        (c,) = contacts(rough, [0.01])
        found, wall = profile_of(c), rough.wall
        name = f"hard, seed {rough.seed}" if rough.hard else f"l_a = {rough.adhesion_length:g}"
        label = f"seed {rough.seed}" if rough.hard else rf"$\ell_a$ = {rough.adhesion_length:g} $a_0$"
        edge, centres = ratio(c, found, centres=False), ratio(c, found, centres=True)
        width = expected = rim = np.nan
        if wall.range > 0:
            width = found.width(wall.range)
            expected = paper.attraction_width(c.moments.rms_slope, c.numbers.diameter, wall.range)
            rim = c.numbers.area_att * c.grid.area / c.numbers.perimeter
        rows.append(
            [
                rough.lambda_s, name, c.numbers.diameter, f"{edge[0]:.2f} - {edge[1]:.2f}",
                f"{centres[0]:.2f} - {centres[1]:.2f}", width, rim, expected,
            ]
        )  # fmt: skip
        axis = left if rough.hard else right
        colour = plot.SERIES[rough.seed - 1] if rough.hard else COLOURS[rough.adhesion_length]
        line = "-" if rough.lambda_s == 32 else "--"
        y = found.gap / paper.gap_profile(found.distance, c.moments.rms_slope, c.numbers.diameter)
        axis.plot(
            found.distance / c.numbers.diameter,
            y,
            line,
            color=colour,
            label=label if rough.lambda_s == 32 else None,
        )
    head = ["λ_s", "wall", "d_rep", "ratio, from the edge", "from perimeter cells", "d_att", "A_att/P", "Eq. (S-2)"]
    table(head, rows)
    for axis, title in ((left, "hard wall, two surfaces"), (right, "the paper's law, one surface")):
        axis.set_title(title)
        axis.plot([], [], "-", color="0.3", label=r"$\lambda_s$ = 32 $a_0$")
        axis.plot([], [], "--", color="0.3", label=r"$\lambda_s$ = 64 $a_0$")
        axis.axhspan(0.8, 1.3, color="0.92", zorder=0, label="0.8 to 1.3")
        axis.set_xlim(0, 0.6)
        axis.set_ylim(0.5, 2)
        axis.set_xlabel("$x/d_{rep}$, from the edge")
        axis.legend(ncols=2)
    left.set_ylabel("mean gap / Eq. (S-1)")
    plot.save(figure, DOCS / "geometry-gap")


# --- pull-off: dependence on the peak load -------------------------------------------------------------------


def cycle(problem: ContactProblem, deepest: float, points: int, settings: Settings) -> tuple[Adhesion, Curve, float]:
    """Approach to a mean gap and back; with the largest repulsive area."""
    top = problem.wall.zero_gap - float(problem.heights.min()) + problem.wall.range
    there = np.linspace(top, deepest, points)
    rows, area = [], 0.0
    for state in follow(problem, "mean-gap", [*there, *there[-2::-1]], settings):
        assert state.status.ok
        rows.append((state.mean_gap, state.separation, state.load))
        if len(rows) == points:
            area = totals_of(problem.grid, problem.wall, state.gap).area_rep
    mean_gap, separation, load = np.array(rows).T
    curve = Curve(mean_gap, separation, load, np.arange(load.size) >= points)
    return adhesion(curve), curve, area


DEEPEST = (3.0, 2.4, 1.8, 1.4, 1.1, 0.97)
"""Mean gaps at which the cycles turn, in a0."""


@plot.styled
def pull_off() -> None:
    """Pull-off force and work of separation against how deep the approach went."""
    figure = plot.new_figure(plot.PAGE, 3.2)
    left, right = figure.subplots(1, 2)
    rows = []
    for length, colour in ((0.005, COLOURS[0.005]), (0.05, COLOURS[0.05])):
        problem = Rough(256, length, 16.0).problem()
        m, wall = moments(problem.grid, problem.heights), problem.wall
        peaks, forces = [], []
        for deepest in DEEPEST:
            found, curve, largest = cycle(problem, deepest, 41, Settings(1e-6 * m.rms_slope))
            if deepest == DEEPEST[-1]:  # the other cycles turn back earlier and follow it
                for way, style in ((~curve.retracting, "."), (curve.retracting, "s")):
                    # Points only: between many of them the contact jumps.
                    left.plot(curve.mean_gap[way], curve.load[way] / m.rms_slope, style, color=colour, mfc="none")
            rows.append(
                [
                    length, deepest, largest, found.peak_load, found.largest_tension, found.pull_off,
                    found.work_of_separation / wall.work_of_adhesion, found.loss / wall.work_of_adhesion,
                ]
            )  # fmt: skip
            peaks.append(largest)
            forces.append(found.pull_off)
        right.plot(peaks, forces, "o-", color=colour, markerfacecolor="none", label=rf"$\ell_a$ = {length:g} $a_0$")
    head = ["l_a", "deepest gap", "largest A_rep", "peak load", "tension on approach", "pull-off", "work/w", "loss/w"]
    table(head, rows)
    left.set_xlabel("mean gap ($a_0$)")
    left.set_ylabel(r"$N/(h'_{rms} E^* A_0)$")
    left.set_ylim(-0.13, 0.1)
    left.axhline(0, color="0.7", linewidth=0.6)
    left.plot([], [], ".", color="0.3", mfc="none", label="approach")
    left.plot([], [], "s", color="0.3", mfc="none", label="retraction")
    left.legend()
    right.set_xlabel(r"largest repulsive area $A_{rep}/A_0$")
    right.set_ylabel("pull-off tension ($E^*$)")
    right.set_yscale("log")
    right.legend()
    plot.save(figure, DOCS / "geometry-pull-off")


# --- discs: convergence of perimeter and chord ---------------------------------------------------------------


def discs() -> None:
    """Perimeter and chord of discs against exact values."""
    rng, rows = np.random.default_rng(1), []
    for radius in (2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0, 256.0):
        found = []
        for _ in range(40):
            grid = Grid.square(int(2 * radius) + 9)
            x, y = grid.positions
            middle = grid.lengths[0] / 2 + rng.random(2)
            rim = outline(grid, np.hypot(x - middle[0], y - middle[1]) < radius)
            exact, chord = 2 * np.pi * radius, np.pi * radius / 2
            lengths = [rim.perimeter("paper") / exact, rim.perimeter("exact") / exact, rim.perimeter("edges") / exact]
            found.append([*lengths, rim.chord / chord, rim.area / (np.pi * radius**2)])
        rows.append([f"{radius:g}", *(f"{v:.4f}" for v in np.mean(found, axis=0))])
    table(["R/a0", "P, 1.1222", "P, 1.1107", "P, edges", "chord", "area"], rows)


# --- areas of a hard contact ---------------------------------------------------------------------------------


def hertz() -> None:
    """Areas of a Hertz contact of a hard wall, by definition, over the exact one; mean and scatter over positions."""
    rng, rows = np.random.default_rng(1), []
    for a in (2.0, 4.0, 8.0, 16.0):
        grid, radius, found = Grid.square(int(12 * a)), 12.5 * a, []
        stiffness_q, (x, y) = HalfSpace("free").stiffness(grid), grid.positions
        for _ in range(16):
            middle = grid.lengths[0] / 2 + rng.random(2)
            heights = ((x - middle[0]) ** 2 + (y - middle[1]) ** 2) / (2 * radius)
            pressure = 4 * a**3 / (3 * radius) / grid.area
            state = Solver(grid, stiffness_q).constrain(heights, None, Settings(1e-7), pressure=pressure)
            got, exact = areas(grid, HardWall(), state.gap), np.pi * a**2 / grid.area
            found.append([got.repulsive, got.corrected, got.interior, got.dilated, got.uncertainty])
        mean, scatter = np.mean(found, axis=0) / exact, np.std(found, axis=0) / exact
        rows.append(
            [f"{a:g}", *(f"{m:.3f} ± {s:.3f}" for m, s in zip(mean[:4], scatter, strict=False)), f"{mean[4]:.3f}"]
        )
    table(["a/a0", "cells", "corrected", "interior", "dilated", "stated uncertainty"], rows)


PARTS: dict[str, Callable[[], None]] = {
    "discs": discs,
    "hertz": hertz,
    "perimeter": perimeter,
    "diameter": diameter,
    "gap": gap,
    "pull-off": pull_off,
}


def main() -> None:
    """Run the parts named, or all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("parts", nargs="*", choices=[*PARTS, []], metavar="PART", help=", ".join(PARTS))
    for part in parser.parse_args().parts or PARTS:
        PARTS[part]()


if __name__ == "__main__":
    main()
