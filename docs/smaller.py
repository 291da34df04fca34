"""Make the figures of the pages small: ``python -m docs.smaller`` writes each PNG with a palette of 256 colours.

Matplotlib writes four bytes a point, of which a figure of lines and symbols needs one.  The most frequent colours stay
as they are, the others change by less than the eye sees.
"""

from __future__ import annotations

import io
import sys
from pathlib import Path

import numpy as np
from PIL import Image, PngImagePlugin
from scipy.spatial import cKDTree

HERE = Path(__file__).parent
KEPT = 64
"""Colours that are kept, the most frequent ones; the rest of the palette is shared by all others."""


def figures() -> list[Path]:
    """All of the pages, without those that are drawn with the site."""
    return [path for path in sorted(HERE.rglob("*.png")) if "reference" not in path.relative_to(HERE).parts]


def small(picture: Image.Image) -> bytes:
    """A picture with a palette, with its resolution and its texts."""
    flat = picture.convert("RGB")
    codes = np.asarray(flat).astype(np.uint32) @ np.array([65536, 256, 1], dtype=np.uint32)
    coded, which, count = np.unique(codes, return_inverse=True, return_counts=True)
    colours = np.stack([coded >> 16, coded >> 8 & 255, coded & 255], axis=-1)
    palette = colours[np.argsort(-count, kind="stable")[:KEPT]]
    if len(colours) > KEPT:
        shared = flat.quantize(256 - KEPT, method=Image.Quantize.FASTOCTREE).getpalette() or []
        palette = np.concatenate([palette, np.reshape(shared, (-1, 3))])
    nearest = cKDTree(palette).query(colours)[1].astype(np.uint8)
    found = Image.fromarray(nearest[which].reshape(flat.height, flat.width), "P")
    found.putpalette(palette.astype(np.uint8).tobytes())
    said, written = PngImagePlugin.PngInfo(), io.BytesIO()
    for name, text in getattr(picture, "text", {}).items():
        said.add_itxt(name, text)
    found.save(
        written, "png", optimize=True, pnginfo=said, **{k: picture.info[k] for k in ("dpi",) if k in picture.info}
    )
    return written.getvalue()


def main() -> None:
    """Rewrite the figures that have no palette yet, where that makes them smaller."""
    for path in figures():
        with Image.open(path) as picture:
            made = b"" if picture.mode == "P" else small(picture)
        if made and len(made) < path.stat().st_size:
            sys.stdout.write(f"{path.relative_to(HERE)}: {path.stat().st_size} to {len(made)} bytes\n")
            path.write_bytes(made)


if __name__ == "__main__":
    main()
