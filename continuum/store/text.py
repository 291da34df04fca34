"""Read text: tables of numbers in whatever dialect a program wrote them, and what their headers say of size and units.

The dialect is read off the text: encoding, what stands between columns, marks of decimals and thousands, lines of
words before the numbers, labels of rows and columns, words for a missing value.  A text that can be read in two ways,
as 1,234 between blanks, is refused.  (``pandas.read_csv`` fills short rows with NaN and takes commas out of numbers
wherever they stand, so that a damaged table would be another map instead of an error.)

Keys and values in headers are those of the exports of Gwyddion, SPIP, Attocube, Nova and others, and of ESRI's grids;
the attributes those of the CF conventions of netCDF, which HDF5 shares.
"""

import codecs
import csv
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from continuum.inputs import units
from continuum.model.fourier import Real

_MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig"), (codecs.BOM_UTF32_LE, "utf-32"), (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"),
)  # fmt: skip
"""Byte order marks; those of UTF-32 begin as those of UTF-16 do."""
_BINARY = re.compile(rb"[\0-\x08\x0e-\x19\x1b-\x1f]")
_THIN = "'’\u00a0\u2009\u202f"
"""Marks of thousands that are no decimal marks."""
_NUMBER = re.compile(rf"[+-]?[.,]?\d[\d.,{_THIN}]*(?:[eE][+-]?\d+)?")
_FORTRAN = re.compile(r"(?<![\w.,])([+-]?(?:\d+[.,]?\d*|[.,]\d+))[dD]([+-]?\d{1,3})(?![\w.,])")
"""A number of double precision as Fortran writes it, 1.5D-03."""
_VOID = re.compile(
    r"[^\w\s]*|[+-]?nan(?:\(\w*\))?|[+-]?inf(?:inity)?|[+-]?1[.,]#\w+|#?n[./]?a\.?|#(?:div/0|value|num|ref|null|name)[!?]"
    r"|bad|null|none|nil|void|missing|invalid|masked|undef(?:ined)?|no[ _-]?(?:data|value)",
    re.IGNORECASE,
)
"""A missing value: nothing, signs only (***, ---), or a word."""
_COMMENT = re.compile(r"(?:^|\s)#(?!n/?a\b|\w+[/!?]|#).*", re.IGNORECASE)
_BETWEEN = re.compile(r"[;,\s\"]+")
_EVEN = 1e-3
"""Largest deviation of labels from equal steps, as a part of a step: they are rounded."""
_FEW = 4
"""Fewer columns are positions and heights, which have no labels."""
_REAL = r"[+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eEdD][+-]?\d+)?"
_UNIT = re.compile(r"(?:[\[(/]|\bin\b)\s*([A-Za-zµμÅ]+)\s*[\])]?")
"""A unit beside a name: x [um], Height (nm), z/nm, x in µm."""
_OF_HEIGHTS = re.compile(r"\b(?:heights?|values?|z)\s*(?:[\[(/]|\bin\b)\s*([A-Za-zµμÅ]+)", re.IGNORECASE)
_AXIS = r"(?:scan)?(?:{0}(?:scan)?(?:length|size|range|extent)|(?:length|size|range|extent){0}|{1})"
_KEYS = {
    # Gwyddion writes in the language of its user.
    "x": re.compile(_AXIS.format("x", "width|breite|largeur|šířka|larghezza|ширина|anchura|ancho|largura|폭|幅")),
    "y": re.compile(_AXIS.format("y", "height|höhe|hauteur|výška|altezza|высота|altura|높이|高さ")),
    "both": re.compile(r"scansize|imagesize|scanrange|fieldofview|size"),
    "pixel": re.compile(r"pixelsize|cellsize|spacing"),
    "x unit": re.compile(r"(?:xy|x|lateral)units?|unitx"),
    "unit": re.compile(
        r"(?:values?|z|heights?|data)units?|unit(?:z|data)|(?:wert(?:e|en)?|z|höhen)einheit(?:en)?|einheit(?:en)?(?:derwerte)?"
        r"|unités(?:de(?:s)?valeurs?)?|jednotkyhodnot|unitàvalor[ei]|unitàdimisura|единицыизмерения|единицызначений"
        r"|unidades(?:delvalor|devalor)?|값단위|値の単位"
    ),
    "void": re.compile(r"nodata(?:value)?|fillvalue|missingvalue"),
}
"""What keys mean, written small and without blanks, dashes and units."""
_NAMED = {
    "x": re.compile(
        r"x(?:pos(?:ition)?|coord(?:inate)?|axis)?|lateral(?:position)?|(?:scan)?(?:distance|position|length)"
    ),
    "y": re.compile(r"y(?:pos(?:ition)?|coord(?:inate)?|axis)?"),
    "z": re.compile(r"z(?:pos(?:ition)?|coord(?:inate)?|axis)?|h|heights?|topography|(?:total|raw)?profile|elevation"),
}
"""Names of columns, written small and without blanks, dashes and units."""
_SPELLED = {"micron": "um", "micrometer": "um", "micrometre": "um", "mum": "um", "nanometer": "nm", "nanometre": "nm",
            "angstrom": "A", "ang": "A", "meter": "m", "metre": "m", "millimeter": "mm", "millimetre": "mm",
            "picometer": "pm", "picometre": "pm"}  # fmt: skip
_NO_LENGTH = frozenset({
    "v", "mv", "uv", "µv", "na", "pa", "s", "ms", "us", "µs", "hz", "khz", "n", "nn", "un", "µn", "pn", "deg", "rad",
    "°", "%", "counts", "cts", "arb", "arb.u.", "a.u.", "kpa", "mpa", "gpa", "k", "°c", "db", "grey", "gray",
})  # fmt: skip
"""Other units in a row of units, in lower case."""
_NO_UNIT = frozenset({"", "1", "a0", "px", "pixel", "pixels", "points", "pts", "samples", "dimensionless"})
"""The unit of numbers that come without one, and of results of this program, in a0."""


class NoTableError(ValueError):
    """A file that is no table of numbers, and may be of another format; a faulty table is a plain ValueError."""


class Text(NamedTuple):
    """Rows of numbers, and what stands around them.

    Parameters
    ----------
    rows : the numbers, shape (lines, columns); NaN where there is no value.
    header : lines of words before the numbers.
    steps : choices made, in words.
    columns, lines : positions that label the columns and the lines; None if there are none.
    """

    rows: Real
    header: tuple[str, ...] = ()
    steps: tuple[str, ...] = ()
    columns: Real | None = None
    lines: Real | None = None
    fields: tuple[tuple[str, ...], ...] = ()
    """The lines of the header, each split as the numbers are."""


def read_text(path: Path) -> Text:
    """Read a table of numbers.

    Raises OSError if the file cannot be read, NoTableError if it is no text or no table of numbers, and ValueError if
    a row has something else among its numbers, or can be read in two ways.
    """
    try:
        return _table(*_decoded(path.read_bytes()))
    except ValueError as error:
        raise (NoTableError if isinstance(error, NoTableError) else ValueError)(
            f"{path} is not a table of numbers: {error}"
        ) from error


def _decoded(raw: bytes) -> tuple[str, tuple[str, ...]]:
    """The text of a file, and what was assumed: a marked encoding, UTF-8, UTF-16, or else the Windows code page."""
    encoding = next((name for mark, name in _MARKS if raw.startswith(mark)), "")
    if not encoding and _BINARY.search(raw[:4096]):
        # In UTF-16 most characters of a table have a zero beside them.
        first, second = (raw[start:4096:2].count(0) / max(len(raw[start:4096:2]), 1) for start in (0, 1))
        if max(first, second) <= 0.5 or min(first, second) > 0:
            raise NoTableError("it is not a text file")
        encoding = "utf-16-le" if second > first else "utf-16-be"
    try:
        return raw.decode(encoding or "utf-8"), ()
    except UnicodeDecodeError as error:
        if encoding:
            raise NoTableError(f"it is not text in the encoding {encoding}") from error
        return raw.decode("cp1252", errors="replace"), ("read in the Windows code page 1252, because it is not UTF-8",)


def _table(text: str, steps: tuple[str, ...]) -> Text:
    """The table in a text: its header ends at the first line of numbers."""
    text = text.rstrip("\x1a")  # the end of a file in DOS
    original = text.replace("\u2212", "-").replace("\r\n", "\n").replace("\r", "\n").split("\n")
    lines = [_COMMENT.sub("", line) if "#" in line else line for line in original]
    if _FORTRAN.search(text):
        lines = [_FORTRAN.sub(r"\1E\2", line) for line in lines]
    first = next((i for i, line in enumerate(lines) if _is_row(line)), len(lines))
    header = tuple(word for line in original[:first] if (word := line.strip().lstrip("#").strip()))
    if first == len(lines):
        if any(line.strip() for line in lines):
            raise NoTableError("it contains no line of numbers")
        return Text(np.empty((0, 0)), header, steps)
    for line in lines[:first]:  # a row of numbers with a word in it is no header
        numbers = [_NUMBER.fullmatch(word) is not None for word in _words(line)]
        if numbers and numbers[0] and 2 * sum(numbers) > len(numbers):
            raise ValueError(f"{line.strip()[:60]!r} has an entry that is neither a number nor a mark of a missing one")
    inner = [i for i, line in enumerate(original[first:], first) if line.startswith("#") and re.search("[:=]", line)]
    if inner and any(map(_is_row, lines[inner[0] :])):
        raise NoTableError(f"several maps in one file: {original[inner[0]].strip()!r} stands among the numbers")
    dialect = _dialect([line for line in lines[first:] if line.strip(" ")], header)
    # Lines without any value may stand before the first number.
    empty = [bool(line.strip(" ")) and all(map(_VOID.fullmatch, _words(line))) for line in lines[:first]]
    start = first - next((i for i, void in enumerate(reversed(empty)) if not void), first)
    rows = _rows([(i + 1, line) for i, line in enumerate(lines) if i >= start and line.strip(" ")], dialect)
    return _labelled(rows if rows.shape[1] >= _FEW else rows[first - start :], header, steps, dialect)


def _words(line: str) -> list[str]:
    return [word for word in _BETWEEN.split(line) if word]


def _is_row(line: str) -> bool:
    """Whether a line has numbers, and words for missing values, only."""
    words = _words(line)
    return any(map(_NUMBER.fullmatch, words)) and all(_NUMBER.fullmatch(one) or _VOID.fullmatch(one) for one in words)


class _Dialect(NamedTuple):
    """Separators of columns ("": blanks), decimals and thousands, and whether fields have quotes."""

    between: str
    decimal: str = "."
    thousands: str = ""
    thin: str = ""
    """Marks of thousands other than comma and point."""
    quoted: bool = False

    def fields(self, line: str) -> list[str]:
        """The fields of a line, with decimal points and without marks of thousands."""
        if self.thin:
            line = re.sub(rf"(?<=\d)[{self.thin}](?=\d{{3}}(?!\d))", "", line)
        if self.quoted and '"' in line:
            fields = next(csv.reader([line], delimiter=self.between or " ", skipinitialspace=True))
        else:
            fields = line.split(self.between or None)
        if self.decimal + self.thousands != ".":
            change = str.maketrans(self.decimal, ".", self.thousands)
            fields = [field.translate(change) if _NUMBER.fullmatch(field.strip()) else field for field in fields]
        return [field.strip() for field in fields] if self.between else fields


def _dialect(rows: Sequence[str], header: Sequence[str]) -> _Dialect:
    """The dialect of rows; raises ValueError if they can be read in two."""
    text = "\n".join(rows)
    quoted = '"' in text
    seen = [re.sub(r'"[^"]*"', "0", line) for line in rows] if quoted else rows
    between = next((mark for mark in ";\t" if any(mark in line for line in seen)), "")
    with_comma = "" if between else next((line for line in seen if "," in line), "")
    # Commas are within numbers where blanks stand between these.
    words = re.split(" +", with_comma.strip())
    if with_comma and (len(words) == 1 or any(word[0] == "," or word[-1] == "," for word in words)):
        between = ","
    thin = "".join(mark for mark in _THIN + " " * bool(between or quoted) if mark in text)
    plain = _Dialect(between, thin=thin, quoted=quoted)
    if thin or quoted:
        text = "\n".join(("\t" if quoted else between or " ").join(plain.fields(line)) for line in rows)
    if between == "," and not quoted:
        # 0,4440,-0,6418 and 1,034.5,2,001.0
        if found := re.search(r"(?:^|,)\s*(?:[+-]?0\d[\d.]*|-0)\s*(?=,|$)", text, re.MULTILINE):
            raise ValueError(f"commas stand between columns and within numbers ({found[0]!r})")
        pairs = not header or "," not in header[-1]
        if pairs and all(re.fullmatch(r"\s*[+-]?\d+,\d+\s*", line) for line in rows):
            raise ValueError(f"{rows[0].strip()!r} is one number with a decimal comma, or two: write decimal points")
        text = text.replace(",", "\n")
    decimal, thousands = _marks(text)
    return plain._replace(decimal=decimal, thousands=thousands)


def _marks(text: str) -> tuple[str, str]:
    """The decimal mark, and the mark of thousands or nothing, of numbers with points and commas."""
    used = [mark for mark in ",." if mark in text and re.search(rf"\d\{mark}(?!#)|\{mark}\d", text)]
    if not used:
        return ".", ""
    if len(used) == 2 and (both := re.search(r"\d(?:\.[\d.]*,|,[\d,]*\.)", text)):
        decimal = both[0][-1]  # of two marks in one number the last
    elif len(used) == 2:
        # No number has both: that of thousands stands before groups of three only.
        odd = [mark for mark in used if not _grouped(text, mark)]
        if len(odd) != 1:
            raise ValueError("it has decimal points and decimal commas")
        decimal = odd[0]
    else:
        decimal = used[0]
        if _grouped(text, decimal):
            # Twice in one number, as 1,234,567, only thousands are marked.
            if re.search(rf"\d\{decimal}\d+\{decimal}", text):
                return "." if decimal == "," else ",", decimal
            example = re.search(rf"\d+\{decimal}\d+", text)
            # All of 1.234, 5.678 are decimal; beside 987 they may be thousands.
            if example and (decimal == "," or re.search(r"(?<![\d.eE+-])[+-]?\d{1,3}(?![\d.eE])", text)):
                raise ValueError(f"{example[0]!r} is a number with decimals, or one of thousands: write 1234.5")
        return decimal, ""
    thousands = "." if decimal == "," else ","
    if not _grouped(text, thousands, decimal):
        raise ValueError(f"{decimal!r} is its decimal mark, and {thousands!r} stands where no thousands end")
    return decimal, thousands


def _grouped(text: str, mark: str, decimal: str = "") -> bool:
    """Whether in every number that has this mark it stands between thousands."""
    end = rf"(?:\{decimal}\d*)?" if decimal else ""
    good = rf"[1-9]\d{{0,2}}(?:\{mark}\d{{3}})+{end}(?![\d.,eE])"
    return re.search(rf"(?<![\d.,])(?!{good})[\d.,]*(?:\d\{mark}(?!#)|\{mark}\d)", text) is None


def _rows(lines: Sequence[tuple[int, str]], dialect: _Dialect) -> Real:
    """The numbers of all lines, without columns at the end that are empty in all of them."""
    rows, filled = list[Real](), list[int]()
    for number, line in lines:
        fields = dialect.fields(line)
        rows.append(_numbers(fields, number))
        filled.append(next((n for n in range(len(fields), 0, -1) if fields[n - 1]), 0))
    width, longest = max(filled), max(row.size for row in rows)
    for row, until, (number, _) in zip(rows, filled, lines, strict=True):
        # A row may lack the last separator, unless the last number is missing, too.
        if row.size < width or (until < width and row.size != longest):
            raise NoTableError(f"line {number} has {row.size} columns, another one {max(width, longest)}")
    table = np.stack([row[:width] for row in rows])
    table[~np.isfinite(table)] = np.nan
    return table


def _numbers(fields: Sequence[str], line: int) -> Real:
    """The numbers of a line."""
    try:
        return np.array(fields, dtype=np.float64)
    except ValueError:
        wrong = [field for field in fields if not _VOID.fullmatch(field) and not _is_float(field)]
        if wrong:
            # A slip in a row of numbers is a fault; a row of words is that of another format, for its reader.
            kind = ValueError if 2 * len(wrong) < len(fields) else NoTableError
            raise kind(f"{wrong[0][:40]!r} in line {line} is neither a number nor a mark of a missing one") from None
        return np.array([np.nan if _VOID.fullmatch(field) else float(field) for field in fields])


def _is_float(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _even(values: Real) -> bool:
    """Whether these are numbers at equal steps."""
    if values.size < _FEW - 1 or not np.isfinite(values).all():
        return False
    steps = np.diff(values)
    return bool(steps.mean() != 0 and np.abs(steps - steps.mean()).max() <= _EVEN * abs(steps.mean()))


def _labelled(table: Real, header: tuple[str, ...], steps: tuple[str, ...], dialect: _Dialect) -> Text:
    """Take labels off the rows and columns: a count, or positions at equal steps."""
    width = table.shape[1]
    fields = tuple(_fields(line, dialect, width) for line in header)
    names = fields[-1] if fields else ("",)
    if width > 1 and len(names) == width and names[0].lower() == "index":
        plain = tuple(row[1:] if len(row) == width else row for row in fields)
        return Text(table[:, 1:], header, (*steps, "a column that counts the rows left out"), fields=plain)
    if width < _FEW or {"x", "z"} <= {*column_kinds(fields, width)}:
        return Text(table, header, steps, fields=fields)
    columns = lines = None
    if len(names) == width and all(map(_is_float, names[1:])):
        if not (_even(table[:, 0]) and _even(np.array(names[1:], dtype=np.float64))):
            raise ValueError(f"{names[0]!r} stands among the numbers of the first row")
        columns, lines, table, header = np.array(names[1:], dtype=np.float64), table[:, 0], table[:, 1:], header[:-1]
    else:
        # Labels are even, and what they label is not.
        one, other = (_even(part[0, 1:]) and not any(map(_even, part[1:, 1:])) for part in (table, table.T))
        if one and (other or _even(table[0])):
            columns, table = table[0], table[1:]
        if other and (one or _even(table[:, 0])):
            lines, table = table[:, 0], table[:, 1:]
            columns = None if columns is None else columns[1:]
    fields = fields if table.shape[1] == width else ()
    named = [name for name, labels in (("row", columns), ("column", lines)) if labels is not None]
    return Text(table, header, (*steps, *(f"a {name} of labels left out" for name in named)), columns, lines, fields)


def _fields(line: str, dialect: _Dialect, width: int) -> tuple[str, ...]:
    """The fields of a line of words, without empty ones beyond those of the numbers; the line itself if it has none."""
    try:
        found = tuple(field.strip('" ') for field in dialect.fields(line))
    except (csv.Error, StopIteration):
        return (line,)
    return found[:width] if not any(found[width:]) else found


class Said(NamedTuple):
    """What a file says: lengths along x and y and unit of the heights, in m, pixel in m, numbers that are missing."""

    size: tuple[float, ...] | None = None
    unit: float | None = None
    pixel: float | None = None
    voids: tuple[float, ...] = ()


def unit_of(name: str) -> float | None:
    """Size in m of a unit of length in a file; None where it stands for none.

    Raises ValueError if it is a unit of something else, or unknown.
    """
    plain = name.strip().strip("[]()")
    if plain.lower() in _NO_UNIT:
        return None
    return units.unit_size(_SPELLED.get(plain.lower().removesuffix("s"), plain), "length")


def _known(name: str) -> float | None:
    try:
        return unit_of(name)
    except ValueError:
        return None


def units_in(header: Sequence[str], fields: Sequence[Sequence[str]], used: Sequence[int]) -> tuple[float, ...]:
    """Units of length of columns of positions and heights, in m, from the last line that has one for each.

    Parameters
    ----------
    header, fields : the lines before the numbers, whole and as the fields of each.
    used : the columns.

    Raises ValueError if a row of units has another one than of length for a column that is used.
    """
    for line, row in zip(reversed(header), reversed(fields), strict=True):
        if units_of_row := _row_of_units(row, used):
            return units_of_row
        found = [unit for name in _UNIT.findall(line) if (unit := _known(name)) is not None]
        if len(found) > max(used) or len(found) == len(used):
            return tuple(found[i] for i in used) if len(found) > max(used) else tuple(found)
    return ()


def _row_of_units(row: Sequence[str], used: Sequence[int]) -> tuple[float, ...]:
    """Units of the columns that are used, in m, if each field of a row is a unit; whatever the columns are called."""
    plain = [field.strip(" []()\"'") for field in row]
    if len(plain) <= max(used) or not all(
        _known(name) is not None or name.lower() in _NO_LENGTH or (name == "" and i not in used)
        for i, name in enumerate(plain)
    ):
        return ()
    for i in used:
        if _known(plain[i]) is None:
            raise ValueError(f"column {i + 1} is in {plain[i]!r}, which is not a unit of length")
    return tuple(unit_of(plain[i]) or np.nan for i in used)


def column_kinds(fields: Sequence[Sequence[str]], columns: int) -> tuple[str, ...]:
    """Content of each column by its name, "x", "y", "z" or nothing; empty where no line names all columns."""
    for row in reversed(fields):
        plain = [re.sub(r"[\[(/].*|\bin\b.*|_?(?:nm|um|µm|mm)$|[\s_\"'-]", "", field.lower()) for field in row]
        kinds = [next((kind for kind, names in _NAMED.items() if names.fullmatch(name)), "") for name in plain]
        if len(row) == columns and any(kinds):
            return tuple(kinds)
    return ()


def said_by(header: Sequence[str]) -> Said:
    """Size, unit and missing numbers that a header gives for a matrix of heights.

    Raises ValueError if it has a unit that is no length.
    """
    found, rest = dict[str, str](), list[str]()
    for line in header:
        key, mark, value, *_ = *re.split("([:=])", line, maxsplit=1), "", ""
        if not mark and (pair := re.fullmatch(rf"([A-Za-z_]+)\s+({_REAL})", line)):
            key, value = pair.groups()
        name, beside = re.sub(r"[\[(].*|[\s_-]", "", key).lower(), re.search(r"[\[(](.*?)[\])]", key)
        meaning = next((one for one, known in _KEYS.items() if known.fullmatch(name) and value.strip()), None)
        if meaning is None:
            rest.append(line)
        else:
            found.setdefault(meaning, f"{value.strip()} {beside[1] if beside else ''}".strip())
    lateral = found.get("x unit", "")
    x, y = (_lengths(found.get(name, ""), lateral, unit_of) for name in "xy")
    both, pixel = (_lengths(found.get(name, ""), lateral, _known) for name in ("both", "pixel"))
    size = (x[0], y[0]) if x and y else both or x
    unit = unit_of(found["unit"]) if "unit" in found else None
    if unit is None:
        unit = next((one for name in _OF_HEIGHTS.findall("\n".join(rest)) if (one := _known(name))), None)
    voids = tuple(float(found["void"]) for _ in range(1) if re.fullmatch(_REAL, found.get("void", "")))
    return Said(size[:2] or None, unit, pixel[0] if pixel else None, voids)


def _lengths(text: str, lateral: str, read: Callable[[str], float | None]) -> tuple[float, ...]:
    """Lengths in m in the value of a key, as 1 µm, or 1 µm x 2 µm; empty if they have no unit."""
    parts = re.findall(rf"({_REAL})\s*((?!x\s*[\d.])[A-Za-zµμÅ]*)", text)
    names = [name for _, name in parts if name] or [lateral]
    sizes = [read(name or names[-1]) for _, name in parts]
    lengths = [
        float(re.sub("[dD]", "e", number.replace(",", "."))) * size
        for (number, _), size in zip(parts, sizes, strict=True)
        if size
    ]
    return tuple(lengths) if len(lengths) == len(parts) and all(length > 0 for length in lengths) else ()


def decoded(values: Real, attributes: Mapping[str, Any]) -> Real:
    """Numbers of a dataset after its attributes: missing ones are NaN, then scaled and shifted.

    Attributes are those of the CF conventions, section 2.5.1 and 8.1: ``_FillValue``, ``missing_value``,
    ``valid_min``, ``valid_max``, ``valid_range``, of numbers as they are stored, ``scale_factor`` and ``add_offset``.
    """
    plain = {name: np.ravel(value).astype(np.float64) for name, value in attributes.items()
             if np.asarray(value).dtype.kind in "iuf" and np.size(value)}  # fmt: skip
    missing = np.zeros(values.shape, dtype=bool)
    for name in ("_FillValue", "missing_value"):
        missing |= np.isin(values, plain.get(name, ()))
    least, most = plain.get("valid_range", (-np.inf, np.inf))[:2]
    missing |= (values < plain.get("valid_min", (least,))[0]) | (values > plain.get("valid_max", (most,))[0])
    scale, offset = (plain.get(name, (default,))[0] for name, default in (("scale_factor", 1.0), ("add_offset", 0.0)))
    return np.where(missing, np.nan, values * scale + offset) if plain else values


def unit_in(attributes: Mapping[str, Any]) -> float | None:
    """The unit of a dataset in m, from its attribute ``units``; None if it has none.

    Raises ValueError if it is no unit of length.
    """
    name = next((attributes[key] for key in attributes if key.lower() in ("units", "unit")), "")
    if isinstance(name, np.ndarray):
        name = name.ravel()[0] if name.size else ""
    return unit_of(name.decode("utf-8", "replace") if isinstance(name, bytes) else str(name))
