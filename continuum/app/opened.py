"""A map that is open in the browser: its file, the fields of the form, and the answer."""

import re
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args

from continuum import units
from continuum.errors import InputError
from continuum.front.predict import of_maps
from continuum.show.answer import statements
from continuum.show.plot import image_bytes
from continuum.show.prediction_figures import mending_figure
from continuum.sticky.prediction import Prediction
from continuum.topography.mending import Detrending, detrend
from continuum.topography.reading import read_all

FIELDS = (
    "size", "unit", "material", "modulus", "poisson", "contact_modulus", "work", "range", "spacing", "probe",
    "detrend", "fill", "void", "crop", "cutoff", "smallest",
)  # fmt: skip
"""Fields of the form, which are arguments of :func:`continuum.predict`."""
SEVERAL = frozenset({"material", "modulus", "poisson"})
"""Fields that may have two values, one for each body."""
_LONGEST = 200


@dataclass(frozen=True)
class OpenedMap:
    """A topography, and the folder for the files made from it.

    Parameters
    ----------
    path : path of the file.
    shown : name that is shown, never a path on this machine.
    folder : private folder of the program.
    """

    path: Path
    shown: str
    folder: Path

    def predict(self, asked: Mapping[str, str]) -> Prediction:
        """The prediction for a form, without a search; raises InputError about its fields."""
        return of_maps([self.path], arguments(asked)).solved(search=False)

    def mending(self, asked: Mapping[str, str], found: Prediction) -> bytes:
        """A picture (PNG) of the measured map with holes filled, and of the map that is judged.

        Raises InputError if the map cannot be read with size, unit, fill and void only.
        """
        given = arguments(asked)
        told = {name: given[name] for name in ("size", "unit", "fill", "void") if name in given}
        (measured,) = read_all([self.path], **told)
        return image_bytes(mending_figure(detrend(measured, "none"), found.topographies[0]))

    def command(self, asked: Mapping[str, str], file: str = "", *more: str) -> list[str]:
        """The equivalent command, with further options."""
        words = ["continuum", "predict", file or self.shown]
        for name, value in arguments(asked).items():
            option = "--estar" if name == "contact_modulus" else f"--{name}"
            for each in value if isinstance(value, tuple) else (value,):
                words += [option, str(each)]
        return [*words, *more]

    def solving(self, asked: Mapping[str, str]) -> list[str]:
        """The command of this program that solves the map and writes its page into the folder."""
        _, *words = self.command(asked, str(self.path), "--solve", "--output", str(self.folder / "solved"))
        return [sys.executable, "-m", "continuum", *words]


def arguments(asked: Mapping[str, str]) -> dict[str, Any]:
    """Convert a form to arguments of :func:`continuum.predict`; raises InputError for invalid ones."""
    found: dict[str, Any] = {}
    for name, value in asked.items():
        if name not in FIELDS or not isinstance(value, str) or len(value) > _LONGEST:
            raise InputError(f"{name[:40]}: not a field of the form, or not a short text")
        if not value.strip():
            continue
        # Two values of a field are separated by commas.
        several = tuple(part.strip() for part in value.split(","))
        found[name] = several if name in SEVERAL else value.strip()
    detrend = found.get("detrend")
    if detrend is not None and detrend not in get_args(Detrending):
        raise InputError(f"detrend: {detrend!r} is not one of {', '.join(get_args(Detrending))}")
    return found


def answer(found: Prediction) -> dict[str, Any]:
    """The answer of a prediction, and the values of its sliders."""
    contact, pixels = found.contact, found.topographies[0].grid.spacing
    shown = {
        "work": units.readable(contact.work_of_adhesion, "energy_per_area", 3),
        "contact_modulus": units.readable(contact.contact_modulus, "pressure", 3),
        "range": units.readable(contact.range, "length", 3),
        "cutoff": units.readable(found.topographies[0].cutoff or 4 * max(pixels), "length", 3),
    }
    return {
        "statements": [f"{line}." for line in statements(found)],
        "doubts": list(found.doubts),
        "values": {name: text.replace(" ", "").replace("²", "2") for name, text in shown.items()},
    }


def safe_name(name: str) -> str:
    """A safe name for an uploaded file: letters, digits, dots, - and _ of its own name."""
    plain = re.sub(r"[^A-Za-z0-9._-]+", "_", Path(name.replace("\\", "/")).name).strip("._")[-80:].lstrip("._")
    return plain or "map"
