"""Fields over the grid as VTK image data (``.vti``), which ParaView and VTK's other readers open.

VTK File Formats, Kitware, "XML File Formats", ImageData: little-endian numbers in base64, each array with its length in
bytes before it.  The first index, x, changes fastest.
"""

import base64
import re
import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from continuum.model.fourier import Real
from continuum.model.grid import Grid
from continuum.store import output

_TYPES = {"f8": "Float64", "u1": "UInt8"}


def save_contact(
    path: Path, grid: Grid, heights: Real, gap: Real, separation: float, kinds: NDArray[np.uint8], traction: Real | None
) -> Path:
    """Write the fields of a state, with the map of contact and without an unknown traction; returns the path.

    Raises OutputError if it cannot be written.
    """
    fields: dict[str, NDArray[Any]] = {
        "heights": heights,
        "gap": gap,
        "displacement": separation + heights - gap,
        "contact_map": kinds,
    }
    if traction is not None:
        fields["traction"] = traction
    nx, ny = grid.shape
    extent = f"0 {nx - 1} 0 {ny - 1} 0 0"
    arrays = []
    for name, field in fields.items():
        data = np.ascontiguousarray(field.T).astype(field.dtype.newbyteorder("<"))
        coded = base64.b64encode(struct.pack("<Q", data.nbytes) + data.tobytes()).decode()
        kind = _TYPES[re.sub("[<>|=]", "", data.dtype.str)]
        arrays.append(f'<DataArray type="{kind}" Name="{name}" format="binary">{coded}</DataArray>')
    text = "\n".join(
        (
            f'<?xml version="1.0"?>\n<!-- {output.MARK.decode()} -->',
            '<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" header_type="UInt64">',
            f'<ImageData WholeExtent="{extent}" Origin="0 0 0" Spacing="{grid.spacing[0]!r} {grid.spacing[1]!r} 1">',
            f'<Piece Extent="{extent}"><PointData>',
            *arrays,
            "</PointData></Piece></ImageData></VTKFile>\n",
        )
    )
    return output.save(path, text)
