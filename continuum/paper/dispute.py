"""The work of adhesion at which a surface becomes sticky, compared with every theory.

The systems of one surface and one law differ in the work of adhesion w.  The crossover is where the quantity that
distinguishes sticky from not passes 1: attraction over repulsion at 1 % area, or pull-off over the load before it.
Between two works its logarithm is interpolated linearly in that of w.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from pandas import DataFrame, Series

from continuum.maps.verdict.criteria import AREA, CRITERIA, Criterion, RoughContact
from continuum.measure.contact import adhesion
from continuum.model.grid import Grid
from continuum.model.surfaces import SelfAffineSurface
from continuum.paper.figures import Drawing, save_drawing
from continuum.paper.points import ENOUGH, FigureError, alike, curve_of, sweep_points
from continuum.show import plot
from continuum.store import output
from continuum.store.sheet import Sheet
from continuum.store.sweeps.collect import PointTable
from continuum.theory import rough

NEAR = 1.1
"""Ratio within which the largest or smallest work is taken as the crossover: attraction is nearly proportional to w,
so that the crossover is then known to a few per cent."""
_WIDE = 3
"""Largest number of panels in a row for which titles fit into one line."""
_MARKS = {"spline": "o", "exponential": "s"}


def crossovers(table: PointTable) -> DataFrame:
    """The crossover of each surface and law of a sweep, one per row, by :func:`attraction_ratio`.

    For paths with retraction it is that of :func:`pull_off_ratio`.  Columns are

    * ``hurst``, ``lambda_s``, ``lambda_L``, ``seed``: of the surface; ``law``: shape of the attraction;
    * ``range``: effective range of the attraction over h_rms, to two digits;
    * ``peak``: mean gap over h_rms at which the approach ended, as text; empty where paths are not told apart by it;
    * ``contact``: the :class:`RoughContact` at the crossover; ``work``: l_a λ_L/h_rms² there, the pure number of the
      bearing-area model; ``loss``: work lost in the cycle over w, there;
    * ``squares``: squares of λ_s in 1 % of the map, of which the paper shows no surface with fewer than ten.
    """
    points = sweep_points(table)
    ratio = attraction_ratio if points.approach.all() else pull_off_ratio
    points["series"] = alike(points, "wall.adhesion_length")
    energies, trials = conformal_energies(table), []
    for system, path in points.sort_values("step").groupby("system"):
        value, loss = ratio(path)
        if value > 0:
            trial = _trial(table, table.keys[system], path.iloc[0], energies)
            trials.append({**trial, "ratio": value, "loss": loss / trial["work"]})
    if not trials:
        return DataFrame()
    found = DataFrame(trials).sort_values("work", kind="stable")
    thresholds = (_crossover(each) for _, each in found.groupby("series", sort=False))
    return DataFrame([threshold for threshold in thresholds if threshold is not None])


def _trial(table: PointTable, key: str, first: Series, energies: Mapping[str, float]) -> dict[str, Any]:
    """Surface, law and contact of a system, from the first of its points."""
    height, shape = first.rms_height, table.setting(key, "wall.shape")
    contact = RoughContact(
        height, first.rms_slope, first.rms_curvature, first.work_of_adhesion, first.effective_range,
        conformal_energy=energies[key], roll_off=float(first.lambda_L),
    )  # fmt: skip
    targets = table.setting(key, "loading.targets") if "sweep.loading.targets" in first else None
    return {
        **first[["series", "hurst", "lambda_s", "lambda_L", "seed"]],
        "law": shape if isinstance(shape, str) else "spline",
        "range": round(first.effective_range / height, 2),
        "peak": f"{targets[-1] / height:.3g}" if isinstance(targets, (list, tuple)) else "",
        "squares": float(AREA * np.prod(table.setting(key, "grid.period")) / first.lambda_s**2),
        "contact": contact,
        "work": first.work_of_adhesion,
    }


def attraction_ratio(path: DataFrame) -> tuple[float, float]:
    """The paper's observable: attraction over repulsion at the first point of the approach; no work is lost."""
    first = path.iloc[0]
    return (first.load_att / first.load_rep if first.load_rep > 0 else np.nan), np.nan


def pull_off_ratio(path: DataFrame) -> tuple[float, float]:
    """The critics' observable: pull-off over the peak load of the cycle, and the work lost in it."""
    if path.approach.all() or not np.array_equal(path.step, np.arange(len(path))):
        return np.nan, np.nan  # a point is missing
    found = adhesion(curve_of(path))
    if not found.separated:
        return np.nan, np.nan
    # A contact that never pushes is sticky by any measure.
    return (found.pull_off / found.peak_load if found.peak_load > 0 else np.inf), found.loss


def _crossover(trials: DataFrame) -> dict[str, Any] | None:
    """Between the last work that is not sticky and the next; None if there is no such pair."""
    work, over, loss = np.log(trials.work.to_numpy()), np.log(trials.ratio.clip(upper=1e6).to_numpy()), trials.loss
    sticky = over > 0
    if sticky.all() or not sticky.any():
        edge = 0 if sticky.all() else -1
        if abs(over[edge]) > np.log(NEAR):
            return None
        at, lost = work[edge] - over[edge], loss.iloc[edge]
    else:
        above = int(np.argmax(sticky))
        if above == 0:  # not monotonic in w: a surface that sticks at the smallest work and not at a larger one
            return None
        share = -over[above - 1] / (over[above] - over[above - 1])
        at = work[above - 1] + share * (work[above] - work[above - 1])
        lost = loss.iloc[above - 1] + share * (loss.iloc[above] - loss.iloc[above - 1])
    first = trials.iloc[0]
    contact = replace(first.contact, work_of_adhesion=float(np.exp(at)))
    assert contact.roll_off is not None
    number = contact.adhesion_length * contact.roll_off / contact.rms_height**2
    return {**first, "contact": contact, "work": number, "loss": float(lost)}


def conformal_energies(table: PointTable) -> dict[str, float]:
    """Elastic energy per area of full contact of each system, in E* a0, with surfaces synthesised again."""

    @cache
    def energy(grid: Grid, surface: SelfAffineSurface) -> float:
        power = np.abs(grid.forward(surface.build(grid))) ** 2 * grid.mode_weights
        return rough.conformal_energy(grid.wavenumber, power)

    surfaces = {key: SelfAffineSurface.model_validate(table.given(key, "surface")) for key in table.keys}
    return {key: energy(table.grid(key), surface) for key, surface in surfaces.items()}


def exponent(cuts: Any, works: Any) -> float:
    """The power x of w ~ λ_s^x, by least squares of the logarithms; NaN for fewer than three."""
    return float(np.polyfit(np.log(cuts), np.log(works), 1)[0]) if len(cuts) > 2 else float("nan")


@dataclass(frozen=True)
class Theory:
    """One theory of the crossover."""

    name: str
    criterion: Criterion
    limit: Callable[[float], float]
    """Exponent of λ_s for λ_L/λ_s to infinity, from H."""
    colour: str

    def margins(self, thresholds: DataFrame) -> Series:
        """Measured work of adhesion at the crossover over that of this theory."""
        return thresholds.contact.map(lambda contact: self.criterion(contact).margin).astype(float)


THEORIES = (
    Theory("Pastewka-Robbins", CRITERIA["pastewka-robbins"], rough.pastewka_robbins_exponent, "#d55e00"),
    Theory("half conformal energy", CRITERIA["half-conformal-energy"], rough.conformal_exponent, "#0072b2"),
    Theory("Fuller-Tabor", CRITERIA["fuller-tabor"], rough.fuller_tabor_exponent, "#009e73"),
    Theory("bearing area (BAM)", CRITERIA["bearing-area"], rough.long_wave_exponent, "#cc79a7"),
)


def _mean(values: Sequence[float]) -> str:
    """Mean over surfaces and its 95 % interval, by Student's t."""
    found = np.array(values)
    half = scipy.stats.t.ppf(0.975, found.size - 1) * found.std(ddof=1) / np.sqrt(found.size) if found.size > 1 else 0.0
    error = f" ± {half:.2f}" if found.size > 1 else ""
    return f"{found.mean():+.2f}{error}"


def _between(values: Iterable[float], digits: str = ".2g") -> str:
    ends = {f"{value:{digits}}": None for value in (min(values), max(values))}
    return " - ".join(ends)


def dispute_sheets(thresholds: DataFrame) -> tuple[Sheet, Sheet]:
    """Measured exponents and those of each theory on the same surfaces, and the ratios of the works."""
    exponents, works = [], []
    peaked = len(thresholds) > 0 and thresholds.peak.any()
    for (reach, hurst, law, peak), group in (
        thresholds.groupby(["range", "hurst", "law", "peak"]) if len(thresholds) else ()
    ):
        series = [each for _, each in group.sort_values("lambda_s", kind="stable").groupby("seed") if len(each) > 2]
        if not series:
            continue
        used = group[group.seed.isin({each.seed.iloc[0] for each in series})]
        name = (str(reach), *([peak] if peaked else []), law, str(hurst))
        fits = [exponent(each.lambda_s, each.work) for each in series]
        said = {
            theory: np.mean([exponent(each.lambda_s, each.work / theory.margins(each)) for each in series])
            for theory in THEORIES
        }
        exponents.append((
            *name, len(series), _between(used.lambda_s, "g"),
            _between([CRITERIA["range-over-gap"](contact).value for contact in used.contact]),
            _between([CRITERIA["generalised-tabor"](contact).value for contact in used.contact]),
            f"{sum(CRITERIA['pastewka-robbins'](contact).valid for contact in used.contact)} of {len(used)}",
            f"**{_mean(fits)}**",
            *(f"{mean:+.2f} ({theory.limit(float(hurst)):+.2f})" for theory, mean in said.items()),
        ))  # fmt: skip
        ratios = [np.log(theory.margins(used).to_numpy()) for theory in THEORIES]
        works.append((*name, len(used), *(f"{np.exp(r.mean()):.2g} (x{np.exp(r.std()):.2f})" for r in ratios)))
    if not exponents:
        raise FigureError("no surface of this sweep has its threshold at three λ_s: too few systems are done")
    names = [theory.name for theory in THEORIES]
    head = ["Δr/h_rms", *(["reversed at (h_rms)"] if peaked else []), "law", "H"]
    measured = ["surfaces", "λ_s (a0)", "Δr/g0", "μ_T", "thresholds in the range of Eq. (6)", "measured, 95 %"]
    columns = [*head, *measured, *(f"{name} (limit)" for name in names)]
    return (
        Sheet.of("Exponents of λ_s", columns, exponents),
        Sheet.of("Work at the threshold over that of each theory", [*head, "thresholds", *names], works),
    )


def crossover_table(thresholds: DataFrame) -> DataFrame:
    """The numbers of the figure: of each range, law, H and λ_s the mean over surfaces, its scatter, and the theories.

    ``enough to lambda_s (a0)`` is the longest wave of which 1 % of the map has ten squares.
    """
    rows = []
    for (reach, peak, hurst, law, cut), group in thresholds.groupby(["range", "peak", "hurst", "law", "lambda_s"]):
        logs = np.log(group.work.to_numpy())
        rows.append((
            reach, peak, law, hurst, float(cut), (group.lambda_s * np.sqrt(group.squares / ENOUGH)).max(), len(group),
            np.exp(logs.mean()), np.exp(logs.std(ddof=1)) if len(group) > 1 else 1.0,
            *(np.exp((logs - np.log(theory.margins(group).to_numpy())).mean()) for theory in THEORIES),
        ))  # fmt: skip
    head = ("range/h_rms", "reversed at (h_rms)", "law", "H", "lambda_s (a0)", "enough to lambda_s (a0)", "surfaces",
            "l_a lambda_L/h_rms^2", "scatter (factor)", *(theory.name for theory in THEORIES))  # fmt: skip
    return DataFrame(rows, columns=head)


def draw_crossovers(thresholds: DataFrame, title: str) -> Drawing:
    """The work at the crossover against λ_s, with the numbers drawn."""
    numbers = crossover_table(thresholds)
    caption = f"{title}: means over surfaces, bars their scatter; lines are the theories on the same surfaces."
    sheet = Sheet.of(title, list(numbers), numbers.itertuples(index=False, name=None))
    return Drawing(draw_crossover_table(numbers), sheet, caption)


@plot.styled
def draw_crossover_table(numbers: DataFrame) -> Figure:
    """Draw the work at the crossover against λ_s: means over surfaces with scatter, and a line for each theory."""
    rows = list(numbers.groupby(["range/h_rms", "reversed at (h_rms)"], dropna=False))
    columns = sorted(set(numbers.H))
    width, height = (plot.PAGE, 0.9) if len(columns) > 1 else (plot.COLUMN, 1.7)
    size = width, 1.75 * len(rows) + height, len(rows), len(columns)
    figure, axes = plot.new_axes(*size, sharex=True, sharey="row", squeeze=False)
    titles = []
    for line, ((reach, peak), row) in zip(axes, rows, strict=True):
        for axis, hurst in zip(line, columns, strict=True):
            for law, same in row[row["H"] == hurst].groupby("law"):
                _draw_panel(axis, same, law)
            # Of a table that was read it is a number.
            reversed_at = rf"{chr(10)}back at {float(peak):g} $h_\mathrm{{rms}}$" if peak and peak == peak else ""
            gap = ", " if len(columns) <= _WIDE else "\n"
            titles.append(rf"$H = {hurst:g}${gap}$\Delta r = {reach:g}\,h_\mathrm{{rms}}${reversed_at}")
            axis.set(xscale="log", yscale="log")
        line[0].set_ylabel(r"$\ell_a\lambda_L/h_\mathrm{rms}^2$ at the threshold")
    plot.log_ticks(*axes.flat)
    _finish(axes, numbers)
    plot.letter_panels(axes.flat, titles)
    plot.legend_below(figure, plot.labelled(*axes.flat))
    return figure


def _finish(axes: np.ndarray, numbers: DataFrame) -> None:
    """Ticks, the legend's entries, and a shade where there are few contacts."""
    cuts = sorted(set(numbers["lambda_s (a0)"]))
    few = numbers["enough to lambda_s (a0)"].max()
    shaded = []
    for axis in axes.flat if few < cuts[-1] else ():
        left, right = axis.get_xlim()
        shaded.append(axis.axvspan(few, right, color="0.93", zorder=-1))
        axis.set_xlim(left, right)
    for axis in axes[-1]:
        axis.set_xticks(cuts, [f"{cut:g}" for cut in cuts])
        axis.set_xticks([], minor=True)
        axis.set_xlabel(r"$\lambda_s$ ($a_0$)")
    for theory in THEORIES:
        axes[0][0].plot([], [], color=theory.colour, label=theory.name)
    for law in sorted(set(numbers.law)):
        axes[0][0].plot([], [], _MARKS[law], color="0.2", markerfacecolor="0.2" if law == "spline" else "none",
                        label=f"computed, {law} law")  # fmt: skip
    for span in shaded[:1]:
        span.set_label(rf"fewer than {ENOUGH:g} $\lambda_s^2$ in 1 % of the map")


def _draw_panel(axis: Axes, numbers: DataFrame, law: str) -> None:
    """One law in one panel."""
    cuts, mean, scatter = (
        numbers[name].to_numpy() for name in ("lambda_s (a0)", "l_a lambda_L/h_rms^2", "scatter (factor)")
    )
    axis.errorbar(
        cuts, mean, yerr=(mean - mean / scatter, mean * scatter - mean), fmt=_MARKS[law], color="0.2", capsize=2,
        markerfacecolor="0.2" if law == "spline" else "none", elinewidth=0.7, markersize=3.5,
    )  # fmt: skip
    for theory in THEORIES:
        axis.plot(cuts, numbers[theory.name], "-" if law == "spline" else "--", color=theory.colour, linewidth=1)


def write_dispute(sweeps: Sequence[tuple[str, PointTable]], path: Path) -> list[Path]:
    """Tables and figures of one or both observables, from their sweeps; returns the files written.

    A sweep is the name of its folder and its table; paths with a way back are judged by their pull-off, others by their
    load.  The path is that of the page, in Markdown; figures lie beside it.
    """
    parts, tables, written = ["# Which theory is right: the numbers\n"], ["## Tables\n"], list[Path]()
    for name, table in sweeps:
        back = bool((table["retracting"] == 1).any())
        title = "Pull-off equal to the load before" if back else "Attraction equal to repulsion at 1 % area"
        thresholds = crossovers(table)
        sheets = [*dispute_sheets(thresholds), *many_contacts(thresholds)]
        drawing = draw_crossovers(thresholds, title)
        stem = path.with_name(f"dispute-{'pull-off' if back else 'load'}")
        stem = stem.with_name(f"{stem.name}-{name}") if stem.with_suffix(".png") in written else stem
        written += save_drawing(drawing, stem)
        parts += [f"## {title}: `{name}`\n", *drawing.shown(stem)]
        parts += [] if back else [_diameters(table)]
        parts += [f"{len(table.keys)} of {len(table.listing.systems)} systems done, {len(thresholds)} "
                  f"thresholds. Computed with {table.made}.\n"]  # fmt: skip
        tables += [f"### {title}: tables of `{name}`\n"]
        tables += [f"**{sheet.title}**\n\n{sheet.markdown()}\n" for sheet in sheets]
        tables += [_losses(thresholds)] if back else []
    return [output.save(path, "\n".join([*parts, *tables]).rstrip() + "\n"), *written]


def many_contacts(thresholds: DataFrame) -> list[Sheet]:
    """Exponents of λ_s of which 1 % of the map has enough squares."""
    many = thresholds[thresholds.squares >= ENOUGH]
    if len(many) in (0, len(thresholds)):
        return []
    try:
        first, _ = dispute_sheets(many)
    except FigureError:
        return []
    return [replace(first, title=f"{first.title}, of those only of which {ENOUGH:g} λ_s² or more make 1 % of the map")]


def _losses(thresholds: DataFrame) -> str:
    peaks = thresholds.assign(peak_gap=[float(peak or 0) for peak in thresholds.peak])
    rows = [
        (group.peak.iloc[0], str(hurst), str(cut), len(group), f"{np.mean(group.loss):.3f}")
        for (_, hurst, cut), group in peaks.groupby(["peak_gap", "hurst", "lambda_s"])
    ]
    head = ("reversed at (h_rms)", "H", "λ_s (a0)", "surfaces", "work lost in the cycle over w")
    return f"**Hysteresis at the threshold**\n\n{Sheet.of('loss', head, rows).markdown()}\n"


def _diameters(table: PointTable) -> str:
    """Deviations from d_rep = 4h'/h'' of the criterion."""
    ratio = sweep_points(table).diameter_ratio
    ratio = ratio[np.isfinite(ratio) & (ratio > 0)]
    far = np.mean((ratio < 0.5) | (ratio > 2))
    near = np.mean(np.abs(ratio - 1) < 0.25)
    return (
        f"d_rep over 4h'/h'' at 1 % area, {ratio.size} points: mean {ratio.mean():.2f}, {near:.0%} within a quarter "
        f"of 1, {far:.1%} off by more than a factor of two.\n"
    )
