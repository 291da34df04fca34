"""Failures that are foreseen: the message of each says what is wrong and what to do, and no more is needed."""

from __future__ import annotations

__all__ = ["InputError", "OutputError", "StickinessError"]


class StickinessError(Exception):
    """The work could not be done, though the input was sound: something did not converge, or a program failed."""

    exit_code = 1
    """Of the commands."""


class InputError(StickinessError):
    """What was given is at fault: a file, an option, an argument, a place for the output.  Nothing was written."""

    exit_code = 2


class OutputError(InputError, ValueError):
    """Nothing can be written where it should be; what was there is as it was."""
