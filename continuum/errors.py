"""Failures that are foreseen: the message of each says what is wrong and what to do, and no more is needed."""

import re
from collections.abc import Mapping

OK, NOT_CONVERGED, BAD_INPUT = 0, 1, 2

EXIT_CODES: Mapping[int, str] = {
    OK: "all well",
    NOT_CONVERGED: "something did not converge, does not exist (a tension too large, an area that is jumped over) or "
    "does not hold (a bound of a validation); or the work was stopped; what is finished is stored",
    BAD_INPUT: "the input is at fault, or the output cannot be written; nothing was written",
}
"""Exit codes of both programs, and what they mean."""


_LONG = re.compile(r"[^\s/]{81,}")


def shortened(text: str) -> str:
    """A message in which names of files longer than 80 characters are told by their beginning and end."""
    return _LONG.sub(lambda name: f"{name[0][:30]}...{name[0][-30:]}", text)


class StickinessError(Exception):
    """The work could not be done, though the input was sound: something did not converge, or a program failed."""

    exit_code = NOT_CONVERGED
    """Exit code of a command that ends with this error."""

    def __str__(self) -> str:
        return shortened(super().__str__())


class InputError(StickinessError):
    """What was given is at fault: a file, an option, an argument, a place for the output.  Nothing was written."""

    exit_code = BAD_INPUT


class OutputError(InputError, ValueError):
    """An output cannot be written where it should be; what was there is as it was."""
