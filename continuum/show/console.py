"""Progress, tables and errors on the terminal."""

import codecs
import contextlib
import errno
import io
import os
import signal
import sys
import time
import traceback
import unicodedata
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from typing import Any, Literal, NoReturn

from rich import box
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
)
from rich.table import Table

from continuum.inputs.errors import BAD_INPUT, NOT_CONVERGED, OK, StickinessError, shortened
from continuum.store.sheet import WIDEST, Sheet, duration

Voice = Literal["quiet", "normal", "verbose"]
"""Amount of output of a command.

Quiet: results, warnings and errors only.  Verbose: also a line for each part of the work on a terminal, and the place
in the code of an error.
"""

_voice: ContextVar[Voice] = ContextVar("voice", default="normal")


class _Console(Console):
    def on_broken_pipe(self) -> NoReturn:
        """Leave a reader that is gone to :func:`exit_code`: rich would end with code 1, that of no convergence."""
        raise BrokenPipeError


_console = _Console(highlight=False)


Reporter = Callable[[int, str], None]
"""Called after each finished part of the work, with the number of finished parts and a description of the last."""


@contextmanager
def progress(total: int, title: str, estimate: Callable[[], str] | None = None) -> Iterator[Reporter]:
    """Show progress: a bar on a terminal; otherwise, or if verbose, one line with the time for each part.

    The remaining time is estimated from the average time of the parts that this call has finished.

    Parameters
    ----------
    total : number of parts; parts that the first report counts in addition to its own were finished by an earlier run.
    title : title of the work.
    estimate : returns the remaining time in words, where more is known than the number of parts; empty if it is not.
    """
    before, began, title = -1, time.monotonic(), shortened(title)

    def left(done: int) -> str:
        nonlocal before
        before = done - 1 if before < 0 else before
        if done >= total:
            return ""
        if estimate is None:
            seconds = (time.monotonic() - began) / max(done - before, 1) * (total - done)
            return f"about {duration(seconds)} left"
        return f"{said} left" if (said := estimate()) else ""

    if _voice.get() == "quiet":
        yield lambda done, text: None
        return
    if on_a_bar():
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

    def line(done: int, text: str) -> None:
        about = f", {said}" if (said := left(done)) else ""
        sys.stdout.write(f"{time.strftime('%Y-%m-%d %H:%M:%S')}  {title} {done}/{total}  {text}{about}\n")
        sys.stdout.flush()

    yield line


@contextmanager
def progress_of_known(title: str, text: str = "") -> Iterator[Callable[[int, int], None]]:
    """Progress of work whose number of parts is known once the first is done: nothing is shown before.

    Yields a function to be called with the number of finished parts and of all.
    """
    with contextlib.ExitStack() as bars:
        bar = cache(lambda total: bars.enter_context(progress(total, title)))
        yield lambda done, total: bar(total)(done, text)


def warn(messages: Sequence[str]) -> None:
    """Print warnings to the error stream."""
    for message in messages:
        sys.stderr.write(f"warning: {message}\n")


def tell(text: str) -> None:
    """Print what is being done to the error stream, so that the output begins with the answer; nothing if quiet."""
    if _voice.get() != "quiet":
        sys.stderr.write(f"{text}\n")
        sys.stderr.flush()


def on_a_bar() -> bool:
    """True if progress is shown as a bar, false if each report is a line."""
    return _console.is_terminal and not verbose()


def verbose() -> bool:
    """True if commands print all known details."""
    return _voice.get() == "verbose"


def clear() -> None:
    """Clear the terminal, if there is one."""
    if _console.is_terminal:
        _console.clear()


def show(sheet: Sheet) -> None:
    """Print a sheet: on a terminal in its width, with a rule below the heads, otherwise as plain text."""
    if _voice.get() == "quiet":
        return
    if not _console.is_terminal:
        _console.out(sheet.text() + "\n", highlight=False)
        return
    width = min(_console.width, WIDEST)
    table = Table(title=sheet.title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, show_edge=False,
                  padding=(0, 1, 0, 0), pad_edge=False, caption="\n".join(sheet.notes(width)) or None,
                  caption_justify="left")  # fmt: skip
    head, *rows = (["\n".join(cell) for cell in row] for row in sheet.laid_out(width))
    for i, name in enumerate(head):
        table.add_column(name, justify="right" if sheet.numeric(i) else "left", overflow="fold")
    for row in rows:
        table.add_row(*row)
    _console.print(table)


def report(*sheets: Sheet, warnings: Sequence[str] = (), lines: Iterable[object] = (), ok: bool = True) -> int:
    """Print what a command has found, sheets first; returns its exit code."""
    for sheet in sheets:
        show(sheet)
    warn(warnings)
    for line in lines:
        sys.stdout.write(f"{line}\n")
    return OK if ok else NOT_CONVERGED


def exit_code(
    command: Callable[[], int],
    voice: Voice = "normal",
    worded: Callable[[str], str] = str,
    *,
    resumes: bool = False,
) -> int:
    """Run a command of either program, and print one message if it fails.

    Parameters
    ----------
    command : returns its exit code.
    voice : amount of output.
    worded : what a message is on a command line.
    resumes : whether the command, once stopped, continues from what it stored.
    """
    _three_streams()
    before = _voice.set(voice)
    try:
        with _stopped_as_by_ctrl_c(), warnings.catch_warnings():
            warnings.showwarning = lambda message, *where, **more: warn([str(message)])
            code = command()
            sys.stdout.flush()
    except StickinessError as error:
        text = worded(str(error))
        kept = "\nFinished work is stored." if resumes and error.exit_code != BAD_INPUT else ""
        return _complain(f"{text}{kept}", error.exit_code)
    except OSError as error:
        if isinstance(error, BrokenPipeError) or (error.errno == errno.EIO and error.filename is None):
            # The reader, such as `head`, has seen enough, or the terminal is gone.  Nothing more can be said to it, not
            # even as the process ends.
            os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
            said = "stopped, as the output cannot be written" + ("; finished work is stored" if resumes else "")
            return _complain(said, 128 + signal.SIGPIPE)
        where = f"{error.filename}: " if error.filename is not None else ""
        return _complain(f"{where}{error.strerror or error}", BAD_INPUT)
    except MemoryError as error:
        detail = f" ({error})" if str(error) else ""
        return _complain(f"there is not enough memory{detail}; `check` says how much an input needs", NOT_CONVERGED)
    except KeyboardInterrupt as stopped:
        goes_on = "finished work is stored, and the same command continues from there"
        said = f"stopped; {goes_on if resumes else 'the same command starts anew'}"
        return _complain(said, 128 + (stopped.args[0] if stopped.args else signal.SIGINT))
    finally:
        _voice.reset(before)
    return code


@contextmanager
def until_ctrl_c() -> Iterator[None]:
    """Run a task that only ends by Ctrl-C; other signals stop it as they stop any command."""
    try:
        yield
    except KeyboardInterrupt as stopped:
        if stopped.args:
            raise


def _stop(number: int, frame: object) -> NoReturn:
    raise KeyboardInterrupt(number)


@contextmanager
def _stopped_as_by_ctrl_c() -> Iterator[None]:
    """Let SIGTERM (`kill`, queues of clusters) and SIGHUP (closed terminals) stop the work as Ctrl-C does.

    SIGINT and SIGHUP that were ignored at the start, as by `nohup` and by `&` in a script, stay ignored.
    """
    before: dict[signal.Signals, Any] = {}
    try:
        for each in (signal.SIGTERM, signal.SIGHUP):
            if each is signal.SIGTERM or signal.getsignal(each) is not signal.SIG_IGN:
                before[each] = signal.signal(each, _stop)
    except ValueError:  # only the main thread of a process receives signals
        pass
    try:
        yield
    finally:
        for each, handler in before.items():
            signal.signal(each, handler or signal.SIG_DFL)


def _three_streams() -> None:
    """Open the null device for each closed standard stream; otherwise the next file would get its number."""
    for stream in range(3):
        try:
            os.fstat(stream)
        except OSError:
            os.dup2(os.open(os.devnull, os.O_RDWR), stream)
    sys.stdout = sys.stdout or io.TextIOWrapper(io.FileIO(os.devnull, "w"))
    sys.stderr = sys.stderr or io.TextIOWrapper(io.FileIO(os.devnull, "w"))
    for terminal in (sys.stdout, sys.stderr):
        if isinstance(terminal, io.TextIOWrapper) and not terminal.encoding.lower().startswith("utf"):
            terminal.reconfigure(errors=_ASCII)


def _complain(message: object, code: int) -> int:
    with contextlib.suppress(OSError):
        if _voice.get() == "verbose":
            traceback.print_exc()
        sys.stderr.write(f"{message}\n")
    return code


_ASCII = "stickiness.ascii"
_WORDS = {
    "κ": "kappa", "λ": "lambda", "ν": "nu", "π": "pi", "γ": "gamma", "ρ": "rho", "σ": "sigma", "μ": "mu", "θ": "theta",
    "Δ": "Delta ", "δ": "delta", "²": "^2", "³": "^3", "½": "1/2", "×": "x", "·": ".", "±": "+-", "−": "-", "–": "-",
    "—": "-", "≤": "<=", "≥": ">=", "≈": "~", "∞": "inf", "√": "sqrt", "→": "->", "…": "...", "“": '"', "”": '"',
    "’": "'", "∝": "~",
}  # fmt: skip


def _in_ascii(error: UnicodeError) -> tuple[str, int]:
    """Replacements for characters that a terminal lacks."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    text = error.object[error.start : error.end]
    plain = (_WORDS.get(c) or unicodedata.normalize("NFKD", c).encode("ascii", "ignore").decode() or "?" for c in text)
    return "".join(plain), error.end


codecs.register_error(_ASCII, _in_ascii)
