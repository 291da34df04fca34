# ruff: noqa: I001
"""Elastic responses of the substrate: the stiffness K_q of its surface at each wavevector.

``K_q = 1/G_zz(q)``: vertical traction per vertical displacement when lateral tractions vanish.  It is not the
zz entry of the 3 x 3 stiffness matrix, which holds the lateral displacements at zero.  Each response is in a file of
its own, of which each class is also a table of the input; files here are found by themselves.
"""

from importlib import import_module
from pkgutil import iter_modules

from continuum.model.substrates.isotropic import HalfSpace as HalfSpace
from continuum.model.substrates.isotropic import Layer as Layer
from continuum.model.substrates.isotropic import LayeredHalfSpace as LayeredHalfSpace
from continuum.model.substrates.non_periodic import NonPeriodicHalfSpace as NonPeriodicHalfSpace
from continuum.model.substrates.crystal import CubicLayer as CubicLayer
from continuum.model.substrates.tabulated import TabulatedSubstrate as TabulatedSubstrate
from continuum.model.substrates.substrate import MeanMode as MeanMode
from continuum.model.substrates.substrate import PeriodicResponse as PeriodicResponse
from continuum.model.substrates.substrate import Substrate as Substrate
from continuum.model.substrates.substrate import Response as Response
from continuum.model.substrates.substrate import with_mean as with_mean

for _file in iter_modules(__path__):
    import_module(f"{__name__}.{_file.name}")
