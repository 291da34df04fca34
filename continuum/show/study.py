"""The ranking of a study in a sentence and as sheets."""

from continuum.maps.verdict.study import SampleRank, StudyNumbers
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


def ranking_row(sample: SampleRank) -> dict[str, str | float | None]:
    """One row of the ranking."""
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
    rows = [tuple(ranking_row(sample).values()) for sample in study.samples]
    ranking = Sheet.of("Ranking of the samples", tuple(ranking_row(study.samples[0])), rows, _NOTE)
    cells: list[tuple[Entry, ...]] = [
        (spot.sample, spot.name, ", ".join(spot.files), spot.answer or f"not usable: {spot.error}", spot.margin)
        for spot in study.spots
    ]
    return [ranking, Sheet.of("Spots", ("sample", "spot", "files", "verdict", "w/w_c"), cells)]
