"""The site: pages of this folder, and a reference made from the code at each build."""

from __future__ import annotations

import re
from pathlib import Path

from docutils import nodes
from latex2mathml.converter import convert
from matplotlib import pyplot as plt
from PIL import Image
from pygments.lexers import TextLexer
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator

import continuum
from docs.from_source import pages


def _style(*_: object) -> None:
    """Each script of the gallery begins in the style of the project; its figures are drawn for a screen."""
    plt.style.use("continuum.show.stickiness")
    plt.rcParams["savefig.dpi"] = 114  # a figure of 7 inches fills the column


HERE = Path(__file__).parent
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
    "image_srcset": ["2x"],
    "show_signature": False,
    "min_reported_time": 10**9,  # seconds: no page shows how long it took on the machine that built it
    "capture_repr": (),
    "reset_modules": (_style,),
}
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
exclude_patterns = ["_build", "gallery", "joss", "reference/gallery/*.ipynb", "reference/gallery/*.py"]
myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 3
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented_params"
autoclass_content = "class"
smartquotes = False  # --set is an option, and "hard" a word of an input
suppress_warnings = ["config.cache"]  # functions in the configuration of the gallery
html_theme = "furo"
html_math_renderer = "mathml"
html_title = "stickiness"
html_show_copyright = False
html_static_path = ["_static"]
html_css_files = ["site.css"]


def _generate(_: object) -> None:
    folder = HERE / "reference"
    folder.mkdir(exist_ok=True)
    for name, text in pages().items():
        path = folder / f"{name}.md"
        if not path.exists() or path.read_text() != text:
            path.write_text(text)


def _described(app: Sphinx, what: str, name: str, thing: object, options: object, lines: list[str]) -> None:
    """Set ``name : description`` as a name and its description: by itself Sphinx reads types there, and links words.

    A paragraph after the list is no parameter: two empty lines end a section.
    """
    if what in ("attribute", "property"):
        lines.insert(0, "")  # the first line would be a type where it has a colon
        return
    rule = lines.index("Parameters") + 2 if "Parameters" in lines else len(lines)
    for i, line in enumerate(lines[rule:], rule):
        if i + 1 < len(lines) and lines[i + 1].startswith("---"):
            break  # the next section
        if found := re.fullmatch(r"(\w[\w, ]*) : (.*)", line):
            lines[i] = f"{found[1]}\n    {found[2]}"
        elif line[:1].strip() and not lines[i - 1]:
            lines[i] = f"\n{line}"
            break
    lines[:] = "\n".join(lines).split("\n")


_SHORTER = {
    r"~?[\w.]*_Buffer \| .*?_NestedSequence\[complex \| bytes \| str\]": "ArrayLike",
    r"~?[\w.]*ndarray\[tuple\[~?[\w.]*Any, \.\.\.\], ~?[\w.]*dtype\[~?(?:numpy\.)?(\w+)\]\]": r"NDArray[\1]",
}


def _unlimited(text: str) -> str:
    """A type without its limits: ``Annotated[float, ...]`` is ``float``."""
    head, found, rest = text.partition("Annotated[")
    if not found:
        return text
    depth, comma = 1, len(rest)
    for i, letter in enumerate(rest):
        depth += (letter in "[(") - (letter in "])")
        if letter == "," and depth == 1:
            comma = min(comma, i)
        if not depth:
            return head + _unlimited(rest[:comma] + rest[i + 1 :])
    return text


def _short(text: str) -> str:
    """A type as the source has it: arrays by their names, numbers without their limits, which the input's page says."""
    for long, short in _SHORTER.items():
        text = re.sub(long, short, text)
    return _unlimited(text)


def _types(app: Sphinx, tree: nodes.document) -> None:
    """Short types of attributes, arguments and results."""
    for node in tree.findall(addnodes.desc_annotation):
        if (short := _short(node.astext())) != node.astext():
            node.clear()
            node += nodes.Text(short)
    for body in tree.findall(nodes.field_body):
        for line in body.findall(nodes.paragraph):
            parts, text = [*line.children], [child.astext() for child in line.children]
            first = text.index(" (") + 1 if " (" in text else 0
            last = text.index(")", first) if first and ")" in text[first:] else len(parts)
            said = "".join(text[first:last])
            if (short := _short(said)) != said:
                line.clear()
                line += [*parts[:first], nodes.Text(short), *parts[last:]]


_MACHINERY = (
    "kinds", "model_config", "constraints", "newer", "renamed", "kind_name", "kind_key", "work_key", "not_identity",
    "example", "restored",
)  # fmt: skip


def _skipped(app: Sphinx, what: str, name: str, thing: object, skip: bool, options: object) -> bool | None:
    """Members that say how a class is made, and nothing to who calls it."""
    return True if name in _MACHINERY else None


def _sized(app: Sphinx, tree: nodes.document) -> None:
    """A figure has the size in which it is printed, or that of the column where this is narrower."""
    for image in tree.findall(nodes.image):
        path = Path(app.srcdir, image["uri"])
        if path.suffix == ".png" and path.is_file() and "width" not in image:
            with Image.open(path) as picture:
                dots = picture.info.get("dpi", (0, 0))[0]
                if dots > 96:  # a picture of a screen says nothing, or 96
                    image["width"] = f"{96 * picture.width / dots:.0f}px"


_SYMBOL = re.compile(
    r"(?<![A-Za-zα-ωΑ-Ω_'′.$])(?:"
    r"(?P<letter>[A-Za-zα-ωΑ-Ωℓ])(?P<prime>['′]{0,2})_(?P<index>[A-Za-z]{1,5}|[0-9])(?![A-Za-z0-9_(*])"  # λ_s, h'_rms
    r"|(?P<slope>[hφτ])(?P<primes>''|['′″])_?(?P<of>rms)?(?![A-Za-z0-9_'′])"  # h'rms, h''
    r"|(?P<modulus>E)\*(?![A-Za-z0-9_*])"
    r"|(?P<unit>[aA])0(?![A-Za-z0-9_]|\.[0-9])"
    r")"
)
"""Symbols as they are written in plain text: λ_s, κ_rep, h'rms, E*, a0."""
_AS_THEY_ARE = (
    nodes.literal, nodes.literal_block, nodes.math, nodes.math_block, nodes.title, nodes.raw, nodes.comment,
    nodes.FixedTextElement, addnodes.desc_signature, addnodes.toctree, nodes.image, nodes.field_name,
)  # fmt: skip


def _formula(found: re.Match[str]) -> str:
    """A symbol in TeX: an index of several letters stands upright."""
    if found["letter"]:
        index = found["index"]
        below = rf"\mathrm{{{index}}}" if len(index) > 1 else index
        return f"{found['letter']}{_primes(found['prime'])}_{{{below}}}"
    if found["slope"]:
        return f"{found['slope']}{_primes(found['primes'])}" + (r"_{\mathrm{rms}}" if found["of"] else "")
    return "E^*" if found["modulus"] else f"{found['unit']}_0"


def _primes(written: str) -> str:
    return written.replace("″", "''").replace("′", "'")


def _symbols(app: Sphinx, tree: nodes.document) -> None:
    """Symbols in plain text are set as mathematics, too."""
    for text in list(tree.findall(nodes.Text)):
        above, held = text.parent, text.astext()
        while above is not None and not isinstance(above, _AS_THEY_ARE):
            above = above.parent
        if above is not None or not _SYMBOL.search(held):
            continue
        parts: list[nodes.Node] = []
        last = 0
        for found in _SYMBOL.finditer(held):
            parts += [nodes.Text(held[last : found.start()]), nodes.math("", _formula(found))]
            last = found.end()
        text.parent.replace(text, [part for part in [*parts, nodes.Text(held[last:])] if part.astext()])


def _unsearched(app: Sphinx, tree: nodes.document) -> None:
    """A search finds the manual and the reference, and not the record of how we know."""
    name = app.env.current_document.docname
    if name.startswith(("studies/", "measured/")) or name == "changes":
        app.env.metadata[name]["nosearch"] = ""


_PRIME = r"\prime "


def _mathml(text: str, display: str = "inline") -> str:
    """A formula as MathML: browsers set it by themselves, where scripts of elsewhere are not loaded, too.

    A prime follows its letter at full size: raised as an exponent it can hardly be seen.
    """
    primed = re.sub(r"(\\[A-Za-z]+|[A-Za-zα-ωΑ-Ω])('+)", lambda found: f"{{{found[1]}{len(found[2]) * _PRIME}}}", text)
    made = convert(primed, display=display)
    found = re.sub(r"<mi>(&#x02032;)</mi>", r'<mo class="prime" lspace="0" rspace="0">\1</mo>', made)
    return found.replace("<mo>&#x0002F;</mo>", '<mo lspace="0" rspace="0">&#x0002F;</mo>')


def _inline(writer: HTML5Translator, node: nodes.math) -> None:
    writer.body.append(f"{_mathml(node.astext())}&#8288;")  # a comma behind it begins no line
    raise nodes.SkipNode


def _block(writer: HTML5Translator, node: nodes.math_block) -> None:
    writer.body.append(f'<div class="math">{_mathml(node.astext(), "block")}</div>\n')
    raise nodes.SkipNode


def setup(app: Sphinx) -> None:
    """Make the reference before the pages are read, and descriptions before the sections of docstrings are."""
    app.add_html_math_renderer("mathml", inline_renderers=(_inline, None), block_renderers=(_block, None))
    app.add_lexer("lammps", TextLexer)  # Pygments has none: scripts are shown as they are
    app.connect("builder-inited", _generate)
    app.connect("autodoc-process-docstring", _described, priority=400)
    app.connect("autodoc-skip-member", _skipped)
    app.connect("doctree-read", _types)
    app.connect("doctree-read", _sized)
    app.connect("doctree-read", _symbols)
    app.connect("doctree-read", _unsearched)
