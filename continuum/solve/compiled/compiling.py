"""How the sweeps of this back end are compiled, and the numbers that they share.

Compiled code is kept on disk, and compiled anew when the file of a function has changed; nobody looks at the files of
the functions that it calls.  The name of the file of the code holds the qualified name of the function: so that name
is given a digest of the sources that any sweep calls from elsewhere, the formulas of the laws first.
"""

import hashlib
import logging
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np
from numba import njit
from numba.core import event
from numpy.typing import NDArray

from continuum.model import laws
from continuum.model.kept import folder_of_compiled, kept_on_disk

SUMS = 6
"""Sums of a sweep, at most."""
TILE = 64
"""Length in points of the pieces of a row that are marked as near the wall or not."""

Single = NDArray[np.float32]
"""A field in single precision."""
Field = NDArray[Any]
"""A field or spectrum in double precision or, of a linear problem, in single."""
Mask = NDArray[np.bool_]
"""Which tiles are near the wall, one row per row of points; or which points are in contact."""
Marks = NDArray[np.uint8]
"""What a tile of the pressure holds, one row per row of points."""
Index = NDArray[np.int64]
"""Numbers of nodes or points."""
Kernel = TypeVar("Kernel", bound=Callable[..., object])

_HERE = Path(__file__)
_NAMED = ("spectra", "points", "tractions", "pressing", "two_levels")
SOURCES = (Path(laws.__file__), _HERE, *(_HERE.with_name(f"{name}.py") for name in _NAMED))
"""Files, beside its own, whose functions, constants, options and types of arguments a sweep is compiled with."""


def digest(sources: Iterable[Path]) -> str:
    """Short hash of the content of some files."""
    return hashlib.sha256(b"\0".join(source.read_bytes() for source in sources)).hexdigest()[:12]


_DIGEST = digest(SOURCES)
_FAST = {"reassoc", "contract", "nsz", "arcp"}


class _FirstCompilation(event.Listener):
    """Says at a terminal, once, why nothing seems to happen; sweeps that are on disk are read without a word."""

    told = False

    def on_start(self, event: event.Event) -> None:
        sweep = event.data["dispatcher"].py_func.__qualname__.endswith(_DIGEST)
        if sweep and not self.told and sys.stderr.isatty():
            self.told = True
            each = "as no folder for compiled code can be written: NUMBA_CACHE_DIR names one"
            when = "once after it was installed" if folder_of_compiled(_HERE.parent) else f"in each process, {each}"
            logging.getLogger(__name__).warning(f"compiling the solver, {when}: about 10 s")

    def on_end(self, event: event.Event) -> None:
        pass


event.register("numba:compile", _FirstCompilation())  # type: ignore[no-untyped-call]


def compiled(function: Kernel) -> Kernel:
    """Compile a sweep, so that it releases the lock of the interpreter, and keep the result on disk.

    Sums may be reordered and a division by zero is infinite instead of an error: only so do loops vectorise.
    A NaN stays a NaN.
    """
    function.__qualname__ = f"{function.__qualname__}-{_DIGEST}"
    return kept_on_disk(nogil=True, error_model="numpy", fastmath=_FAST)(function)


def inlined(function: Kernel) -> Kernel:
    """Compile a part of a sweep of the same file, as if its lines stood there."""
    return cast("Kernel", njit(nogil=True, error_model="numpy", fastmath=_FAST, inline="always")(function))
