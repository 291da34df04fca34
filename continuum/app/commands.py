"""The command ``continuum view``."""

from pathlib import Path
from typing import Any

from continuum.app import view as viewing
from continuum.errors import OK, InputError
from continuum.options import like


@like(viewing.view)
def view(*file: Path, **given: Any) -> int:
    if len(file) > 1:
        raise InputError(f"{file[1]}: only one file can be opened at a time")
    viewing.view(*file, **given)
    return OK
