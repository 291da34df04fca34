# ruff: noqa: I001
"""Wall laws, each in a file of its own, and each also a table of the input; files here are found by themselves."""

from importlib import import_module
from pkgutil import iter_modules

from continuum.model.walls.spline import LennardJonesSpline as LennardJonesSpline
from continuum.model.walls.inverse_powers import InversePowers as InversePowers
from continuum.model.walls.exponential import Exponential as Exponential
from continuum.model.walls.tabulated import TabulatedWall as TabulatedWall
from continuum.model.walls.attraction import attraction_on_core as attraction_on_core
from continuum.model.walls.hard import HardWall as HardWall
from continuum.model.walls.wall import Wall as Wall

for _file in iter_modules(__path__):
    import_module(f"{__name__}.{_file.name}")
