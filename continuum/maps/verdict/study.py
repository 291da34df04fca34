"""A study: samples measured at several spots, each possibly at several magnifications.

Sample, spot and magnification of a file follow from its name, or from a table ``study.csv`` in the folder.  The
magnifications of a spot are joined to one surface; each spot is one contact; samples are ranked by w over that of the
threshold, the geometric mean over their spots.  Its interval is Student's, with the scatter of spots pooled over all
samples, as a few spots of one sample do not determine it.  Spots are spots of one surface: the answer for a sample is
that of their mean, with its interval and the error of the method, not of the spots one by one.
"""

import csv
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from continuum.inputs.arguments import instance
from continuum.inputs.errors import InputError
from continuum.maps.map import PER_MAP
from continuum.maps.verdict import criteria
from continuum.maps.verdict.criteria import Answer
from continuum.maps.verdict.extrapolation import CONFIDENCE, ERRORS
from continuum.maps.verdict.prediction import PredictionNumbers

TABLE = "study.csv"
"""Name of the table of files in a folder."""
_FIELDS = ("sample", "spot", "magnification")
_USUAL = re.compile(r"(?P<sample>[^_/]+)(?:[_/](?P<spot>[^_/]+)(?:[_/](?P<magnification>[^_/]+))?)?")
"""Names of files: sample, spot and magnification, between underscores or from a folder."""
_COLUMNS = ("file", *_FIELDS, *PER_MAP)
_NO_MAPS = frozenset({".html", ".png", ".pdf", ".svg", ".json", ".toml", ".md", ".py", ".log", ".docx", ".xlsx"})


@dataclass(frozen=True)
class Scan:
    """One file of a study, with its sample, spot and magnification."""

    path: Path
    sample: str
    spot: str
    options: Mapping[str, str] = field(default_factory=dict)
    """Size, unit, dataset and part, as far as the table has them."""


@dataclass(frozen=True, eq=False)
class Spot:
    """One spot of a sample, with its result."""

    sample: str
    name: str
    files: tuple[str, ...]
    found: PredictionNumbers | None = field(repr=False)
    error: str = ""
    """Reason why the spot could not be used; empty if it was."""

    @property
    def answer(self) -> Answer | None:
        """The verdict; None if the spot could not be used."""
        return None if self.found is None else self.found.verdict.answer

    @property
    def margin(self) -> float | None:
        """Work over the threshold; None if unknown."""
        return None if self.found is None else self.found.verdict.factor

    @property
    def method(self) -> float:
        """Logarithmic error of its threshold as that of this spot; 0 if unknown."""
        found = None if self.found is None else self.found.threshold
        return (
            0.0 if found is None else float(np.log(max(found.high / found.work, found.work / max(found.low, 1e-300))))
        )

    @property
    def sampling(self) -> float:
        """Standard error of the logarithm of its threshold as that of the surface; NaN if unknown."""
        found = None if self.found is None else self.found.threshold
        return np.nan if found is None else found.sampling

    @property
    def open(self) -> bool:
        """True if it is undecided for another reason than that w lies in the interval of its threshold."""
        found = self.found
        if found is None or found.threshold is None or self.answer != "undecided":
            return False
        return found.threshold.sticky(found.contact.work_of_adhesion) is not None


@dataclass(frozen=True, eq=False)
class SampleRank:
    """A sample in the ranking."""

    name: str
    spots: tuple[Spot, ...] = field(repr=False)
    margin: float | None
    """w over that of the threshold, the geometric mean over the spots; None if unknown."""
    interval: tuple[float, float] | None
    """95 % interval from the scatter of the spots, or from the sampling error of one spot; None if neither is known."""
    ranks: tuple[int, int] | None = None
    """The best and the worst place that the intervals allow, from 1; None without a margin."""

    @property
    def answer(self) -> Answer:
        """The answer of the mean of its spots; without an interval that of all spots; undecided if it is open."""
        said = {spot.answer for spot in self.spots if spot.answer is not None}
        if any(spot.open for spot in self.spots):
            return "undecided"
        if self.interval is None or self.margin is None:
            return said.pop() or "undecided" if len(said) == 1 else "undecided"
        method = float(np.mean([spot.method for spot in self.spots if spot.margin is not None]))
        low, high = (
            np.copysign(np.hypot(np.log(end / self.margin), method), end - self.margin) for end in self.interval
        )
        middle = np.log(self.margin)
        return criteria.ANSWERS[True if middle + low > 0 else False if middle + high < 0 else None]

    @property
    def counts(self) -> str:
        """Number of spots with each answer, in words."""
        answers = [spot.answer or "not usable" for spot in self.spots]
        return ", ".join(f"{answers.count(one)} {one}" for one in dict.fromkeys(answers))


@dataclass(frozen=True, eq=False)
class StudyNumbers:
    """Samples in order of stickiness, the stickiest first; those without a margin last."""

    folder: Path
    samples: tuple[SampleRank, ...]
    scatter: float | None
    """Standard deviation of the logarithm of the margin among the spots of a sample, as a factor; None if unknown."""

    @property
    def spots(self) -> tuple[Spot, ...]:
        return tuple(spot for sample in self.samples for spot in sample.spots)

    @property
    def unusable(self) -> tuple[Spot, ...]:
        """Spots of which a file could not be used."""
        return tuple(spot for spot in self.spots if spot.error)


def results_name(folder: Path) -> str:
    """First part of the names of the results: ``wafers-study``, but ``my-study-ranking`` for a folder ``my-study``."""
    name = folder.resolve().name
    return f"{name}-{'ranking' if name.endswith('study') else 'study'}"


def scans(folder: Path, pattern: str | None = None, without: Path | None = None) -> list[Scan]:
    """The files of a study, with the sample and spot of each.

    Parameters
    ----------
    folder : folder of the files, or of a folder for each sample.
    pattern : pattern of the names without their ending, such as ``"{sample}-{spot}-{magnification}"``; if None, a
        table :data:`TABLE`, or else the parts of the names between underscores: sample, spot and magnification.
    without : a folder inside it that is left out, such as that of the results.

    Raises InputError if there is no map, or a name does not fit the pattern.
    """
    if pattern is None and (folder / TABLE).is_file():
        return _from_table(folder)
    form = _USUAL if pattern is None else _form(pattern)
    left, here = None if without is None else without.resolve(), folder.resolve()
    # Results in the folder itself, or above it, are told from maps by their names.
    left = left if left is not None and here in left.parents else None
    ours = {f"{results_name(here)}{end}.csv" for end in ("", "-spots")}
    files = [
        path
        for path in sorted((*folder.glob("*"), *folder.glob("*/*")))
        if path.is_file() and path.suffix.lower() not in _NO_MAPS and not path.name.startswith(".")
        and path.name != TABLE and path.name not in ours and left not in path.resolve().parents
    ]  # fmt: skip
    if not files:
        raise InputError(f"{folder}: a folder without a map in it")
    found, odd = list[Scan](), list[str]()
    for path in files:
        name = path.relative_to(folder).with_suffix("").as_posix()
        told = form.fullmatch(name)
        if told is None:  # all that do not fit are named together
            odd.append(path.relative_to(folder).as_posix())
        else:
            found.append(Scan(path, told["sample"], told.groupdict().get("spot") or "1"))
    if odd:
        kind = "SAMPLE, SAMPLE_SPOT or SAMPLE_SPOT_MAGNIFICATION" if pattern is None else repr(pattern)
        raise InputError(
            f"{folder}: {len(odd)} of {len(files)} names are not of the form {kind}: {', '.join(odd[:5])}: give "
            f"`pattern`, as '{{sample}}-{{spot}}-{{magnification}}', or a table {TABLE} with {', '.join(_COLUMNS)}"
        )
    return found


def _form(pattern: str) -> re.Pattern[str]:
    """The pattern of a name as a regular expression."""
    names = re.findall(r"\{(\w*)\}", instance("pattern", pattern, str, 'a text such as "{sample}_{spot}"'))
    wrong = [name for name in names if name not in _FIELDS]
    if wrong or "sample" not in names or len(set(names)) < len(names):
        allowed = ", ".join(f"{{{name}}}" for name in _FIELDS)
        raise InputError(f"`pattern` {pattern!r}: it has {{sample}} and may have others, each once; allowed: {allowed}")
    pieces = re.split(r"\{(\w+)\}", pattern)
    return re.compile("".join(f"(?P<{one}>[^/]+?)" if i % 2 else re.escape(one) for i, one in enumerate(pieces)))


def _from_table(folder: Path) -> list[Scan]:
    path = folder / TABLE
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read ({error})") from error
    rows = csv.DictReader(text.splitlines(), skipinitialspace=True)
    head = [name.strip() for name in rows.fieldnames or ()]
    unknown = [name for name in head if name not in _COLUMNS]
    if unknown or not {"file", "sample"} <= set(head):
        why = f"no column is called {unknown[0]!r}" if unknown else "columns file and sample are needed"
        raise InputError(f"{path}: {why}; allowed: {', '.join(_COLUMNS)}")
    rows.fieldnames = head
    found, faults = list[Scan](), list[str]()
    for number, row in enumerate(rows, 2):
        cells = {name: (text or "").strip() for name, text in row.items() if isinstance(name, str)}
        if not cells["file"] or not cells["sample"]:
            faults.append(f"{path}:{number}: a file and a sample are needed")
        elif not (folder / cells["file"]).is_file():
            faults.append(f"{path}:{number}: there is no file {cells['file']!r}")
        else:
            told = {name: cells[name] for name in PER_MAP if cells.get(name)}
            found.append(Scan(folder / cells["file"], cells["sample"], cells.get("spot") or "1", told))
    if faults or not found:
        raise InputError("\n".join(faults) or f"{path}: no file is named")
    return found


def ranked(folder: Path, spots: Sequence[Spot]) -> StudyNumbers:
    """Rank samples by the mean margin of their spots, with intervals and possible ranks."""
    logs = {name: [np.log(spot.margin) for spot in spots if spot.sample == name and spot.margin] for name in
            dict.fromkeys(spot.sample for spot in spots)}  # fmt: skip
    freedom = sum(max(len(values) - 1, 0) for values in logs.values())
    squares = sum(float(np.sum((np.array(values) - np.mean(values)) ** 2)) for values in logs.values() if values)
    scatter = float(np.sqrt(squares / freedom)) if freedom else None
    samples = []
    for name, values in logs.items():
        own = tuple(spot for spot in spots if spot.sample == name)
        margin = float(np.exp(np.mean(values))) if values else None
        half = _half(values, scatter, freedom, [spot.sampling for spot in own if spot.margin])
        interval = None if margin is None or half is None else (margin * np.exp(-half), margin * np.exp(half))
        samples.append(SampleRank(name, own, margin, interval))
    samples.sort(key=lambda one: -(one.margin or 0.0))
    with_ranks = tuple(replace(one, ranks=_ranks(one, samples)) for one in samples)
    return StudyNumbers(folder, with_ranks, None if scatter is None else float(np.exp(scatter)))


def _half(values: Sequence[float], scatter: float | None, freedom: int, sampling: Sequence[float]) -> float | None:
    """Half of the interval of a mean of logarithms: Student's, or of one spot two of its sampling errors."""
    if scatter is not None:
        from scipy.special import stdtrit  # imported late: not needed if no sample has two spots

        return float(scatter * stdtrit(freedom, (1 + CONFIDENCE) / 2) / np.sqrt(max(len(values), 1)))
    return ERRORS * sampling[0] if sampling and np.isfinite(sampling[0]) else None


def _ranks(one: SampleRank, samples: Sequence[SampleRank]) -> tuple[int, int] | None:
    """The best and worst rank of each sample that the intervals allow; without intervals any rank."""
    others = [other for other in samples if other is not one and other.margin is not None]
    if one.margin is None:
        return None
    if one.interval is None:
        return 1, len(others) + 1
    above = sum(other.interval is not None and other.interval[0] > one.interval[1] for other in others)
    below = sum(other.interval is not None and other.interval[1] < one.interval[0] for other in others)
    return above + 1, len(others) + 1 - below
