"""The paper's figures, one entry each: the points that it needs, how it is drawn, and its caption."""

from collections.abc import Callable, Mapping, Sized
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from pandas import DataFrame

from continuum.paper import fields, relations
from continuum.paper.points import FigureError, SweepData, chosen, figure_table
from continuum.show import plot
from continuum.store import output
from continuum.store.sheet import Sheet

Select = Callable[[SweepData], Sized]


@dataclass(frozen=True, eq=False)
class Drawing:
    """A figure with the numbers that it shows."""

    figure: Figure
    sheet: Sheet
    caption: str

    def shown(self, stem: Path) -> list[str]:
        """The Markdown for the figure and its caption."""
        return [f"![{self.caption}]({stem.name}.png)\n", f"{self.caption}\n"]


@dataclass(frozen=True)
class PaperFigure:
    """Description of how a figure is made."""

    title: str
    """Title of the table of its numbers."""
    select: Select
    """Function that selects what it shows of a sweep."""
    needs: str
    """Message if the sweep has nothing to show."""
    table: Callable[[Any], DataFrame] | Mapping[str, Any]
    """The table of its numbers: a function, or columns for :func:`figure_table`."""
    draw: Callable[[Any], Figure]
    """Function that draws it, from its table alone, or if ``whole`` from all that it shows."""
    caption: str | Callable[[DataFrame], str]
    """Caption and alternative text; a function if it contains numbers."""
    whole: bool = False
    """Whether it shows more than its table holds, such as maps."""
    fields: bool = False
    """Whether it needs stored gaps."""
    general: bool = False
    """Whether every sweep over loads has points for it."""

    @plot.styled
    def make(self, data: SweepData) -> Drawing:
        shown = self.select(data)
        if not len(shown):
            raise FigureError(f"{data.table.listing.name}: {self.needs}")
        numbers = self.numbers(shown)
        figure = self.draw(shown if self.whole else numbers)
        sheet = Sheet.of(self.title, list(numbers), numbers.itertuples(index=False, name=None))
        return Drawing(figure, sheet, self.said(numbers))

    def numbers(self, shown: Any) -> DataFrame:
        """The table of its numbers, of what it shows."""
        return self.table(shown) if callable(self.table) else figure_table(shown, self.table)

    def said(self, numbers: DataFrame) -> str:
        """Caption of the figure."""
        return self.caption if isinstance(self.caption, str) else self.caption(numbers)


def save_drawing(drawing: Drawing, stem: Path, *, page: bool = False) -> list[Path]:
    """Write ``stem.png``, ``stem.pdf`` and ``stem.csv``, perhaps of a page; returns PNG and CSV."""
    picture = plot.save_figure(drawing.figure, stem, page=page)
    return [picture, output.save(stem.with_name(f"{stem.name}.csv"), drawing.sheet.csv())]


def _where(query: str) -> Select:
    return lambda data: chosen(data.points, query)


def _along(key: str, query: str) -> Select:
    """The points of a query, in a sweep with an axis on which they have at least two values."""

    def found(data: SweepData) -> DataFrame:
        points = chosen(data.points, query)
        axis = f"sweep.{key}"
        return points if axis in points and points[axis].nunique() > 1 else points[:0]

    return found


def _of_laws(data: SweepData) -> DataFrame:
    """The adhesive points at which κ is taken, in a sweep over laws or whole walls."""
    points = chosen(data.points, "reference and length > 0")
    return points if {"sweep.wall.law", "sweep.wall"} & set(points) else points[:0]


_ANY = "the sweep has no point that this figure shows: too few systems are done, or it is another sweep"


def _inverse_kappa(title: str, column: str, key: str, label: str, *along: str) -> PaperFigure:
    """1/κ or 1/κ_rep against a key of [surface], and the keys that change along with it."""
    return PaperFigure(
        title,
        _along(f"surface.{key}", "reference"),
        f"this figure needs a sweep over surface.{key}, with points of enough contact at two values at least",
        partial(relations.inverse_kappas, key=key, column=column, along=along),
        partial(relations.draw_inverse_kappas, label=label),
        f"{title}; means over surfaces, bars their standard deviation.",
    )


FIGURES: dict[str, PaperFigure] = {
    "figure1": PaperFigure(
        "Fig. 1", fields.near_target_area, "no system has a converged point to draw", fields.contact_areas,
        fields.draw_contact_maps,
        "Fig. 1: contact at a fixed repulsive area, adhesion growing.", whole=True, fields=True,
    ),
    "figure-s1": PaperFigure(
        "Fig. S-1", fields.near_target_area, "no system has a converged point to draw", fields.cell_counts,
        fields.draw_patch_cells,
        lambda n: "Fig. S-1: cells and perimeter; of {} cells of this map {} are perimeter cells.".format(*n.iloc[0]),
        whole=True, fields=True,
    ),
    "gap-profile": PaperFigure(
        "gap profile", fields.stored_profiles,
        "no system has a contact with its gaps: this figure needs fields = true in [output]", fields.gap_ratios,
        fields.draw_gap_profiles,
        "Mean gap outside the contact at 1 % area, over Eq. (S-1) with the measured d_rep, against x from the edge.",
        whole=True, fields=True,
    ),
    "figure2": PaperFigure(
        "Fig. 2", _where("lambda_s == 32 and hurst == 0.8 and slope == 0.1"), _ANY,
        {"N/(h' E* A0)": "load / rms_slope", "A_rep/A0": "area_rep",
         "way": lambda points: np.where(points.approach, "approach", "retraction")},
        relations.draw_area_against_load, relations.caption_of_area_against_load, general=True,
    ),
    "figure3": PaperFigure(
        "Fig. 3", _where("perimeter > 0 and valid"), _ANY,
        {"A_att w/range (E* A0)": "area_att * expected_pressure_att", "N_att (E* A0)": "load_att",
         "h' A_rep/2 (A0)": "rms_slope * area_rep / 2", "N_rep (E* A0)": "load_rep", "A_rep/A0": "area_rep",
         "P (4h'/h'')/(pi A0)": lambda points: points.perimeter * points.expected_diameter / np.pi / points.area},
        relations.draw_loads,
        "Fig. 3: attractive and repulsive load, and perimeter, against the areas that the paper says they follow.",
        general=True,
    ),
    "figure4": PaperFigure(
        "Fig. 4", _where("reference and length > 0 and area_att > 0"), _ANY, relations.kappas, relations.draw_kappas,
        "Fig. 4: means over surfaces, bars their standard deviation, of the first point with A_rep >= 10 λ_s² from "
        "1 %. Dashed: 1/κ_rep as measured; full: where a search has found the threshold; bands: standard deviations.",
        general=True,
    ),
    "figure-s2": PaperFigure(
        "Fig. S-2", _where("perimeter > 0 and valid and approach"), _ANY,
        {"chord (a0)": "chord", "P d/(pi A_rep)": "disc_ratio"}, relations.draw_perimeters,
        "Fig. S-2: perimeter, chord and area.", general=True,
    ),
    "figure-s3": PaperFigure(
        "Fig. S-3", lambda data: relations.largest_tension(data.points), _ANY,
        {"h_rms/delta_c": "ratio", "N_max/(N P_c)": "tension"}, relations.draw_tensions,
        lambda numbers: "Fig. S-3: largest tension on approach, at the points of each path; "
        f"{np.sum(numbers['N_max/(N P_c)'] > 0)} of {len(numbers)} pull, arrows on the axis never do.", general=True,
    ),
    "finite-size": _inverse_kappa(
        "κ at 1 % area against the period L = 2λ_L", "kappa", "lambda_L", r"$\lambda_L = L/2$ ($a_0$)", "grid.n",
    ),
    "continuum-limit": _inverse_kappa(
        "κ_rep at 1 % area against λ_s/a0", "kappa_rep", "lambda_s", r"$\lambda_s/a_0$", "grid.n", "surface.lambda_L",
    ),
    "lambda-L": _inverse_kappa(
        "κ at 1 % area against λ_L, one period", "kappa", "lambda_L", r"$\lambda_L$ ($a_0$)",
    ),
    "other-potentials": PaperFigure(
        "other potentials", _of_laws, "this figure needs a sweep over wall.law", relations.laws, relations.draw_laws,
        "Other laws of the wall beside the theory for the spline: means over surfaces, bars their standard deviation. "
        "A long range reaches more than the rim of the patches, all that Eq. (4) counts: 9-3 attracts twice as much as "
        "it says, and a spline as wide does, too.",
    ),
    "stiffness": PaperFigure(
        "stiffness", _where("approach and tangent_stiffness.notna()"),
        "this figure needs stored gaps of walls with a law (fields = true in [output]), from which k_N follows",
        {"A_rep/A0": "area_rep", "kappa_rep/kappa": "load / load_rep",
         "k_N h_rms/N_rep": "tangent_stiffness * (rms_height / load_rep)",
         "k_N h_rms/N_rep between points": "stiffness * (rms_height / load_rep)"},
        relations.draw_stiffnesses,
        "Normal stiffness over repulsive load against κ_rep/κ: of each equilibrium, by one linear solve with its "
        "Hessian; crosses: the slope between points, jumps included.",
    ),
    "pull-off": PaperFigure(
        "pull-off", lambda data: relations.whole_cycles(data.points),
        "this figure needs paths with a way back (retract = true) of which every point converged",
        relations.cycles, relations.draw_cycles,
        "Cycles of load, and pull-off against how far the contact was pressed; peak loads and work are in the table.",
        whole=True,
    ),
    "diameter": PaperFigure(
        "diameter", lambda data: relations.long_paths(data.points),
        "this figure needs paths of three areas at least, as those of figure3",
        {"A_rep/A0": "area_rep", "d_rep (a0)": "diameter", "4h'/h'' (a0)": "expected_diameter",
         "ratio": "diameter_ratio"},
        relations.draw_diameters,
        "Mean diameter of contact patches against the area.", general=True,
    ),
}  # fmt: skip
"""Every figure that can be made of one sweep, by its name in ``continuum plot``."""
