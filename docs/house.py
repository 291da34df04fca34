"""The rooms of both packages, from the sources: a drawing of what they import, and tables of what they hold.

``python -m docs.house`` makes the drawing, and the tables of docs/house.md.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Mapping
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.figure import Figure

ROOT = Path(__file__).parents[1]
PACKAGES = "continuum", "atomistic"
MODULES = sorted(path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))
DRAWING = Path(__file__).with_name("house.svg")
APART = 1.7
"""Distance of two rooms of one level."""
PAGE = Path(__file__).with_name("house.md")
BEGIN, END = "<!-- made by python -m docs.house -->\n", "<!-- end -->\n"
COLOURS = {"continuum": "#dbe9f6", "atomistic": "#fde3c8"}
Rooms = Mapping[str, set[str]]
"""The rooms that each room imports directly, as "continuum.path"."""


@cache
def imports(path: Path) -> tuple[str, ...]:
    """Names of the modules that a file imports, at its top or anywhere in it."""
    tree, found = ast.parse(path.read_text()), list[str]()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            found += [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
    return tuple(found)


def rooms() -> Rooms:
    """The subpackages and modules at the top of each package, with those that they import."""
    found: dict[str, set[str]] = {}
    for path in MODULES:
        parts = path.relative_to(ROOT).with_suffix("").parts[:2]
        if not parts[1].startswith("__"):
            found.setdefault(".".join(parts), set()).update(".".join(name.split(".")[:2]) for name in imports(path))
    return {room: {one for one in asked if one in found and one != room} for room, asked in found.items()}


def below(graph: Rooms, room: str) -> set[str]:
    """All rooms that a room imports, directly or through others."""
    return graph[room].union(*(below(graph, one) for one in graph[room]))


def reduced(graph: Rooms) -> Rooms:
    """The graph without the arrows that follow from others."""
    return {
        room: {one for one in asked if not any(one in below(graph, other) for other in asked)}
        for room, asked in graph.items()
    }


def levels(graph: Rooms) -> dict[str, int]:
    """Height of each room: above all that it imports, and no farther below those that import it than these need."""
    found: dict[str, int] = {}
    for room in TopologicalSorter(graph).static_order():
        found[room] = 1 + max((found[one] for one in graph[room]), default=-1)
    for room in reversed(list(TopologicalSorter(graph).static_order())):
        found[room] = min((found[one] - 1 for one, asked in graph.items() if room in asked), default=found[room])
    return found


def places(graph: Rooms) -> dict[str, tuple[float, int]]:
    """Where each room is drawn: beside those of its level, near what it imports and what imports it."""
    height = levels(graph)
    rows = [
        [room for room in sorted(graph) if height[room] == level and room.startswith(package)]
        for package in PACKAGES
        for level in sorted(set(height.values()))
    ]
    x = {room: APART * (i - (len(row) - 1) / 2) for row in rows for i, room in enumerate(row)}
    for _ in range(50):
        for row in rows:
            beside = {
                room: [x[one] for one in graph if one.split(".")[0] == room.split(".")[0]
                       and (one in graph[room] or room in graph[one])]
                for room in row
            }  # fmt: skip
            wanted = {room: float(np.mean(values or [x[room]])) for room, values in beside.items()}
            row.sort(key=lambda room: (wanted[room], room))
            middle = float(np.mean(list(wanted.values()))) if row else 0.0
            x |= {room: middle + APART * (i - (len(row) - 1) / 2) for i, room in enumerate(row)}
    # The second package stands to the right of the first on every level.
    left, right = ([room for room in graph if room.startswith(package)] for package in PACKAGES)
    aside = max(x[one] + APART - x[room] for one in left for room in right if height[one] == height[room])
    return {room: (x[room] + (aside if room in right else 0.0), height[room]) for room in graph}


def edges(graph: Rooms) -> str:
    """All arrows of a graph, as text."""
    return "; ".join(f"{room} -> {one}" for room in sorted(graph) for one in sorted(graph[room]))


def drawn(graph: Rooms) -> Figure:
    """The rooms as boxes, those that import others above them, and the arrows that do not follow from others."""
    shown = reduced(graph)
    place = places(shown)
    figure = Figure(figsize=(7.4, 9.0), layout="constrained")
    axes = figure.add_subplot()
    boxes = {
        room: axes.text(
            *place[room], room.split(".")[1], ha="center", va="center", fontsize=10, zorder=3,
            bbox={"boxstyle": "round,pad=0.2", "facecolor": COLOURS[room.split(".")[0]], "edgecolor": "0.3"},
        )
        for room in shown
    }  # fmt: skip
    for room, asked in shown.items():
        for one in sorted(asked):  # a set has another order in each process
            same = room.split(".")[0] == one.split(".")[0]
            axes.annotate(
                "", place[one], place[room], zorder=1,
                arrowprops={"arrowstyle": "-|>", "color": "0.35" if same else "0.7", "lw": 1.1, "mutation_scale": 11,
                            "patchA": boxes[room].get_bbox_patch(), "patchB": boxes[one].get_bbox_patch(),
                            "shrinkA": 0, "shrinkB": 1},
            )  # fmt: skip
    across, up = zip(*place.values(), strict=True)
    axes.set(xlim=(min(across) - 0.6, max(across) + 0.65), ylim=(min(up) - 0.4, max(up) + 1.0))
    for package in PACKAGES:
        middle = np.mean([at[0] for room, at in place.items() if room.startswith(package)])
        axes.text(middle, max(up) + 0.7, package, ha="center", fontsize=15, weight="bold")
    axes.axis("off")
    return figure


def tables() -> str:
    """Tables of the rooms of each package, with the first line of each room's docstring."""
    found = []
    for package in PACKAGES:
        rows = [
            (
                room.partition(".")[2],
                ast.get_docstring(ast.parse((ROOT / room.replace(".", "/") / "__init__.py").read_text())),
            )
            for room in sorted(rooms())
            if room.startswith(f"{package}.")
        ]
        said = (
            (room, re.sub(r":\w+:`([^`]*)`|``([^`]*)``", r"`\1\2`", (text or "").splitlines()[0]))
            for room, text in rows
        )
        found.append(f"| `{package}/` | |\n|---|---|\n" + "".join(f"| `{room}` | {line} |\n" for room, line in said))
    return "\n".join(found)


def on_page() -> str:
    """The tables as they stand on the page."""
    return PAGE.read_text().partition(BEGIN)[2].partition(END)[0]


if __name__ == "__main__":
    found = rooms()
    before, _, rest = PAGE.read_text().partition(BEGIN)
    PAGE.write_text(f"{before}{BEGIN}{tables()}{END}{rest.partition(END)[2]}")
    with plt.rc_context({"svg.hashsalt": "house", "svg.fonttype": "none", "font.family": "sans-serif"}):
        drawn(found).savefig(DRAWING, metadata={"Date": None, "Description": edges(found)})
