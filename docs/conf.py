"""The site: pages of this folder, and a reference made from the code at each build."""

from __future__ import annotations

import dataclasses
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))

import atomistic  # noqa: E402
import continuum  # noqa: E402
from atomistic.config import DeckConfig, ElasticConfig, ValidateConfig  # noqa: E402
from continuum.files.reference import markdown  # noqa: E402
from continuum.runs.config import RunConfig  # noqa: E402
from continuum.runs.record import Point  # noqa: E402

project, author = "stickiness", "the stickiness developers"
release = version = continuum.__version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["_build"]
myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 3
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autoclass_content = "class"
html_theme = "furo"
html_title = "stickiness"
html_static_path: list[str] = []

INPUTS = {
    "run": (RunConfig, "Input of `continuum run`"),
    "validate": (ValidateConfig, "Input of `atomistic validate`"),
    "deck": (DeckConfig, "Input of `atomistic deck`"),
    "elastic": (ElasticConfig, "Input of `atomistic elastic`"),
}


def _columns() -> str:
    """Columns of a stored run, as the file itself says them."""
    rows = [
        f"| `{field.name}` | {field.metadata.get('units') or '-'} | {field.metadata.get('long_name', '')} |"
        for field in dataclasses.fields(Point)
    ]
    head = [
        "# Columns of a stored run",
        "",
        "Each is a dataset over `step` in `NAME.h5`, with its unit as an attribute.",
        "",
    ]
    return "\n".join([*head, "| column | unit | meaning |", "|---|---|---|", *rows, ""])


def _public(package: str, names: list[str]) -> str:
    """The front door, from its docstrings."""
    kinds = [(name, getattr(sys.modules[package], name)) for name in names if name[0] != "_"]
    lines = [f"# Public names of `{package}`", ""]
    for name, value in kinds:
        directive = "autoclass" if isinstance(value, type) else "autofunction" if callable(value) else "autodata"
        members = "\n:members:" if directive == "autoclass" else ""
        lines += [f"## {name}", "", f"```{{eval-rst}}\n.. {directive}:: {package}.{name}{_indented(members)}\n```", ""]
    return "\n".join(lines)


def _indented(text: str) -> str:
    return text.replace("\n", "\n   ")


def _generate(_: object) -> None:
    folder = HERE / "reference"
    folder.mkdir(exist_ok=True)
    pages = {name: markdown(model, title) for name, (model, title) in INPUTS.items()}
    pages |= {"columns": _columns()}
    pages |= {module.__name__: _public(module.__name__, list(module.__all__)) for module in (continuum, atomistic)}
    for name, text in pages.items():
        path = folder / f"{name}.md"
        if not path.exists() or path.read_text() != text:
            path.write_text(text)


def setup(app: object) -> None:
    """Make the reference before the pages are read."""
    app.connect("builder-inited", _generate)  # type: ignore[attr-defined]
