"""Values of keys that are given in Python, instead of those of an input file."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import numpy as np

from continuum.arguments import ArgumentError


def settings_of(given: Any) -> dict[str, Any]:
    """Dotted keys and their values as a file has them: NumPy's numbers and arrays become plain numbers and lists.

    Raises ArgumentError if it is no mapping of names to values.
    """
    if given is None:
        return {}
    if not isinstance(given, Mapping) or not all(isinstance(key, str) for key in given):
        raise ArgumentError("settings", given, 'a mapping of keys to values, such as {"surface.seed": 3}')
    return {key: _plain(value) for key, value in given.items()}


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    return list(map(_plain, value)) if isinstance(value, list | tuple | range) else value
