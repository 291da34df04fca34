# ruff: noqa: I001
"""Wall laws, each with its table in an input in a file of its own, in the order of the reference page."""

from continuum.model.walls.spline import LennardJonesSpline as LennardJonesSpline
from continuum.model.walls.inverse_powers import InversePowers as InversePowers
from continuum.model.walls.exponential import Exponential as Exponential
from continuum.model.walls.tabulated import TabulatedWall as TabulatedWall
from continuum.model.walls.attraction import attraction_on_core as attraction_on_core
from continuum.model.walls.hard import HardWall as HardWall
from continuum.model.walls.wall import Wall as Wall
from continuum.model.walls.wall import WallTable as WallTable
