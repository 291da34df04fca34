"""Is my surface sticky: a measured topography, or two, in an interface."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import get_args

from numpy.typing import ArrayLike

from continuum.arguments import choice, count, flag
from continuum.solve.solution import MOST_THREADS
from continuum.sticky import materials
from continuum.sticky.materials import Interface, InterfaceError
from continuum.sticky.predict import prediction_of
from continuum.sticky.prediction import Prediction
from continuum.topography import mending, quantities, reading
from continuum.topography.map import Topography, TopographyError
from continuum.topography.mending import Detrending


def predict(
    *maps: str | Path | ArrayLike,
    size: str | Sequence[str] | None = None,
    unit: str | Sequence[str] | None = None,
    dataset: str | Sequence[str] | None = None,
    part: str | Sequence[str] | None = None,
    periodic: bool = False,
    override_size: bool = False,
    detrend: Detrending | None = None,
    fill: str | float | None = None,
    crop: str | None = None,
    cutoff: str | None = None,
    material: str | Sequence[str] = (),
    modulus: str | Sequence[str] = (),
    poisson: str | float | Sequence[str | float] = (),
    contact_modulus: str | None = None,
    work: str | None = None,
    range: str | None = None,
    spacing: str | None = None,
    solve: bool = False,
    threads: int = 1,
) -> Prediction:
    """Is my surface sticky?  Every criterion on a measured topography, or on two that face each other.

    Every quantity is a text with its unit, as ``"50mJ/m2"``.

    Parameters
    ----------
    maps : one topography, or two for two rough bodies: names of files, or arrays of heights, shape (nx, ny), out of the
        body.  Masked points of an array are missing ones; an array of one row or column is a line scan.
    size : physical size, ``"10um"`` or ``"10um,12um"``, along the first index and the second; an array needs it, a file
        only if it does not say.  Of two maps one text for both, or one for each, ``"-"`` as the file says.
    unit : of the heights, like ``"nm"``; given as the size is.
    dataset, part, periodic, crop, override_size : see :func:`continuum.topography.reading.read_all`.
    detrend, fill, cutoff : see :func:`continuum.topography.mending.prepare`; fill as ``"5%"`` or 0.05.
    material, modulus, poisson : of one elastic body on a rigid one, or of two.
    contact_modulus : E*, instead.
    work, range : w and Δr, if not those of the material.
    spacing : of the atoms.
    solve, threads : whether to solve the contact of the map, too, and on how many threads.

    Raises
    ------
    TopographyError, InterfaceError
        If a map or the contact cannot be used.
    ArgumentError
        If an argument is of another type, such as a number where a text with its unit is asked for.
    """
    if detrend is not None:
        choice("detrend", detrend, get_args(Detrending))
    flag("solve", solve)
    count("threads", threads, 1, MOST_THREADS)
    maps_of = partial(reading.read_all, maps, size=size, unit=unit, dataset=dataset, part=part, periodic=periodic,
                      crop=crop, fill=fill, override_size=override_size)  # fmt: skip
    contact_of = partial(materials.read_interface, material=material, modulus=modulus, poisson=poisson, work=work,
                         contact_modulus=contact_modulus, range=range, spacing=spacing)  # fmt: skip
    read, contact = _both(maps_of, contact_of)
    share = quantities.share(fill)
    found = prediction_of([mending.prepare(one, detrend, fill=share, cutoff=cutoff) for one in read], contact)
    return found.solved(threads) if solve else found


def _both(maps: Callable[[], list[Topography]], contact: Callable[[], Interface]) -> tuple[list[Topography], Interface]:
    """Maps and contact, or the faults of both at once."""
    try:
        read = maps()
    except TopographyError as error:
        try:
            contact()
        except InterfaceError as other:
            msg = f"{error}\n{other}"
            raise TopographyError(msg) from error
        raise
    return read, contact()
