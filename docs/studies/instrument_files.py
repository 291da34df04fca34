"""Which files of a folder are read as height maps: `python -m docs.studies.instrument_files FOLDER`.

For the test files of SurfaceTopography (test/file_format_examples in its repository).  What a file does not say, its
size, unit, or which of its maps is meant, is given when it is asked for, as a user would.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

from continuum.errors import InputError
from continuum.sheet import Sheet
from continuum.topography.reading import read_all

GIVEN = ({}, {"size": "1um"}, {"unit": "nm"}, {"size": "1um", "unit": "nm"}, {"unit": "um,nm"})
"""What is given, one after the other, until the file is read."""


def outcome(path: Path) -> tuple[str, str]:
    """Whether and how a file is read, and what was said last of one that is not."""
    parts, said = [{}], []
    for part in parts:
        for more in ({}, {"fill": "50%"}):
            for given in GIVEN:
                try:
                    (found,) = read_all([path], **given, **more, **part)
                except InputError as error:
                    said.append(str(error).replace(str(path), path.name).splitlines()[0])
                else:
                    asked = " ".join({**given, **more, **part})
                    shape = " x ".join(map(str, found.heights.shape))
                    return ("read", shape) if not asked else ("read when asked", f"{asked}: {shape}")
        named = re.search(r"maps: '([^']+)'", said[-1])
        if named and not part:
            parts += [{"part": named[1]}, {"part": "all"}]
        several = re.search(r"datasets: (\w+)", said[-1])
        if several and not part:
            parts.append({"dataset": several[1]})
    return "refused", min(said[::-1], key=lambda text: "does not say" in text or "but it has no positions" in text)


def main() -> None:
    """Read every file of the folder."""
    rows = [(path.name, *outcome(path)) for path in sorted(Path(sys.argv[1]).iterdir())]
    for word in ("read", "read when asked", "refused"):
        sys.stdout.write(f"{word}: {sum(row[1] == word for row in rows)}\n")
    sys.stdout.write(Sheet.of("files", ("file", "", "what was said or given"), rows).markdown() + "\n")


if __name__ == "__main__":
    main()
