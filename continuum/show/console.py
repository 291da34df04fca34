"""What a person sees of long work: a progress bar or plain lines, tables, errors."""

from __future__ import annotations

import logging
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Protocol

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
)
from rich.table import Table

from continuum.show.sheet import Sheet

__all__ = ["BAD_INPUT", "NOT_CONVERGED", "OK", "Reporter", "exit_code", "progress", "show", "warn"]

OK, NOT_CONVERGED, BAD_INPUT = 0, 1, 2
"""Exit codes: all well; something did not converge, hold or exist; the input is at fault and nothing was written."""

# A pipe or a batch log has no width of its own: wide enough that no table is cut.
_console = Console(width=None if sys.stdout.isatty() else 160, highlight=False)


class Reporter(Protocol):
    """Called after each finished part of the work."""

    def __call__(self, done: int, text: str) -> None:
        """Say how many parts are done, and what the last one was."""


@contextmanager
def progress(total: int, title: str) -> Iterator[Reporter]:
    """Show progress: a bar on a terminal, one line with the time for each part where there is none.

    What remains is estimated from the parts that this call has done, as if the others took as long on average.

    Parameters
    ----------
    total : parts in all; what the first report counts beyond its own part was finished by an earlier run.
    title : of the work.
    """
    before, began = -1, time.monotonic()

    def left(done: int) -> str:
        nonlocal before
        before = done - 1 if before < 0 else before
        seconds = (time.monotonic() - began) / max(done - before, 1) * (total - done)
        return f"about {_duration(seconds)} left" if done < total else ""

    if _console.is_terminal:
        columns = (
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TextColumn("{task.fields[left]}[dim]{task.fields[text]}"),
        )
        with Progress(*columns, console=_console) as bar:
            task = bar.add_task(title, total=total, left="", text="")

            def report(done: int, text: str) -> None:
                bar.update(task, completed=done, left=left(done) + "  ", text=text)

            yield report
        return
    handler = logging.StreamHandler(sys.stdout)
    handler.setFormatter(logging.Formatter("%(asctime)s  %(message)s", datefmt="%Y-%m-%d %H:%M:%S"))
    logger = logging.getLogger("stickiness.progress")
    logger.setLevel(logging.INFO)
    logger.propagate = False
    logger.addHandler(handler)

    def line(done: int, text: str) -> None:
        about = f", {left(done)}" if done < total else ""
        logger.info("%s %d/%d  %s%s", title, done, total, text, about)

    try:
        yield line
    finally:
        logger.removeHandler(handler)


def _duration(seconds: float) -> str:
    """A time as people say it: no more digits than an estimate has."""
    for size, unit in ((86400, "d"), (3600, "h"), (60, "min")):
        if seconds >= 2 * size:
            return f"{seconds / size:.0f} {unit}"
    return f"{seconds:.0f} s"


def warn(messages: Sequence[str]) -> None:
    """Say on the error stream what does not stop the work but matters for its result."""
    for message in messages:
        print(f"warning: {message}", file=sys.stderr)  # noqa: T201


def show(sheet: Sheet) -> None:
    """Print a sheet; numbers to the right."""
    table = Table(title=sheet.title, title_justify="left", title_style="bold",
                  caption=sheet.note or None, caption_justify="left")  # fmt: skip
    for i, name in enumerate(sheet.head):
        table.add_column(name, justify="right" if sheet.numeric(i) else "left", overflow="fold")
    for row in sheet.cells:
        table.add_row(*row)
    _console.print(table)


def exit_code(
    command: Callable[[], int],
    bad_input: tuple[type[Exception], ...],
    failures: tuple[type[Exception], ...] = (),
    advice: str = "",
) -> int:
    """Run a command and say in one message why it ended, if it did not end well.

    Parameters
    ----------
    command : returns its exit code.
    bad_input : errors that are the input's fault; nothing has been written.
    failures : errors of the work itself; what is finished is stored.
    advice : added to the message of a failure.
    """
    try:
        return command()
    except bad_input as error:
        _complain(error)
        return BAD_INPUT
    except failures as error:
        _complain(f"{error}\n{advice}".rstrip())
    except KeyboardInterrupt:
        _complain("stopped; what is finished is stored, and the same command goes on from there")
    return NOT_CONVERGED


def _complain(message: object) -> None:
    print(message, file=sys.stderr)  # noqa: T201 - the one place
