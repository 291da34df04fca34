"""The ranking of a study: sheets, a figure, a page and tables."""

from pathlib import Path

from matplotlib.figure import Figure

from continuum.maps.verdict.study import SampleRank, StudyNumbers
from continuum.show import plot
from continuum.show.page import Page
from continuum.show.prediction_data import as_csv, row
from continuum.store import output
from continuum.store.sheet import Entry, Sheet

_NOTE = (
    "Sorted by w/w_c, the geometric mean over the spots of a sample: above 1 it is sticky.  The interval holds it with "
    "95 %, by Student, with the scatter of spots pooled over all samples, or by the sampling error of a single spot; "
    "the verdict takes the error of w_c, too.  Ranks: the places that the intervals leave open."
)


def study_sentence(study: StudyNumbers) -> str:
    """The answer in one text."""
    first = [one for one in study.samples if one.margin is not None]
    if not first:
        return "No ranking: the threshold of no spot is known"
    top = [one.name for one in first if one.ranks is not None and one.ranks[0] == 1]
    if len(first) == 1:
        return f"{first[0].name}: {first[0].answer} ({first[0].counts})"
    if len(top) == 1:
        return f"{top[0]} is the stickiest of {len(study.samples)} samples ({first[0].counts})"
    alone = all(one.interval is None for one in first)
    why = "no spot was measured beside another" if alone else "their intervals overlap"
    return f"{', '.join(top[:-1])} and {top[-1]} cannot be told apart as the stickiest: {why}"


def study_doubts(study: StudyNumbers) -> list[str]:
    """Warnings about a ranking."""
    doubts = [f"{spot.sample}, spot {spot.name}: left out: {spot.error}" for spot in study.unusable]
    nothing = [spot for spot in study.spots if spot.found is not None and spot.margin is None]
    doubts += [f"{spot.sample}, spot {spot.name}: undecided, and in no mean" for spot in nothing]
    if all(one.interval is None for one in study.samples):
        doubts.append("one spot of each sample: how spots scatter is not known, and no sample is told from another")
    return doubts


def _ranking_row(sample: SampleRank) -> dict[str, str | float | None]:
    low, high = sample.interval or (None, None)
    return {
        "rank": "-" if sample.ranks is None else " to ".join(dict.fromkeys(map(str, sample.ranks))),
        "sample": sample.name,
        "verdict": sample.answer,
        "spots": sample.counts,
        "w/w_c": sample.margin,
        "lower end": low,
        "upper end": high,
    }


def study_sheets(study: StudyNumbers) -> list[Sheet]:
    """The ranking, and its spots."""
    rows = [tuple(_ranking_row(sample).values()) for sample in study.samples]
    ranking = Sheet.of("Ranking of the samples", tuple(_ranking_row(study.samples[0])), rows, _NOTE)
    cells: list[tuple[Entry, ...]] = [
        (spot.sample, spot.name, ", ".join(spot.files), spot.answer or f"not usable: {spot.error}", spot.margin)
        for spot in study.spots
    ]
    return [ranking, Sheet.of("Spots", ("sample", "spot", "files", "verdict", "w/w_c"), cells)]


@plot.styled
def study_figure(study: StudyNumbers) -> Figure:
    """Each sample with its spots, mean and interval."""
    shown = [sample for sample in study.samples if sample.margin is not None]
    figure, axis = plot.new_axes(plot.PAGE, 1.2 + 0.35 * max(len(shown), 2))
    for place, sample in enumerate(shown):
        margins = [spot.margin for spot in sample.spots if spot.margin is not None]
        axis.plot(margins, [place] * len(margins), "o", color=plot.SERIES[0], alpha=0.5, label="spots")
        if sample.interval is not None:
            axis.plot(sample.interval, [place] * 2, color="black", linewidth=1.5, label="mean, 95 %")
        axis.plot(sample.margin, place, "|", color="black", markersize=12, markeredgewidth=2)
    axis.axvline(1.0, color="gray", linestyle="--", linewidth=1)
    axis.set(xscale="log", xlabel="w/w_c (sticky above 1)", ylim=(len(shown) - 0.5, -0.5))
    axis.set_yticks(range(len(shown)), [sample.name for sample in shown])
    plot.log_ticks(axis)
    plot.legend_below(figure, plot.labelled(axis))
    return figure


def write_study(study: StudyNumbers, folder: Path, name: str) -> list[Path]:
    """Write the page, its figure, the ranking and its spots as tables; returns their paths."""
    drawn = []
    if any(sample.margin is not None for sample in study.samples):
        picture = plot.save_figure(study_figure(study), folder / name, usual=(), page=True)
        drawn = [(picture, "Spots, and mean of each sample.")]
    title = f"Ranking of samples by stickiness:  {study.folder.resolve().name}"
    page = Page(title, study_sentence(study) + ".", study_doubts(study), drawn, study_sheets(study))
    output.folder(folder)
    spots = []
    for spot in study.spots:
        named: dict[str, str | float | None] = {
            "sample": spot.sample, "spot": spot.name, "files": ", ".join(spot.files),
            "w/w_c": spot.margin, "error": spot.error,
        }  # fmt: skip
        spots.append(named | ({} if spot.found is None else row(spot.found)))
    return [
        page.write(folder / f"{name}.html"),
        *(path for path, _ in drawn),
        output.save(folder / f"{name}.csv", as_csv([_ranking_row(sample) for sample in study.samples])),
        output.save(folder / f"{name}-spots.csv", as_csv(spots)),
    ]
