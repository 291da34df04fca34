"""The page of a study with its figure, and its tables."""

from pathlib import Path

from matplotlib.figure import Figure

from continuum.maps.verdict.study import StudyNumbers
from continuum.show import plot
from continuum.show.page import Page
from continuum.show.prediction_data import as_csv, row
from continuum.show.study import ranking_row, study_doubts, study_sentence, study_sheets
from continuum.store import output


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
        output.save(folder / f"{name}.csv", as_csv([ranking_row(sample) for sample in study.samples])),
        output.save(folder / f"{name}-spots.csv", as_csv(spots)),
    ]
