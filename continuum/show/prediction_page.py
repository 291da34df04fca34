"""The page of a prediction with its figures: what draws is imported after the answer has been printed."""

from pathlib import Path

from continuum.maps.verdict.prediction import PredictionNumbers
from continuum.show import plot
from continuum.show.answer import statements
from continuum.show.page import Page
from continuum.show.prediction import prediction_sheets, reading_order
from continuum.show.prediction_figures import fault_figure, load_figure, overview
from continuum.show.verdict_axis import COLOURS, verdict_axis
from continuum.store.sheet import Sheet


def write_prediction(prediction: PredictionNumbers, folder: Path, name: str) -> list[Path]:
    """Write ``NAME.html``, which needs no other file, and its figures as PNG, or in the formats of
    :func:`continuum.show.plot.written_as`; returns HTML and PNG files.
    """
    figures = {name: (overview(prediction), "")}
    if (loads := load_figure(prediction)) is not None:
        figures[f"{name}-load"] = loads, "Mean pressure against contact area, with the error of the threshold."
    if prediction.faults:
        figures[f"{name}-faults"] = (fault_figure(prediction), "Faults of the map.")
    drawn = [
        (plot.save_figure(figure, folder / stem, usual=(), page=True), caption)
        for stem, (figure, caption) in figures.items()
    ]
    (answer, *more), word = statements(prediction), prediction.verdict.answer
    remarks = [Sheet.of("Remarks", ("",), [(text,) for text in prediction.doubts])] if prediction.doubts else []
    page = Page(
        "Is it sticky?  " + " and ".join(t.source for t in prediction.topographies),
        f"{answer}.",
        (),
        drawn,
        [*remarks, *reading_order(prediction_sheets(prediction))],
        sources="Contact and theories: L. Pastewka and M. O. Robbins, PNAS 111, 3298 (2014), and the sources in the "
        "tables.",
        answers=[f"{line}." for line in more],
        answer=(word.capitalize(), COLOURS[word], verdict_axis(prediction)),
    )
    return [page.write(folder / f"{name}.html"), *(path for path, _ in drawn)]
