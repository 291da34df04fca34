"""Make the figures of the pages small: ``python -m docs.smaller`` writes each PNG with a palette of 256 colours.

Matplotlib writes four bytes a point, of which a figure of lines and symbols needs one.
"""

from __future__ import annotations

import io
import sys
from pathlib import Path

from PIL import Image, PngImagePlugin

HERE = Path(__file__).parent


def figures() -> list[Path]:
    """All of the pages, without those that are drawn with the site."""
    return [path for path in sorted(HERE.rglob("*.png")) if "reference" not in path.relative_to(HERE).parts]


def small(picture: Image.Image) -> bytes:
    """A picture with a palette, with its resolution and its texts."""
    # The one of Pillow's methods that keeps white and, of three figures, changed no colour by more than 19 of 255.
    found = picture.convert("RGB").quantize(256, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
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
