"""Cross-validation: run an input on every rung of the ladder, compare state by state, store and judge."""

import shutil
from collections.abc import Callable, Mapping
from contextlib import closing
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from atomistic.inputs.validate import ValidateConfig
from atomistic.ladder import archive, budget
from atomistic.ladder.archive import Archive
from atomistic.ladder.budget import BoundVerdict, checks_of
from atomistic.ladder.comparison import PathPlan, compare_on_path, paths_of
from atomistic.ladder.rungs import NoJumpError
from atomistic.lammps.engine import command_words, runner
from atomistic.relax.specimen import specimen_of
from continuum.inputs.arguments import count, file_name, flag, function
from continuum.inputs.errors import StickinessError
from continuum.inputs.reading import load
from continuum.inputs.tables import Fault
from continuum.inputs.toml import refuse
from continuum.model.walls import LennardJonesSpline
from continuum.store.datasets import Dataset
from continuum.store.granted import granted_processors
from continuum.store.hdf5 import StoreError, understood
from continuum.store.output import distinct, folder, reserved
from continuum.store.sheet import Sheet
from continuum.store.sweeps.workers import Task, TaskResult, run_tasks

Progress = Callable[[str, int, int], None]
"""Called after each path with its result, the number of finished paths and of all."""
MOST_WORKERS = 4
"""Default number of processes of a validation, each with a slab in memory."""


@dataclass(frozen=True, eq=False)
class Validation:
    """A finished validation with the verdict on every bound."""

    path: Path
    config: ValidateConfig = field(repr=False)
    stored: Archive = field(repr=False)
    verdicts: tuple[BoundVerdict, ...] = field(repr=False)

    @property
    def holds(self) -> bool:
        return bool(self.verdicts) and all(verdict.holds for verdict in self.verdicts)

    def budget(self) -> Sheet:
        """The error budget: the error of each step of the ladder."""
        from atomistic.show.validation import budget_sheet

        return budget_sheet(self.config, self.stored)

    def sheets(self) -> list[Sheet]:
        """Budget, scaling laws, jumps, verdicts."""
        from atomistic.show.validation import validation_sheets

        return validation_sheets(self.config, self.stored, self.verdicts)

    @property
    def sentence(self) -> str:
        """The verdict in words: what was judged, what was not and why, how many bounds hold, and those that fail."""
        from atomistic.show.validation import sentence_of

        failed = [verdict for verdict in self.verdicts if not verdict.holds]
        where = "; ".join(v.told for v in failed)
        return sentence_of(self.config, self.verdicts) + (f": {where}" if failed else "")

    def statements(self) -> list[str]:
        """The answer in at most eight lines: verdict, worst states, error of the half-space, what was looked at.

        The command adds where the page and the numbers are.
        """
        from atomistic.show.validation import validation_statements

        return validation_statements(self.config, self.stored, self.verdicts)

    def write(self) -> list[Path]:
        """Draw the figures and write the page, beside the file; returns the page and the PNG files."""
        from atomistic.show.validation import write_validation

        return write_validation(self.path, self.config, self.stored, self.verdicts, self.sentence)

    def _repr_html_(self) -> str:
        return f"<p>{self.sentence}</p>{self.budget()._repr_html_()}"


class ValidationError(StickinessError, RuntimeError):
    """Some paths could not be compared; the others are stored."""


def validate(
    file: str | Path | ValidateConfig,
    output: str | Path = "results",
    *,
    workers: int | None = None,
    decks: str | Path | None = None,
    lmp_command: str | None = None,
    force: bool = False,
    progress: Progress | None = None,
) -> Validation:
    """Press the walls of an input on Green's functions and on atoms, and judge every bound.

    Parameters
    ----------
    file : input (TOML); ``inputs/...`` finds those that come with the package; in Python also a loaded input.
    output : folder for the result, which is named after the input, or its file, ``NAME.h5``.  Paths stored there are
        kept.
    workers : number of processes of one core each; by default all cores that it may use, at most 4.
    decks : keep every LAMMPS deck in this folder.
    lmp_command : command that starts LAMMPS, as ``"srun lmp"``; by default the installed library in this process.
    force : replace a stored result and start anew.
    progress : called after each path with its result, the number of finished paths and of all.

    Raises
    ------
    ArgumentError, ConfigError, OutputError, LammpsError, ValidationError
        If an argument is not allowed, the input cannot be run, the result cannot be stored, or a path cannot be
        compared.  The other paths are stored, and the same call continues.
    """
    path = file_name("output", output)
    decks = None if decks is None else file_name("decks", decks)
    workers = min(MOST_WORKERS, granted_processors()) if workers is None else count("workers", workers, most=1024)
    flag("force", force)
    command_words(lmp_command)
    function("progress", progress)
    config = load(file, ValidateConfig)
    if path.suffix != ".h5":
        path = path / f"{config.source.path.stem if config.source else 'validation'}.h5"
    distinct(path, config.files)
    if decks is not None:
        folder(decks)
    if not archive.is_complete(path, config, force=force):
        specimen = specimen_of(config)
        about = specimen.about()  # measured once for all workers, before anything is written
        with reserved(path):
            parts = path.with_name(f"{path.stem}.parts")
            if force:
                shutil.rmtree(parts, ignore_errors=True)
            if not archive.is_complete(path, config, force=force):  # which another process may have written
                results = _compare_all(config, parts, workers, decks, lmp_command, progress)
                lengths = dict.fromkeys(case.adhesion_length for case in config.case)
                laws = {f"l_a = {each:g} a0": LennardJonesSpline(adhesion_length=each) for each in lengths}
                checks = archive.datasets_of_checks(checks_of(specimen, laws, runner(lmp_command)))
                archive.write_archive(path, config, archive.join(results) | checks, about)
            shutil.rmtree(parts, ignore_errors=True)
    with understood(path):
        stored = archive.read_archive(path)
        return Validation(path, config, stored, tuple(budget.bound_verdicts(config, stored.columns)))


def _compare_all(
    config: ValidateConfig,
    parts: Path,
    workers: int,
    decks: Path | None,
    lmp_command: str | None,
    progress: Progress | None,
) -> list[Mapping[str, Dataset]]:
    """Compare all paths, each into its own file in a folder, and read these.  Paths with a file are done."""
    paths = {folder(parts) / each.file_name: each for each in paths_of(config)}
    compare_path = partial(_compared, config, {path.name: each for path, each in paths.items()}, decks, lmp_command)

    def is_done(task: Task) -> bool:
        try:
            archive.read_archive_part(task.path, config)
        except StoreError:
            return False
        return True

    done, failed = 0, list[TaskResult]()
    tasks = [Task(path, each.label) for path, each in paths.items()]
    with closing(run_tasks(tasks, compare_path, is_done, workers=min(workers, len(tasks)))) as ended:
        for one in ended:
            if isinstance(one.error, NoJumpError):
                raise refuse(config, Fault(("case",), str(one.error), "jump = true for a weak or rough wall"))
            if not one.ok:
                failed.append(one)
                continue
            done += 1
            if progress is not None and not one.found:
                part = archive.read_archive_part(one.task.path, config)
                force, slope = part["largest_force"].values, part["rms_slope"].values
                said = f"{force.size} equilibria, max|f| {float((force / slope).max()):.1e} h' E* a0²"
                progress(f"{one.task.label}: {said}", done, len(tasks))
    if failed:
        reasons = "\n".join(f"{one.task.label}: {one.reason}" for one in failed)
        msg = f"{len(failed)} of {len(tasks)} paths could not be compared; the others are stored in {parts}\n{reasons}"
        raise ValidationError(msg)
    return [archive.read_archive_part(path, config) for path in paths]


def _compared(
    config: ValidateConfig, paths: Mapping[str, PathPlan], decks: Path | None, lmp_command: str | None, task: Task
) -> None:
    """Compare one path, in a worker."""
    archive.write_part(task.path, config, compare_on_path(config, paths[task.path.name], decks, lmp_command))
