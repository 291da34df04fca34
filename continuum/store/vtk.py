"""Fields over the grid as VTK image data (``.vti``), which ParaView and VTK's other readers open.

VTK File Formats, Kitware, "XML File Formats", ImageData: little-endian numbers in base64, each array with its length in
bytes before it.  The first index, x, changes fastest.
"""

import base64
import re
import struct
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from continuum.model.grid import Grid
from continuum.store import output

_TYPES = {"f8": "Float64", "u1": "UInt8"}


def save_image(path: Path, grid: Grid, fields: Mapping[str, NDArray[np.float64] | NDArray[np.uint8]]) -> Path:
    """Write fields, shape ``grid.shape`` each, by name, as points of one image; returns its path.

    Raises OutputError if it cannot be written.
    """
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
