"""Points of a path as a table of pandas."""

from collections.abc import Sequence
from dataclasses import fields
from typing import Any

import pandas


def frame_of(points: Sequence[Any], kind: type) -> pandas.DataFrame:
    """One row for each point, with the stored fields of a class that all have, and ``status``.

    ``attrs["units"]`` has the unit of each column.
    """
    columns = [one for one in fields(kind) if one.metadata and one.name != "status"]
    rows = [[*(getattr(point, one.name) for one in columns), _status(point)] for point in points]
    frame = pandas.DataFrame(rows, columns=[*(one.name for one in columns), "status"])
    frame.index.name = "step"
    frame.attrs["units"] = {one.name: one.metadata["units"] for one in columns}
    return frame


def _status(point: Any) -> str:
    """The word of the status, of a point of a file and of a state alike."""
    return str(getattr(point.status, "name", point.status))
