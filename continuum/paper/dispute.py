"""Which theory is right?  Figures and tables of the work of adhesion at the turn against λ_s, beside every camp."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from continuum.files import output
from continuum.model.fourier import Real
from continuum.paper.crossover import Turn, exponent, load_turns, pull_off_turns
from continuum.paper.figures import Drawing, save_drawing
from continuum.paper.points import ENOUGH, FigureError, plain_ticks
from continuum.runs.collect import PointTable
from continuum.show import plot
from continuum.show.sheet import Sheet
from continuum.sticky import criteria
from continuum.sticky.criteria import Estimate, RoughContact
from continuum.theory import dispute, paper


@dataclass(frozen=True)
class Theory:
    """What one camp says about the turn."""

    name: str
    criterion: Callable[[RoughContact], Estimate]
    limit: Callable[[float], float]
    """Exponent of λ_s for λ_L/λ_s to infinity, from H."""
    colour: str

    def work(self, turn: Turn) -> float:
        """Work of adhesion over the one at which the surface turns, by this theory; above 1 where it asks for less."""
        margin = self.criterion(turn.contact).margin
        return float("nan") if margin is None else margin


THEORIES = (
    Theory("Pastewka-Robbins", criteria.pastewka_robbins, dispute.pastewka_robbins_exponent, "#d55e00"),
    Theory("half conformal energy", criteria.half_conformal_energy, dispute.conformal_exponent, "#0072b2"),
    Theory("Fuller-Tabor", criteria.fuller_tabor, dispute.fuller_tabor_exponent, "#009e73"),
    Theory("bearing area (BAM)", criteria.bearing_area, dispute.long_wave_exponent, "#cc79a7"),
)
_MARKS = {"spline": "o", "exponential": "s"}
_Cell = str | float | int
_Group = dict[tuple[str, ...], list[Turn]]


def _hurst(turn: Turn) -> float:
    return float(turn.settings["surface.hurst"])


def _cut(turn: Turn) -> float:
    return float(turn.settings["surface.lambda_s"])


def _reach(turn: Turn) -> float:
    return round(turn.reach, 2)


def _peak(turn: Turn) -> str:
    """Mean gap at which the approach ended, over h_rms; empty where paths are not told apart by it."""
    targets = turn.settings.get("loading.targets")
    return f"{targets[-1] / turn.contact.rms_height:.3g}" if isinstance(targets, (list, tuple)) else ""


def _grouped(turns: Sequence[Turn], *by: Callable[[Turn], object]) -> _Group:
    found: _Group = {}
    for turn in sorted(turns, key=_cut):
        found.setdefault(tuple(str(each(turn)) for each in by), []).append(turn)
    return found


def _series(turns: Sequence[Turn]) -> list[list[Turn]]:
    """One for each surface, of three λ_s at least."""
    return [each for each in _grouped(turns, lambda t: t.settings["surface.seed"]).values() if len(each) > 2]


def _mean(values: Sequence[float]) -> str:
    """Mean and standard error over surfaces."""
    found = np.array(values)
    error = f" ± {found.std(ddof=1) / np.sqrt(found.size):.2f}" if found.size > 1 else ""
    return f"{found.mean():+.2f}{error}"


def _between(values: Sequence[float], digits: str = ".2g") -> str:
    low, high = min(values), max(values)
    return f"{low:{digits}} - {high:{digits}}" if f"{low:{digits}}" != f"{high:{digits}}" else f"{low:{digits}}"


def _gap_ratio(turn: Turn) -> float:
    """Δr/g0: the rim is thin below 0.1 (Monti, Sanner and Pastewka 2021)."""
    return criteria.range_over_gap(turn.contact).value


def dispute_sheets(turns: Sequence[Turn]) -> tuple[Sheet, Sheet]:
    """Exponents, measured and of each theory on the same surfaces; and the measured work over each theory's."""
    by = (_reach, _hurst, attrgetter("shape"), _peak)
    exponents, works = list[list[_Cell]](), list[list[_Cell]]()
    for (reach, hurst, shape, peak), group in sorted(_grouped(turns, *by).items()):
        series = _series(group)
        if not series:
            continue
        peaks = [peak] if peak else []
        used = [turn for each in series for turn in each]
        name = (reach, *peaks, shape, hurst)
        row: list[_Cell] = [*name, len(series), _between([_cut(t) for t in used], "g")]
        row += [_between([_gap_ratio(t) for t in used]),
                _between([criteria.generalised_tabor(t.contact).value for t in used])]  # fmt: skip
        row.append(f"**{_mean([_fit(each) for each in series])}**")
        for theory in THEORIES:
            said = [_fit(each, theory) for each in series]
            row.append(f"{np.mean(said):+.2f} ({theory.limit(float(hurst)):+.2f})")
        exponents.append(row)
        ratios = [np.log([theory.work(turn) for turn in used]) for theory in THEORIES]
        works.append([*name, len(used), *(f"{np.exp(r.mean()):.2g} (x{np.exp(r.std()):.2f})" for r in ratios)])
    if not exponents:
        msg = "no surface of this sweep has its turn at three λ_s: too few systems are done"
        raise FigureError(msg)
    peaked = any(map(_peak, turns))
    head = ["Δr/h_rms", *(["turned back at (h_rms)"] if peaked else []), "law", "H"]
    first = Sheet.of(
        "Exponents of λ_s",
        [*head, "surfaces", "λ_s (a0)", "Δr/g0", "μ_T", "measured", *(f"{t.name} (limit)" for t in THEORIES)],
        exponents,
    )
    second = Sheet.of("Work at the turn over that of each theory", [*head, "turns", *(t.name for t in THEORIES)], works)
    return first, second


def _fit(series: Sequence[Turn], theory: Theory | None = None) -> float:
    """Exponent of the measured works, or of a theory's on the same surfaces."""
    works = np.array([turn.work / (theory.work(turn) if theory else 1.0) for turn in series])
    return exponent(np.array([_cut(turn) for turn in series]), works)


@plot.styled
def draw_turns(turns: Sequence[Turn], title: str) -> Drawing:
    """Work at the turn against λ_s: means over surfaces with their scatter, and a line for each theory."""
    rows = sorted({(_reach(turn), _peak(turn)) for turn in turns})
    columns = sorted({_hurst(turn) for turn in turns})
    figure = plot.new_figure(2.4 * len(columns) + 1.2, 2.2 * len(rows) + 0.9)
    axes = figure.subplots(len(rows), len(columns), sharex=True, sharey="row", squeeze=False)
    body: list[tuple[_Cell, ...]] = []
    for i, (reach, peak) in enumerate(rows):
        for axis, hurst in zip(axes[i], columns, strict=True):
            mine = [t for t in turns if _hurst(t) == hurst and (_reach(t), _peak(t)) == (reach, peak)]
            for shape in sorted({turn.shape for turn in mine}):
                body += _draw_panel(axis, [turn for turn in mine if turn.shape == shape], shape)
            turned = f", back at {peak} $h_{{rms}}$" if peak else ""
            axis.set_title(rf"$H = {hurst:g}$, $\Delta r = {reach:g}\,h_{{rms}}${turned}", fontsize=8)
            axis.set(xscale="log", yscale="log")
            axis.minorticks_off()
        plain_ticks(axes[i][0], "y")
        axes[i][0].set_ylabel(r"$\ell_a\lambda_L/h_{rms}^2$ at the turn")
    cuts = sorted({_cut(turn) for turn in turns})
    few = max(_cut(turn) * float(np.sqrt(turn.contacts / ENOUGH)) for turn in turns)
    shaded = []
    for axis in axes.flat if few < cuts[-1] else ():
        left, right = axis.get_xlim()
        shaded.append(axis.axvspan(few, right, color="0.93", zorder=-1))
        axis.set_xlim(left, right)
    for axis in axes[-1]:
        axis.set_xticks(cuts, [f"{cut:g}" for cut in cuts])
        axis.set_xlabel(r"$\lambda_s$ ($a_0$)")
    for theory in THEORIES:
        axes[0][0].plot([], [], color=theory.colour, label=theory.name)
    for shape in sorted({turn.shape for turn in turns}):
        axes[0][0].plot([], [], _MARKS[shape], color="0.2", markerfacecolor="0.2" if shape == "spline" else "none",
                        label=f"computed, {shape} law")  # fmt: skip
    for span in shaded[:1]:
        span.set_label(rf"fewer than {ENOUGH:g} $\lambda_s^2$ in 1 % of the map")
    figure.legend(loc="outside lower center", ncols=len(columns))
    head = ("range/h_rms", "law", "H", "lambda_s (a0)", "surfaces", "l_a lambda_L/h_rms^2", "scatter (factor)",
            *(theory.name for theory in THEORIES))  # fmt: skip
    caption = f"{title}: means over surfaces, bars their scatter; lines are the theories on the same surfaces."
    return Drawing(figure, Sheet.of(title, head, body), caption)


def _draw_panel(axis: Axes, turns: Sequence[Turn], shape: str) -> list[tuple[_Cell, ...]]:
    """One law in one panel; returns its numbers."""
    by_cut = [(float(cut), group) for (cut,), group in _grouped(turns, _cut).items()]
    logs: list[Real] = [np.log([turn.work for turn in group]) for _, group in by_cut]
    cuts, mean = np.array([cut for cut, _ in by_cut]), np.exp([each.mean() for each in logs])
    scatter = np.array([np.exp(each.std(ddof=1)) if each.size > 1 else 1.0 for each in logs])
    axis.errorbar(
        cuts, mean, yerr=(mean - mean / scatter, mean * scatter - mean), fmt=_MARKS[shape], color="0.2", capsize=2,
        markerfacecolor="0.2" if shape == "spline" else "none", elinewidth=0.7,
    )  # fmt: skip
    lines = [
        np.array([np.exp(np.mean(np.log([t.work / theory.work(t) for t in group]))) for _, group in by_cut])
        for theory in THEORIES
    ]
    for theory, line in zip(THEORIES, lines, strict=True):
        axis.plot(cuts, line, "-" if shape == "spline" else "--", color=theory.colour, linewidth=1)
    return [
        (_reach(group[0]), shape, _hurst(group[0]), cut, len(group), mean[i], scatter[i], *(line[i] for line in lines))
        for i, (cut, group) in enumerate(by_cut)
    ]


def write_dispute(sweeps: Sequence[tuple[str, PointTable]], path: Path) -> list[Path]:
    """Tables and figures of one or both observables, from their sweeps; returns the files written.

    Parameters
    ----------
    sweeps : name of the folder and table; paths with a way back are judged by their pull-off, others by their load.
    path : of the page, in Markdown; figures lie beside it.

    Raises
    ------
    FigureError
        If a sweep has too few surfaces that turn.
    """
    parts, written = ["# Which theory is right: the numbers\n"], list[Path]()
    for name, table in sweeps:
        back = bool((table["retracting"] == 1).any())
        title = "Pull-off equal to the load before" if back else "Attraction equal to repulsion at 1 % area"
        turns = pull_off_turns(table) if back else load_turns(table)
        sheets = [*dispute_sheets(turns), *many_contacts(turns)]
        drawing = draw_turns(turns, title)
        stem = path.with_name(f"dispute-{'pull-off' if back else 'load'}")
        stem = stem.with_name(f"{stem.name}-{name}") if stem.with_suffix(".png") in written else stem
        written += save_drawing(drawing, stem)
        made = "; ".join(f"{text} ({count} systems)" for text, count in table.provenance.items())
        parts += [f"## {title}\n", f"Sweep `{name}`: {len(table.keys)} of {len(table.listed.systems)} systems done, "
                  f"{len(turns)} turns. Computed with {made}.\n", f"![{drawing.caption}]({stem.name}.png)\n",
                  f"{drawing.caption}\n"]  # fmt: skip
        parts += [f"**{sheet.title}**\n\n{sheet.markdown()}\n" for sheet in sheets]
        parts += [_losses(turns)] if back else [_diameters(table)]
    return [output.save(path, "\n".join(parts).rstrip() + "\n"), *written]


def many_contacts(turns: Sequence[Turn]) -> list[Sheet]:
    """The exponents of those λ_s only of which there are many in 1 % of the map."""
    many = [turn for turn in turns if turn.contacts >= ENOUGH]
    if len(many) in (0, len(turns)):
        return []
    try:
        first, _ = dispute_sheets(many)
    except FigureError:
        return []
    return [replace(first, title=f"{first.title}, of those only of which {ENOUGH:g} λ_s² or more make 1 % of the map")]


def _losses(turns: Sequence[Turn]) -> str:
    """The work lost in a cycle at the turn."""
    rows: list[list[_Cell]] = [
        [peak, hurst, cut, len(group), f"{np.mean([t.loss for t in group]):.3f}"]
        for (peak, hurst, cut), group in sorted(_grouped(turns, _peak, _hurst, _cut).items(), key=_numbers)
    ]
    head = ("turned back at (h_rms)", "H", "λ_s (a0)", "surfaces", "work lost in the cycle over w")
    return f"**Hysteresis at the turn**\n\n{Sheet.of('loss', head, rows).markdown()}\n"


def _numbers(item: tuple[tuple[str, ...], object]) -> tuple[float, ...]:
    return tuple(float(each or 0) for each in item[0])


def _diameters(table: PointTable) -> str:
    """How often the criterion's d_rep = 4h'/h'' is missed."""
    expected = [paper.contact_diameter(*pair) for pair in zip(table["rms_slope"], table["rms_curvature"], strict=True)]
    ratio = table["diameter"] / np.array(expected)
    ratio = ratio[np.isfinite(ratio) & (ratio > 0)]
    far = float(np.mean((ratio < 0.5) | (ratio > 2)))
    near = float(np.mean(np.abs(ratio - 1) < 0.25))
    return (
        f"d_rep over 4h'/h'' at 1 % area, {ratio.size} points: mean {ratio.mean():.2f}, {near:.0%} within a quarter "
        f"of 1, {far:.1%} off by more than a factor of two.\n"
    )
