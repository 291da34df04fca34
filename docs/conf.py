"""The site: pages of this folder, and a reference made from the code at each build."""

from __future__ import annotations

import dataclasses
import re
import tomllib
from importlib import import_module
from pathlib import Path
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from matplotlib import pyplot as plt
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator

import continuum
from atomistic.config.crystal import ElasticConfig
from atomistic.config.deck import DeckConfig
from atomistic.config.validate import ValidateConfig
from continuum.errors import EXIT_CODES
from continuum.files.reference import markdown
from continuum.runs.config import RunConfig
from continuum.runs.record import Point
from docs.materials import table


def _style(*_: object) -> None:
    """Each script of the gallery begins in the style of the project."""
    plt.style.use("continuum.show.stickiness")


HERE = Path(__file__).parent
GROUPS = HERE / "reference.toml"
project, author = "stickiness", "the stickiness developers"
release = version = continuum.__version__
extensions = [
    "myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode", "sphinx_gallery.gen_gallery",
]  # fmt: skip
sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "reference/gallery",
    "filename_pattern": r"\.py",
    "within_subsection_order": "FileNameSortKey",
    "write_computation_times": False,
    "download_all_examples": False,
    "show_signature": False,
    "min_reported_time": 60,
    "reset_modules": (_style,),
}
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
exclude_patterns = ["_build", "gallery", "reference/gallery/*.ipynb", "reference/gallery/*.py"]
myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 3
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autoclass_content = "class"
suppress_warnings = ["config.cache"]  # functions in the configuration of the gallery
html_theme = "furo"
html_math_renderer = "mathml"
html_title = "stickiness"
html_show_copyright = False
html_static_path = ["_static"]
html_css_files = ["site.css"]

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
        "The contact maps take a bit a cell and are packed; one call unpacks that of a step, an array of 2 (repulsive),"
        " 1 (attracted) and 0 (out of range):",
        "",
        "```python",
        "import continuum as c",
        "",
        'c.Result.read("results/path.h5").contact_map(1)',
        "```",
        "",
        "`to_xarray()` of the same object opens the whole file with named axes; it needs the extra `xarray`:",
        "`pip install 'stickiness[xarray]'`.",
        "",
    ]
    return "\n".join([*head, "| column | unit | meaning |", "|---|---|---|", *rows, ""])


def _exit_codes() -> str:
    """With which codes both programs end."""
    rows = [f"| {code} | {meaning} |" for code, meaning in EXIT_CODES.items()]
    head = [
        "# Exit codes",
        "",
        "Of `continuum` and of `atomistic`, whatever the command.",
        "",
        "| code | meaning |",
        "|---|---|",
    ]
    return "\n".join([*head, *rows, ""])


def _public(package: str, groups: list[dict[str, Any]]) -> str:
    """The front door by what one does, from its docstrings."""
    lines = [f"# Public names of `{package}`", ""]
    for group in groups:
        names = ", ".join(f"{{py:obj}}`{name} <{package}.{name}>`" for name in group["names"])
        lines += [f"* {group['title']}: {names}"]
    for group in groups:
        lines += ["", f"## {group['title']}", "", group["says"], ""]
        for name in group["names"]:
            value = getattr(import_module(package), name)
            directive = "autoclass" if isinstance(value, type) else "autofunction" if callable(value) else "autodata"
            members = (
                "\n:members:\n:inherited-members: BaseException, BaseModel, tuple, Calculator, Optimizer"
                if directive == "autoclass"
                else ""
            )
            text = f".. {directive}:: {package}.{name}{_indented(members)}"
            lines += [f"### {name}", "", f"```{{eval-rst}}\n{text}\n```", ""]
    return "\n".join(lines)


def _indented(text: str) -> str:
    return text.replace("\n", "\n   ")


def _generate(_: object) -> None:
    folder = HERE / "reference"
    folder.mkdir(exist_ok=True)
    pages = {name: markdown(model, title) for name, (model, title) in INPUTS.items()}
    pages |= {"columns": _columns(), "exit-codes": _exit_codes(), "materials": table()}
    pages |= {package: _public(package, groups) for package, groups in tomllib.loads(GROUPS.read_text()).items()}
    for name, text in pages.items():
        path = folder / f"{name}.md"
        if not path.exists() or path.read_text() != text:
            path.write_text(text)


def _described(app: Sphinx, what: str, name: str, thing: object, options: object, lines: list[str]) -> None:
    """Set ``name : description`` as a name and its description: by itself Sphinx reads types there, and links words."""
    rule = lines.index("Parameters") + 2 if "Parameters" in lines else len(lines)
    for i, line in enumerate(lines[rule:], rule):
        if i + 1 < len(lines) and lines[i + 1].startswith("---"):
            break  # the next section
        if found := re.fullmatch(r"(\w[\w, ]*) : (.*)", line):
            lines[i] = f"{found[1]}\n    {found[2]}"
    lines[:] = "\n".join(lines).split("\n")


def _inline(writer: HTML5Translator, node: nodes.math) -> None:
    """A formula as MathML: browsers set it by themselves, where scripts of elsewhere are not loaded, too."""
    writer.body.append(convert(node.astext()))
    raise nodes.SkipNode


def _block(writer: HTML5Translator, node: nodes.math_block) -> None:
    writer.body.append(f'<div class="math">{convert(node.astext(), display="block")}</div>\n')
    raise nodes.SkipNode


def setup(app: Sphinx) -> None:
    """Make the reference before the pages are read, and descriptions before the sections of docstrings are."""
    app.add_html_math_renderer("mathml", inline_renderers=(_inline, None), block_renderers=(_block, None))
    app.connect("builder-inited", _generate)
    app.connect("autodoc-process-docstring", _described, priority=400)
