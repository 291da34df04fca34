"""A sheet: a table with units, as text, Markdown, HTML or CSV; also that of the quantities of a certificate."""

from __future__ import annotations

import csv
import html
import io
import math
import textwrap
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import groupby, zip_longest
from typing import Self, TextIO

from continuum.measure.certificate import Examination

Entry = str | float | int | None
"""Contents of a cell; None for an empty one."""
_FORMULA = ("=", "+", "-", "@", "\t")
"""First characters with which spreadsheets begin a formula; names of files and samples are the user's."""
MOST = 20
"""Rows of a list that a terminal shows."""
WIDEST = 120
"""Characters in a line of a printed table; a single word that is longer, as the name of a file, is not cut."""


@dataclass(frozen=True)
class Column:
    """A column of a sheet.

    Parameters
    ----------
    name : word or symbol of the quantity.
    unit : "a0", "E*", "%" (of numbers that are fractions); "" where there is none.
    form : Python format of the numbers; words are not changed.
    """

    name: str
    unit: str = ""
    form: str = ".4g"

    @property
    def head(self) -> str:
        return f"{self.name} ({self.unit})" if self.unit and self.unit != "%" else self.name

    def text(self, cell: Entry) -> str:
        if cell is None or (isinstance(cell, float) and math.isnan(cell)):
            return "-"
        if isinstance(cell, str | bool):
            return str(cell)
        if self.unit == "%":
            return f"{100 * cell:{self.form}} %"
        return str(cell) if isinstance(cell, int) else f"{cell:{self.form}}"


def duration(seconds: float) -> str:
    """A time with the few digits of an estimate."""
    for size, unit in ((86400, "d"), (3600, "h"), (60, "min")):
        if seconds >= 2 * size:
            return f"{seconds / size:.0f} {unit}"
    return f"{seconds:.0f} s"


class Shown:
    """Object that a notebook shows as its sheets, one below the other."""

    def sheets(self) -> list[Sheet]:
        """The sheets, in their order."""
        raise NotImplementedError

    def _repr_html_(self) -> str:
        return "".join(sheet._repr_html_() for sheet in self.sheets())


@dataclass(frozen=True)
class Sheet:
    """A table with named columns, as text, HTML and CSV.

    Parameters
    ----------
    title : one line.
    columns : in their order; a text is a column of that name.
    rows : rows with one cell for each column.
    note : explanation below the table.
    """

    title: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Entry, ...], ...]
    note: str = ""

    @classmethod
    def of(cls, title: str, columns: Sequence[Column | str], rows: Iterable[Sequence[Entry]], note: str = "") -> Self:
        """A sheet from any sequences.

        Raises ValueError if the number of cells in a row differs from that of columns.
        """
        heads = tuple(Column(column) if isinstance(column, str) else column for column in columns)
        body = tuple(map(tuple, rows))
        wrong = next((row for row in body if len(row) != len(heads)), None)
        if wrong is not None:
            raise ValueError(f"{title}: a row of {len(wrong)} cells under {len(heads)} columns: {wrong}")
        return cls(title, heads, body, note)

    @property
    def head(self) -> tuple[str, ...]:
        return tuple(column.head for column in self.columns)

    @property
    def cells(self) -> tuple[tuple[str, ...], ...]:
        return tuple(
            tuple(column.text(cell) for column, cell in zip(self.columns, row, strict=True)) for row in self.rows
        )

    def numeric(self, index: int) -> bool:
        """Whether a column has numbers only, which are aligned to the right."""
        return any(isinstance(row[index], float | int) for row in self.rows) and not any(
            isinstance(row[index], str) for row in self.rows
        )

    def laid_out(self, width: int = WIDEST) -> list[list[list[str]]]:
        """The head and each row as lists of lines of each cell, so that a printed row has a width in characters.

        Two spaces stand between columns.  What is too wide is broken between words: heads first, then the widest texts.
        Numbers are never broken, nor are words, so that many columns or long words may need more.
        """
        head, cells = self.head, self.cells
        lines = [list(column) for column in zip(*cells, strict=True)] or [[] for _ in head]
        heads = [max(map(len, _apart(name).split()), default=1) for name in head]
        words_of = [
            max(map(len, column if self.numeric(i) else " ".join(column).split()), default=1)
            for i, column in enumerate(lines)
        ]
        # As wide as the cells, if a head broken between its words allows it.
        whole = [max(a, *map(len, column), 1) for a, column in zip(heads, lines, strict=True)]
        widths = [max(map(len, (name, *column))) for name, column in zip(head, lines, strict=True)]
        for least in (whole, [max(a, b) for a, b in zip(heads, words_of, strict=True)]):
            while sum(widths) + 2 * (len(head) - 1) > width and any(a > b for a, b in zip(widths, least, strict=True)):
                widths[max(range(len(head)), key=lambda i: (widths[i] > least[i], widths[i]))] -= 1
        names = [name if len(name) <= wide else _apart(name) for name, wide in zip(head, widths, strict=True)]
        return [
            [_wrapped(cell, wide) if len(cell) > wide else [cell] for cell, wide in zip(row, widths, strict=True)]
            for row in (names, *cells)
        ]

    def text(self, width: int = WIDEST) -> str:
        """Plain text of this width, with two spaces between columns."""
        rows = self.laid_out(width)
        numeric = [self.numeric(i) for i in range(len(self.columns))]
        widths = [max(len(line) for row in rows for line in row[i]) for i in range(len(self.columns))]
        lines = [
            "  ".join(
                cell.rjust(width) if number else cell.ljust(width)
                for cell, width, number in zip(line, widths, numeric, strict=True)
            ).rstrip()
            for row in rows
            for line in zip_longest(*row, fillvalue="")
        ]
        title = _wrapped(self.title, width) or [self.title]
        return "\n".join([*title, *lines, *self.notes(width)])

    def notes(self, width: int = WIDEST) -> list[str]:
        """The explanation in lines of this width."""
        return [line for one in self.note.splitlines() for line in _wrapped(one, width) or [""]]

    def markdown(self) -> str:
        """A table of Markdown, without the title."""
        lines = [self.head, ("---",) * len(self.columns), *self.cells]
        return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)

    def html(self) -> str:
        """A table of HTML; title and note are left to the page."""
        head = "".join(f"<th>{html.escape(name)}</th>" for name in self.head)
        body = "".join(
            "<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in self.cells
        )
        return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"

    def csv(self) -> str:
        """The text that :func:`write_csv` writes."""
        out = io.StringIO()
        write_csv(out, self.head, self.rows)
        return out.getvalue()

    def beginning(self) -> Self:
        """The first rows, as many as a terminal shows."""
        more = len(self.rows) - MOST
        return replace(self, rows=self.rows[:MOST], note=f"and {more} more") if more > 0 else self

    def __str__(self) -> str:
        return self.text()

    def _repr_html_(self) -> str:
        note = f"<p>{html.escape(self.note)}</p>" if self.note else ""
        return f"<b>{html.escape(self.title)}</b>{self.html()}{note}"


def write_csv(out: TextIO, head: Iterable[str], rows: Iterable[Iterable[Entry]]) -> None:
    """Write comma-separated values with all digits; text that spreadsheets take for formulas begins with ``'``."""
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(map(_inert, head))
    # Numbers are told first: they are most of a long table.
    writer.writerows(
        [cell if type(cell) is float else "" if cell is None else _inert(cell) for cell in row] for row in rows
    )


def _wrapped(text: str, width: int) -> list[str]:
    """Lines of at most this width, of whole words."""
    return textwrap.wrap(text, max(width, 1), break_long_words=False, break_on_hyphens=False)


def _apart(name: str) -> str:
    """A head that may be broken after the dots of a key of an input, as surface.rms_slope, too."""
    return name if " " in name else name.replace(".", ". ")


def _inert(cell: Entry) -> Entry:
    """A cell, with an apostrophe before text that begins as a formula does and is neither a number nor a dash."""
    if not isinstance(cell, str) or not cell.startswith(_FORMULA) or cell == "-":
        return cell
    try:
        float(cell)
    except ValueError:
        return f"'{cell}"
    return cell


def pairs(title: str, rows: Iterable[tuple[str, Entry]], note: str = "") -> Sheet:
    """A sheet of quantities and their values, one a row."""
    return Sheet.of(title, ("quantity", "value"), rows, note)


def words(name: str) -> str:
    """The name of a status in lower case words."""
    return name.lower().replace("_", " ")


def quantities(points: Iterable[Examination]) -> Sheet:
    """Quantities checked, the number of points, and for each the point nearest to or furthest beyond its bound."""
    looked = list(points)
    columns = (
        Column("quantity"), Column("points"), Column("worst: stored", "", ".6g"), Column("found", "", ".6g"),
        Column("off", "", ".1e"), Column("allowed", "", ".1e"), Column(""),
    )  # fmt: skip
    checks = sorted((check for one in looked for check in one.checks), key=lambda check: check.quantity)
    rows = []
    for quantity, group in groupby(checks, key=lambda check: check.quantity):
        every = list(group)
        # What fails comes first, NaN too.
        worst = max(every, key=lambda check: (not check.ok, check.off / check.allowed if check.allowed else 0.0))
        rows.append((quantity, len(every), *worst[1:5], "sound" if worst.ok else "FAILS"))
    left_out = dict.fromkeys(name for one in looked for name in one.left_out)
    note = f"Not looked at: {', '.join(left_out)}." if left_out else ""
    return Sheet.of("What was looked at, in a0 and E*", columns, rows, note)
