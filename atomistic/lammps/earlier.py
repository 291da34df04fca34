"""Files of an earlier deck in a directory, and its finished steps that a new deck can keep.

A step keeps its result where the new deck reaches it by the same steps: the same atoms, wall and scripts, and the same
numbers of this step and of all before it.  An extended staircase thus continues from its finished steps.
"""

import hashlib
import json
import re
from collections.abc import Mapping
from pathlib import Path

from atomistic.lammps.deck import Deck
from continuum.errors import OutputError

OUTPUTS = re.compile(
    r"(?:result(\.\d+)?\.json)|(?:(?:surface|state)(\.\d+)?\.dump)|(?:log(\.\d+)?\.lammps)|(?:height(\.\d+)?\.txt)"
)
"""Files that a run of the deck writes: of one equilibrium, or of each step with its number."""
PARTS = ("state.part", "result.part")
"""Files that a run leaves when it is killed as it writes them."""
_OF_ALL_STEPS = ("in.contact", "README.txt", "wall.vtk")
"""Texts that name all steps, or only show the wall."""


def step_keys(deck: Deck, texts: Mapping[str, str]) -> list[str]:
    """A hash of each step of a deck and of all before it; one for a single equilibrium."""
    digest = hashlib.sha256("".join(texts[name] for name in sorted({*texts} - {*_OF_ALL_STEPS})).encode())
    for content in deck.model.files.values():
        digest.update(content)
    for array in (deck.heights, deck.start, deck.rest):
        digest.update(array.tobytes())
    protocol, keys = deck.protocol, list[str]()
    for numbers in [(deck.separation,)] if protocol is None else protocol.each_step():
        digest.update(f"{type(protocol).__name__} {numbers!r}".encode())
        keys.append(digest.hexdigest()[:16])
    return keys


def finished_steps(directory: Path) -> tuple[int, ...]:
    """Numbers of the finished steps, in order; (0,) for a single equilibrium."""
    found = (re.fullmatch(r"result(?:\.(\d+))?\.json", entry.name) for entry in Path(directory).iterdir())
    return tuple(sorted(int(name[1] or 0) for name in found if name))


def steps_to_keep(directory: Path, keys: list[str], *, force: bool) -> int:
    """Number of first steps whose results a deck with these keys may keep.

    Raises OutputError if finished steps would be removed, and not ``force``.
    """
    try:
        there = json.loads((directory / "deck.json").read_text(encoding="utf-8"))["step_keys"]
        same = next(
            (i for i, (a, b) in enumerate(zip(keys, there, strict=False)) if a != b), min(len(keys), len(there))
        )
    except (OSError, ValueError, KeyError, TypeError):
        same = 0  # none, damaged, or of an earlier version
    lost = [step for step in finished_steps(directory) if max(step, 1) > same]
    if lost and not force:
        count = f"{len(lost)} finished steps" if len(lost) > 1 else "a finished step"
        raise OutputError(
            f"{directory} has {count} of another deck, which this one would remove\n"
            "    Choose another directory with --output, or remove them with --force"
        )
    return same


def remove_outputs(directory: Path, keep: int = 0) -> None:
    """Remove the outputs of runs of a deck except its first steps; with none to keep, also of a single equilibrium."""
    for entry in Path(directory).iterdir():
        found = OUTPUTS.fullmatch(entry.name)
        step = int(next(filter(None, found.groups()), ".1")[1:]) if found else 0
        if (found and step > keep) or entry.name in PARTS:
            entry.unlink(missing_ok=True)
