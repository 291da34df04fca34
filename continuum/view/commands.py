"""The command ``continuum view``."""

from pathlib import Path
from typing import Any

from continuum.front.options import like
from continuum.inputs.errors import OK, InputError
from continuum.view import browser as viewing


@like(viewing.view)
def view(*file: Path, **given: Any) -> int:
    if len(file) > 1:
        raise InputError(f"{file[1]}: only one file can be opened at a time")
    viewing.view(*file, **given)
    return OK
