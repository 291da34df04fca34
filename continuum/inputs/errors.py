"""Expected failures: the message of each says what is wrong and what to do."""

import re
import signal
from collections.abc import Mapping

OK, NOT_CONVERGED, BAD_INPUT = 0, 1, 2

EXIT_CODES: Mapping[int, str] = {
    OK: "success",
    NOT_CONVERGED: "not converged, no solution, or a bound violated",
    BAD_INPUT: "invalid input or output, nothing was written",
    128 + signal.SIGHUP: "terminal closed",
    128 + signal.SIGINT: "stopped by Ctrl-C",
    128 + signal.SIGPIPE: "output pipe closed",
    128 + signal.SIGTERM: "stopped by SIGTERM",
}
"""Exit codes of both programs.  After a signal a shell reports 128 plus its number."""


_LONG = re.compile(r"[^\s/]{81,}")


def shortened(text: str) -> str:
    """Shorten file names of more than 80 characters in a message to their beginning and end."""
    return _LONG.sub(lambda name: f"{name[0][:30]}...{name[0][-30:]}", text)


class StickinessError(Exception):
    """The work failed though the input was valid: something did not converge, or a program failed."""

    exit_code = NOT_CONVERGED
    """Exit code of a command that ends with this error."""

    def __str__(self) -> str:
        return shortened(super().__str__())


class InputError(StickinessError):
    """A file, an option, an argument or a place for the output cannot be used.  Nothing was written."""

    exit_code = BAD_INPUT


class OutputError(InputError, ValueError):
    """An output cannot be written; existing files are unchanged."""
