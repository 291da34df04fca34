"""Arrays of numbers from a user's own files: text, npy, HDF5."""

import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from continuum.files.hdf5 import read_array
from continuum.model.fourier import Real

HDF5_SUFFIXES = frozenset({".h5", ".hdf5", ".hdf", ".nc"})


def read_numbers(path: Path, dataset: str | None = None, shape: tuple[int, int] | None = None) -> Real:
    """An array of real numbers, of the given shape if there is one.

    Parameters
    ----------
    path : ``.npy``; HDF5 (``.h5``, ``.hdf5``, ``.hdf``, ``.nc``); anything else is text.
    dataset : name of the dataset in an HDF5 file.
    shape : required shape; binary files are checked before anything is loaded.

    Raises ValueError or OSError if the file is missing, damaged, of another kind, or does not hold real numbers of
    that shape.
    """
    suffix = path.suffix.lower()
    if suffix in HDF5_SUFFIXES:
        return read_array(path, dataset or "", shape)
    if suffix == ".npy":
        # Mapped, so that a header that claims terabytes costs nothing; never pickled.
        try:
            values: NDArray[Any] = np.lib.format.open_memmap(path, mode="r")
        except (ValueError, EOFError) as error:
            raise ValueError(f"{path} is not a plain .npy file, or is truncated ({error})") from error
    else:
        values = read_text(path)
    if shape is not None and values.shape != shape:
        raise ValueError(f"{path} holds an array of shape {values.shape}, the grid has {shape}")
    if values.dtype.kind not in "iuf":
        raise ValueError(f"{path} holds {values.dtype}, not real numbers")
    return np.array(values, dtype=np.float64)


def read_text(path: Path) -> Real:
    """A table of numbers: columns apart by spaces, in ``.csv`` by commas; ``#`` begins a comment.

    Raises ValueError or OSError if the file is missing or is not a table of numbers.
    """
    delimiter = "," if path.suffix.lower() == ".csv" else None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # an empty file: its shape says it
            values: Real = np.loadtxt(path, dtype=np.float64, delimiter=delimiter, ndmin=2, encoding="utf-8-sig")
    except ValueError as error:
        why = str(error).partition("; use `usecols`")[0]  # of a function that the reader did not call
        raise ValueError(f"{path} is not a table of numbers with a point as decimal mark ({why})") from error
    return values
