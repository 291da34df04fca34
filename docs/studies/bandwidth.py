"""Eqs. (1), (3) and (4) of the paper against the bandwidth λ_L/λ_s, from the files of a sweep over it.

``python -m docs.studies.bandwidth results/bandwidth`` prints the table of docs/studies/bandwidth.md, and what became of
the expectations that were written there before the run; without a folder, from the points stored in docs/measured.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from pandas import DataFrame, concat, read_csv

from continuum.paper.points import sweep_points
from continuum.show import plot
from continuum.store.sweeps.collect import collect
from docs.studies.tables import points_of

QUANTITIES = {
    "κ_rep": "kappa_rep",
    "A_rep/A_att over Eq. (4)": "ratio",
    "1/κ_att over Eqs. (3), (4)": "attraction",
    "d_rep h''/(4h')": "diameter_ratio",
    "chord h''/(4h')": "chords",
}


def states(folder: Path, chosen: str = "reference and area_rep < 0.015") -> DataFrame:
    """The states at 1 % area of all contacts of a sweep, or others that are chosen, a row each."""
    return compared(sweep_points(collect(folder)).query(chosen))


def stored(
    names: Sequence[str] = ("bandwidth", "bandwidth-256"), chosen: str = "reference and area_rep < 0.015"
) -> DataFrame:
    """The same of the sweeps whose points lie in docs/measured."""
    rows = concat([read_csv(points_of(name)) for name in names], ignore_index=True)
    return compared(rows.query(chosen))


def compared(points: DataFrame) -> DataFrame:
    """Points with what the paper says of each beside them."""
    return points.assign(
        width=points.lambda_L / points.lambda_s,
        ratio=points.area_rep / points.area_att / points.expected_ratio,
        attraction=points.expected_kappa_att / points.kappa_att,
        chords=points.chord * points.diameter_ratio / points.diameter,
        wall=[f"{law}, l_a = {length:g}" if law != "hard" else "hard"
              for law, length in zip(points.law, points.length, strict=True)],
    )  # fmt: skip


def means(rows: DataFrame) -> DataFrame:
    """Means over surfaces and their standard errors, by wall, λ_s and bandwidth."""
    groups = rows.groupby(["wall", "lambda_s", "width"])
    found = {"surfaces": groups.size()}
    for column in QUANTITIES.values():
        with np.errstate(invalid="ignore"):
            found[column] = groups[column].mean()
            found[f"{column}_error"] = groups[column].std(ddof=1) / np.sqrt(groups.size())
    return DataFrame(found).reset_index()


def table(found: DataFrame) -> str:
    lines = [f"| wall | λ_s | λ_L/λ_s | surfaces | {' | '.join(QUANTITIES)} |", "|---" * (4 + len(QUANTITIES)) + "|"]
    for row in found.itertuples():
        cells = [
            "-" if not np.isfinite(getattr(row, column)) else
            f"{getattr(row, column):.3g} ± {_error(getattr(row, f'{column}_error'))}"
            for column in QUANTITIES.values()
        ]  # fmt: skip
        head = f"| {row.wall} | {row.lambda_s:g} | {row.width:g} | {row.surfaces} |"
        lines.append(f"{head} {' | '.join(cells)} |")
    return "\n".join(lines)


def _error(value: float) -> str:
    """A standard error; one surface has none."""
    return f"{value:.2g}" if np.isfinite(value) else "-"


def verdict(kept: list[float]) -> str:
    """From the number of standard errors by which each mean keeps to what was expected; negative where it does not."""
    if not kept:
        return "not tested"
    return "held" if min(kept) >= 0 else "refuted" if min(kept) < -3 else "undecided"


def expectations(found: DataFrame) -> Iterator[tuple[str, str]]:
    """Each expectation of the page, and what became of it; means of fewer than three surfaces do not count."""
    found = found[found.surfaces >= 3]
    hard = found[found.wall == "hard"]
    distance = np.minimum(hard.kappa_rep - 2.1, 2.5 - hard.kappa_rep) / hard.kappa_rep_error
    yield "1. κ_rep of the hard wall is between 2.1 and 2.5", verdict(list(distance))
    soft = found[found.wall.str.contains("0.0005|0.005", regex=True)]
    for number, name, column in ((2, "A_rep/A_att over Eq. (4)", "ratio"), (3, "d_rep over 4h'/h''", "diameter_ratio")):
        rises, crosses = list[float](), list[float]()
        for _, path in soft.groupby(["wall", "lambda_s"]):
            path = path.sort_values("width")
            value, error = path[column].to_numpy(), path[f"{column}_error"].to_numpy()
            for i in range(len(path) - 1):
                if path.width.iloc[i + 1] <= 64:
                    scatter = np.hypot(error[i + 1] / value[i + 1], error[i] / value[i])
                    rises.append(float(np.log(value[i + 1] / value[i] / 1.1) / scatter))
            crosses += [
                float((1 - v) / e if width <= 32 else (v - 1) / e)
                for width, v, e in zip(path.width, value, error, strict=True) if width <= 32 or width >= 128
            ]  # fmt: skip
        yield f"{number}. {name} rises by 10 % or more with each doubling up to 64", verdict(rises)
        yield f"{number}. {name} is below 1 at 32, and above it at 128", verdict(crosses)
    apart = []
    for _, pair in soft[soft.lambda_s.isin([8, 16])].groupby(["wall", "width"]):
        if len(pair) == 2:
            for column in ("ratio", "diameter_ratio"):
                (a, b), errors = pair[column], pair[f"{column}_error"]
                scatter = float(np.hypot(*(errors / pair[column])))
                apart.append((max(np.log(1.1), 3 * scatter) - abs(np.log(a / b))) / scatter)
    yield "4. at one bandwidth λ_s = 8 and 16 agree within 10 %, or three standard errors", verdict(apart)


def found(rows: DataFrame) -> str:
    """Table, what became of each expectation, and limits, of states of which each contact counts once."""
    each = means(rows.drop_duplicates(["wall", "lambda_s", "lambda_L", "seed"]))
    verdicts = "\n".join(f"* {text}: {word}" for text, word in expectations(each))
    return "\n\n".join([table(each), verdicts, "\n".join(f"* {text}" for text in limits(each))])


def limits(found: DataFrame, column: str = "kappa_rep", cut: float = 8.0) -> Iterator[str]:
    """What a mean tends to at infinite bandwidth, by three ways in which the rest may vanish: which is not known."""
    width = found.width
    forms = {"λ_s/λ_L": 1 / width, "(λ_s/λ_L)^(1/2)": width**-0.5, "1/ln(λ_L/λ_s)": 1 / np.log(width)}
    for wall, path in found[(found.lambda_s == cut) & (found.surfaces >= 3)].groupby("wall"):
        value, error = path[column].to_numpy(), path[f"{column}_error"].to_numpy()
        for name, form in forms.items():
            sides = np.stack([np.ones(len(path)), form[path.index]], axis=1) / error[:, None]
            scatter = np.linalg.inv(sides.T @ sides)
            fit = scatter @ sides.T @ (value / error)
            misfit = float(np.sum((sides @ fit - value / error) ** 2))
            yield (
                f"{column}, {wall}, λ_s = {cut:g}: {fit[0]:.3g} ± {np.sqrt(scatter[0, 0]):.2g} at infinite bandwidth "
                f"if the rest is as {name} (χ² {misfit:.2g} of {len(path) - 2})"
            )


def _shown(wall: str) -> str:
    return wall.replace("hard", "hard wall").replace("lennard-jones-spline, l_a", r"$\ell_a/a_0$")


@plot.styled
def draw(found: DataFrame) -> Figure:
    """κ_rep, A_rep/A_att and d_rep over what the paper says of them, against the bandwidth."""
    figure, axes = plot.new_axes(plot.PAGE, 2.7, 1, 3)
    drawn = found[found.surfaces >= 3]
    panels = (("kappa_rep", r"$\kappa_\mathrm{rep}$", 2.0),
              ("ratio", r"$A_\mathrm{rep}/A_\mathrm{att}$ over Eq. (4)", 1.0),
              ("diameter_ratio", r"$d_\mathrm{rep}$ over $4h'_\mathrm{rms}/h''_\mathrm{rms}$", 1.0))  # fmt: skip
    walls = sorted(set(drawn.wall))
    for axis, (column, label, paper) in zip(axes, panels, strict=True):
        axis.axhline(paper, color="0.6", linewidth=0.8, label="paper")
        for (wall, cut), path in drawn.groupby(["wall", "lambda_s"]):
            if not np.isfinite(path[column]).all() or len(path) < 2:
                continue
            colour = plot.SERIES[walls.index(wall)]
            style = {8: "o-", 16: "s--"}.get(int(cut), "^:")
            axis.errorbar(path.width, path[column], path[f"{column}_error"], fmt=style,
                          color=colour, markerfacecolor=colour if cut == 8 else "white", capsize=2,
                          label=rf"{_shown(wall)}, $\lambda_s/a_0$ = {cut:g}")  # fmt: skip
        axis.set(xscale="log", xlabel=r"$\lambda_L/\lambda_s$", ylabel=label)
        axis.set_xticks([16, 32, 64, 128, 256], ["16", "32", "64", "128", "256"])
        axis.minorticks_off()
    plot.letter_panels(axes)
    plot.legend_below(figure, plot.labelled(axes[2]))
    return figure


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", type=Path, nargs="*", help="of the sweep, whole or reduced; none: docs/measured")
    parser.add_argument("--figure", type=Path, help="where to draw it, without suffix")
    given = parser.parse_args()
    rows = concat([states(folder) for folder in given.folders]) if given.folders else stored()
    if given.figure:
        plot.save_figure(draw(means(rows)), given.figure, own=True)
    sys.stdout.write(f"{found(rows)}\n")


if __name__ == "__main__":
    main()
