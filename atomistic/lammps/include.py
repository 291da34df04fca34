"""The wall as an include of anybody's LAMMPS script, of any ``atom_style`` and ``pair_style``, units metal or real.

Law, heights and forces are the templates of the decks (:func:`wall_lines`), whose names get a prefix here, so that they
meet none of the script.  The number of surface atoms, the drive and where the wall stands are variables, which the
script may define before the include.
"""

import re
from collections import ChainMap
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

import continuum
from atomistic.lammps import directory as disk
from atomistic.lammps import plugin
from atomistic.lammps.deck import least_version, wall_lines
from atomistic.lammps.language import filled, formatted, read_template, vocabulary
from atomistic.lammps.law import NO_CORE, TOLERANCE, law_of_atoms, native_law, wall_table
from atomistic.lammps.protocol import BOLTZMANN, SAMPLED
from atomistic.lammps.shape import Shape, heights_of_shape
from continuum.inputs.arguments import ArgumentError
from continuum.inputs.errors import OutputError
from continuum.inputs.units import GPA_PER_EV_PER_A3, Units, per_area, unit_size
from continuum.measure.contact import ATTRACTED, REPULSIVE
from continuum.model.grid import Grid
from continuum.model.walls import Wall
from continuum.store.output import folder, save

SCRIPT, SHAPE = "in.wall", "in.shape"
"""The include, and the heights that it includes."""
PREFIX = "wall_"
"""Before all names of the include."""
UnitStyle = Literal["metal", "real"]
"""Units of a script of LAMMPS in which lengths are in Å."""
TRACE = {
    "distance": "v_here_z",
    "offset_x": "v_here_x",
    "offset_y": "v_here_y",
    "load": "v_trace_load",
    "load_rep": "v_trace_load_rep",
    "lateral_x": "v_trace_lateral_x",
    "lateral_y": "v_trace_lateral_y",
    "pull_x": "v_pull_x",
    "pull_y": "v_pull_y",
    "pull_z": "v_pull_z",
    "area_rep": "v_area_rep",
    "wall_energy": "v_trace_wall_energy",
    "total_energy": "v_trace_total_energy",
    "taken_by_wall": "v_taken_by_wall",
    "smallest_gap": "v_trace_smallest_gap",
    "temperature": "c_thermo_temp",
}
"""Traced quantities and their names in LAMMPS."""
UNITS_OF_TRACE = "lengths Angstrom, forces nN, areas over that of the box, energies eV, temperature K"
DEEP = 0.7
"""Distance beyond the gap of no traction, in a0, up to which a law reaches the surface plane only: that of the layers
of fcc(100), closer than those of other dense planes."""
_KILO_CALORIES = 23.060547830619026
"""kcal/mol in an eV, e N_A/4184."""
_ATOMIC_DENSITY = 1660.53906660 * np.sqrt(2)
"""Density of a close-packed crystal of one u in each a0³/√2, in kg/m³ with a0 in Å."""
_SCRIPTS = {SCRIPT: "wall", "in.drive": "drive"}
_DEFINED = re.compile(r"\b(?:variable|compute|fix)\s+(\w+)")
_DEFINES = re.compile(r"(\b(?:variable|compute|fix)\s+)(\w+)")
_USES = re.compile(r"(\b[vcf]_|\$\{)(\w+)")
_GROUP = re.compile(r"(\b(?:compute|fix)\s+\S+\s+|gmask\()mobile\b")
_NAME = re.compile(r"[\w./+-]+", re.ASCII)
_OWN = re.compile(r"in\.(wall|shape|drive(\.[xyz])?)|wall\.(map|table|vtk)|heightmap\.(cpp|so)")


@dataclass(frozen=True, eq=False)
class WallInclude:
    """A rough wall for scripts of LAMMPS.

    Parameters
    ----------
    shape : the wall as a function of the position, in a0.
    period : (Lx, Ly) of the wall and of the box, in a0.
    wall : law between wall and surface.
    a0 : in Å.
    contact_modulus : E*, as "135GPa", in eV/Å³.
    surface_atoms : number of atoms of the undisturbed surface plane, among which its area is divided; 0 if the script
        sets it.
    layer : distance of the layers of atoms, in a0, among which a law that reaches several layers is divided; infinite
        if it reaches only the first.
    units : of the script, unless it says otherwise.
    wall_force : how the wall acts: by formulas of LAMMPS or the plugin.
    """

    shape: Shape
    period: tuple[float, float]
    wall: Wall
    a0: float
    contact_modulus: float
    surface_atoms: int = 0
    layer: float = np.inf
    units: UnitStyle = "metal"
    wall_force: Literal["formulas", "plugin"] = "formulas"

    @property
    def grid(self) -> Grid:
        """Points about a0 apart, of a map of a formula."""
        return Grid((max(2, round(self.period[0])), max(2, round(self.period[1]))), self.period)

    @property
    def law(self) -> Wall:
        """The law of each atom."""
        return law_of_atoms(self.wall, self.layer)

    @property
    def lowest(self) -> float:
        """Lowest height of the wall, in a0, at the points of its map."""
        return float(heights_of_shape(self.shape, self.grid).min())

    @property
    def reach(self) -> float:
        """Gap from which the wall starts, in a0: beyond the end of its law, if there is one."""
        return self.law.reach if np.isfinite(self.law.reach) else self.law.zero_gap + 2 * DEEP

    @property
    def about(self) -> str:
        """Period, heights and law of the wall in real units, in one line."""
        real = Units.metal(self.a0, self.contact_modulus)
        lx, ly = (self.a0 * length for length in self.period)
        rise = self.a0 * float(np.ptp(heights_of_shape(self.shape, self.grid)))
        work, zero, end = per_area(self.wall.work_of_adhesion, real), self.a0 * self.wall.zero_gap, self.a0 * self.reach
        law = f"work of adhesion {work}, no force at a gap of {zero:.3g} Å, none beyond {end:.3g} Å"
        return f"{lx:.4g} x {ly:.4g} Å, {rise:.3g} Å from valley to peak; {law}"

    def steps(self, directory: Path) -> list[str]:
        """Remaining steps for the user, one line each."""
        line = "set      variable wall_surface_atoms equal ...   the number of atoms of the surface plane, first"
        if self.surface_atoms:
            area = self.a0**2 * self.period[0] * self.period[1] / self.surface_atoms
            line = f"atoms    {self.surface_atoms} surface atoms of {area:.3g} Å² each"
        return [
            line,
            f"include  {directory / SCRIPT}   in your script, of units {self.units}; its head has its variables",
        ]

    def write(self, directory: str | Path, *, force: bool = False) -> Path:
        """Write the wall into a folder; returns the script that is to be included.

        Parameters
        ----------
        force : write into a folder that has other files, and leave these.

        Raises
        ------
        ArgumentError, OutputError, PluginError
            If LAMMPS cannot read the name of the folder, it has other files, or cannot be written to; or if the plugin
            cannot be built.
        """
        directory = Path(directory)
        if not _NAME.fullmatch(str(directory)):
            allowed = "a name of letters, digits and . _ + - /, as LAMMPS reads it in a script"
            raise ArgumentError("directory", str(directory), allowed)
        if directory.is_dir():
            foreign = sorted(entry.name for entry in directory.iterdir() if not _OWN.fullmatch(entry.name))
            if foreign and not force:
                raise OutputError(
                    f"{directory} has files that do not belong to a wall ({', '.join(foreign[:5])}): choose another "
                    "directory, or leave them beside it with --force"
                )
        texts = self.texts(str(directory))
        library = plugin.plugin_library() if plugin.SOURCE in texts else None  # before anything there is touched
        folder(directory)
        for entry in list(directory.iterdir()):
            if _OWN.fullmatch(entry.name) and entry.name not in texts:
                entry.unlink()
        if library is not None:
            save(directory / plugin.LIBRARY, library, own=True)
        for name in reversed(texts):  # in.wall last
            save(directory / name, texts[name], own=True)
        return directory / SCRIPT

    def texts(self, name: str) -> dict[str, str]:
        """Names and texts of the files, for a folder of this name."""
        values = self._values(name)
        words = ChainMap(
            {}, *([vocabulary()["plugin"]] if self.wall_force == "plugin" else []), vocabulary()["position"]
        )
        values |= {word: filled(words[word], values) for word in ("shape", "height", "act")}
        values |= wall_lines(self.wall_force, values)
        found = {name: filled(read_template(f"include.{of}"), values) for name, of in _SCRIPTS.items()}
        for axis, drag in (("x", "lateral"), ("y", "lateral"), ("z", "drag")):
            weight = read_template("include.weight") if axis == "z" else ""
            push = "c_load*v_force_unit-v_weight" if axis == "z" else f"-c_lateral_{axis}*v_force_unit"
            of_axis = values | {"axis": axis, "weight": weight, "push": push}
            of_axis["drag"] = filled(read_template(f"include.{drag}"), of_axis).rstrip()
            found[f"in.drive.{axis}"] = filled(read_template("include.axis"), of_axis)
        profile = heights_of_shape(self.shape, self.grid)
        if self.wall_force == "formulas":
            found[SHAPE] = "\n".join(self.shape.lines()) + "\n"
        names = set().union(*map(_names_in, found.values()))
        found = {name: _with_prefix(text, names) for name, text in found.items()}
        if self.wall_force == "plugin":
            found |= {plugin.SOURCE: plugin.plugin_source()}
            found |= {plugin.MAP: plugin.wall_map(self.law, self.shape, self.grid)}
        found["wall.table"] = wall_table(self.wall, TOLERANCE, self.law)
        spacing = (self.period[0] / profile.shape[0], self.period[1] / profile.shape[1])
        found["wall.vtk"] = disk.wall_mesh(profile, self.reach - self.lowest, self.a0, spacing=spacing)
        return found

    def _values(self, name: str) -> dict[str, object]:
        law, depth = self.law, getattr(self.shape, "lowest", -np.inf) - self.law.reach
        near = f"z>(v_separation+v_level+({formatted(depth)}))*v_length_unit" if np.isfinite(depth) else "gmask(all)"
        values: dict[str, object] = {
            "name": name,
            "folder": "${wall_folder}",
            "map": f"${{wall_folder}}/{plugin.MAP}",
            "units": self.units,
            "default_atoms": self.surface_atoms,
            "distance": round(self.a0 * self.reach, 6),
            "period_x": round(self.a0 * self.period[0], 6),
            "period_y": round(self.a0 * self.period[1], 6),
            "least_version": least_version("wall"),
            "modulus": self.contact_modulus * GPA_PER_EV_PER_A3,
            "modulus_eV": self.contact_modulus,
            "a0": self.a0,
            "kcal": _KILO_CALORIES,
            "eV_per_A": 1e-9 / unit_size("eV/A", "force"),
            "lowest": self.a0 * self.lowest,
            "about": f"Law: {type(self.wall).__name__}, w = {self.wall.work_of_adhesion:.6g} E* a0.  By stickiness "
            f"{continuum.__version__}.",
            "density": float(_ATOMIC_DENSITY / self.a0**3),
            "boltzmann": BOLTZMANN["metal"],
            "sampled": SAMPLED,
            "traced": " ".join(TRACE.values()),
            "names": " ".join(TRACE),
            "units_of_trace": UNITS_OF_TRACE,
            "law": native_law(law, TOLERANCE).lines,
            "core": max(law.core, NO_CORE),
            "surface": "v_level",
            "near": near,
            "site": "",
            "lines": f"include         ${{wall_folder}}/{SHAPE}",
            "pushed": "mobile",
            "at_rest": "mobile",
            "surface_atoms": "v_surface_atoms",
            "zero_gap": self.wall.zero_gap,
            "reach": self.wall.zero_gap + self.wall.range,
            "repulsive": REPULSIVE,
            "attracted": ATTRACTED,
        }
        for axis, length in zip("xy", self.period, strict=True):
            # Stretched to the box; its slopes, too.
            values[f"at_{axis}"] = f"({axis}-{axis}lo-v_here_{axis})*{formatted(length)}/l{axis}"
            values[f"along_{axis}"] = f"*{formatted(length * self.a0)}/l{axis}"
        return values


def _names_in(text: str) -> set[str]:
    """Names of variables, computes and fixes that a script defines."""
    code = "\n".join(line.partition("#")[0] for line in text.splitlines())
    return {name for name in _DEFINED.findall(code) if not name.startswith("wall")}


def _with_prefix(text: str, names: set[str]) -> str:
    """A script whose names begin with wall_, of the group of the script instead of that of a deck."""

    def longer(found: re.Match[str]) -> str:
        return f"{found[1]}{PREFIX * (found[2] in names)}{found[2]}"

    text = _DEFINES.sub(longer, _USES.sub(longer, text))
    return _GROUP.sub(rf"\1${{{PREFIX}group}}", text)
