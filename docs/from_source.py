"""Pages of the reference, made from the source at each build of the site: keys, options, columns, exit codes, names.

What a page lacks is mended in the source: a description says the unit of its value, "in a0", or that it is a pure
number, and :func:`continuum.inputs.reference.unit_said` reads it there.
"""

from __future__ import annotations

import tempfile
import tomllib
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import atomistic as a
import atomistic.front.cli
import continuum as c
import continuum.front.cli
from atomistic.inputs.crystal import ElasticConfig
from atomistic.inputs.deck import DeckConfig
from atomistic.inputs.validate import ValidateConfig
from atomistic.relax.deckrun import SCHEMA, VERSION
from continuum.inputs.errors import EXIT_CODES
from continuum.inputs.reference import markdown
from continuum.inputs.toml import Document
from continuum.maps.verdict.tables import PredictionInput
from continuum.store.datasets import Dataset, read_datasets
from continuum.store.runs.config import RunConfig
from continuum.store.sheet import Sheet
from continuum.store.sweeps.axes import SweepInput
from continuum.store.sweeps.bisection import KEYS
from continuum.store.sweeps.measured import COLUMNS
from docs.materials import table

HERE = Path(__file__).parent
INPUTS: Mapping[str, tuple[type[Document], str]] = {
    "run": (RunConfig, "Input of `continuum run`"),
    "sweep": (SweepInput, "Input of `continuum sweep run`"),
    "predict": (PredictionInput, "Input of `continuum predict`"),
    "validate": (ValidateConfig, "Input of `atomistic validate`"),
    "deck": (DeckConfig, "Input of `atomistic deck`"),
    "elastic": (ElasticConfig, "Input of `atomistic elastic`"),
}
"""Inputs by the names of their pages, with their headings."""

_RUN = """
[grid]
n = 8
[surface]
kind = "sine"
amplitude = 0.2
waves = [1, 1]
[wall]
{wall}
[substrate]
response = "half-space"
mean = "clamped"
[loading]
control = "mean-pressure"
targets = [0.01]
event_resolution = 0.01
[output]
fields = true
"""
_VALIDATION = """
[interatomic]
kind = "springs"
[slab]
n = 8
depth = 4
[surface]
hurst = 0.8
lambda_s = 4
lambda_L = 8
seeds = [1]
[[case]]
name = "one"
adhesion_length = 0.0
rms_slopes = [0.1]
areas = [0.1]
"""


def stored() -> dict[str, dict[str, Dataset]]:
    """What the files of a run, a deck and a validation hold: each is made, the smallest that there is, and read."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        table, adhesive, hard = folder / "table.txt", folder / "adhesive.toml", folder / "hard.toml"
        table.write_text("0.5 1.0\n1.0 0.0\n1.5 -0.1\n2.0 0.0\n")
        adhesive.write_text(_RUN.format(wall='law = "table"\npath = "table.txt"'))
        hard.write_text(_RUN.format(wall='law = "hard"\nhardness = 0.1'))
        runs = [c.run(one, folder).path for one in (adhesive, hard)]
        contact = c.Contact(c.sine(c.Grid.square(8), 0.1, (1, 1)), wall=c.LennardJonesSpline(0.0))
        deck = a.run_deck(a.deck(contact, a.Springs(), separation=0.9).write(folder / "deck"))
        deck.store(folder / "deck.h5", deck.compare())
        (folder / "validation.toml").write_text(_VALIDATION)
        path = a.validate(folder / "validation.toml", folder, workers=1).path
        run, check = ((one.result_schema, one.result_version) for one in (RunConfig, ValidateConfig))
        files = [(one, *run) for one in runs] + [(folder / "deck.h5", SCHEMA, VERSION), (path, *check)]
        first, second, ran, checked = (read_datasets(*file, labels=True).datasets for file in files)
        return {"run": first | second, "deck": ran, "validation": checked}


_FILES = {
    "run": (
        "A stored run",
        "`continuum run`, a system of a sweep: `NAME.h5`. The contact maps take a bit a cell and are packed; one call"
        " unpacks that of a step, an array of 2 (repulsive), 1 (attracted) and 0 (out of range):\n\n"
        "```python\nimport continuum as c\n\n"
        'c.Result.read("results/path.h5").contact_map(1)\n```\n\n'
        "`to_xarray()` of the same object has points, maps and fields with named axes, and `c.sweep_maps(folder)` those"
        " of all systems of a sweep; a map is read when it is used. `gap` and `heights` are there with `[output]"
        " fields`, `imprint` under a wall that yields, `wall/` of a law that is a table, `events/` with jumps, `work/`"
        " where a solve used several grids, `restart/` as long as a path can go on from it.",
    ),
    "deck": (
        "A deck that was run",
        "`atomistic read DIR`: `NAME.h5`; `continuum/` with `--compare`. A step is an equilibrium, or the mean over a"
        " time window.",
    ),
    "validation": (
        "A validation",
        "`atomistic validate`: `NAME.h5`. A rung is a model of the ladder, a state one comparison. Differences begin"
        " with the name of the step of the [budget](../tutorials/validate.md) that they belong to.",
    ),
}


def columns() -> str:
    """Datasets of stored files and columns of tables, with their units, as the files themselves say them."""
    parts = ["# What is stored", "", "Each dataset has its unit and its meaning as attributes, too."]
    for name, found in stored().items():
        title, about = _FILES[name]
        rows = [
            (f"`{key}`", one.long_name, one.units or "–", ", ".join(f"`{dim}`" for dim in one.dims))
            for key, one in sorted(found.items(), key=lambda item: ("/" in item[0], item[0]))
        ]
        parts += ["", f"## {title}", "", about, "", _table(("dataset", "meaning", "unit", "over"), rows)]
    about = (
        "`continuum sweep collect`: `table.csv`, and `table.h5` with one dimension for each axis. Before these columns"
        " stand `system`, the keys on the axes, and after them columns of one's own. `load` is called `load_net` in"
        " `table.h5` and in datasets of xarray, which have a method `load`; `table.csv` and files of runs have `load`."
    )
    return "\n".join([*parts, "", "## The table of a sweep", "", about, "", table_of_a_sweep(), ""])


def table_of_a_sweep() -> str:
    """Columns of the table of all points of a sweep."""
    rows = [(f"`{name}`", what, unit or "–") for name, (unit, what) in COLUMNS.items()]
    return _table(("column", "meaning", "unit"), rows)


def _table(head: Sequence[str], rows: Sequence[tuple[str, ...]]) -> str:
    return Sheet.of("", head, rows).markdown()


def exit_codes() -> str:
    """With which codes both programs end."""
    rows = [(str(code), meaning) for code, meaning in EXIT_CODES.items()]
    about = (
        "Every command of `continuum` and `atomistic` ends with one of these codes. In every case but 2 `run`,"
        " `threshold`, `sweep run`, `sweep collect`, `validate` and `deck` have stored their finished work; after a"
        " signal the same command continues. `kill` and queues send SIGTERM; a pipe closes when its reader, such as"
        " `head`, ends."
    )
    return f"# Exit codes\n\n{about}\n\n{_table(('code', 'meaning'), rows)}\n"


def inputs() -> dict[str, str]:
    """Every key of every table, a page for each input."""
    found = {name: markdown(model, title) for name, (model, title) in INPUTS.items()}
    rows = [(f"`{name}`", meaning) for name, meaning in KEYS.items()]
    about = "A key of `[sweep.axes]` whose value is a table with `bisect` is searched for."
    found["sweep"] += f"\n## A search\n\n{about}\n\n{_table(('key', 'meaning'), rows)}\n"
    return found


def commands(program: str) -> str:
    """Every command of a program with its arguments and options, as its help has them."""
    app = {"continuum": continuum.front.cli.app, "atomistic": atomistic.front.cli.app}[program]
    # Started as a module, as by `python -m sphinx`, cyclopts adds the module's name to some usages.
    made = app.generate_docs(usage_name=program).replace(" -m sphinx ", " ")
    return made.replace(f"# {program}\n", f"# Commands of `{program}`\n", 1)


def public(package: str, groups: Sequence[Mapping[str, Any]]) -> str:
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
            # Members of these are machinery of libraries and of inputs.
            without = "BaseException, Table, Description, BaseModel, tuple, Sequence, Calculator, Optimizer"
            members = f"\n   :members:\n   :inherited-members: {without}" if directive == "autoclass" else ""
            text = f".. {directive}:: {package}.{name}{members}"
            lines += [f"### {name}", "", f"```{{eval-rst}}\n{text}\n```", ""]
    return "\n".join(lines)


def pages() -> dict[str, str]:
    """All pages of the reference, by their names."""
    groups = tomllib.loads((HERE / "reference.toml").read_text())
    return {
        **inputs(),
        "columns": columns(),
        "exit-codes": exit_codes(),
        "materials": table(),
        **{f"{program}-commands": commands(program) for program in groups},
        **{package: public(package, found) for package, found in groups.items()},
    }
