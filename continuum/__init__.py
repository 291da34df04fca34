"""Adhesive contact of a rigid rough wall with an elastic substrate, by FFT Green's functions.

The model is that of L. Pastewka and M. O. Robbins, "Contact between rough surfaces and a criterion for macroscopic
adhesion", PNAS 111, 3298 (2014), called "the paper" throughout.  Equations are cited by their printed numbers, those
of its supplement as Eq. (S-1).

The public names are listed in ``continuum.__all__``.  A :class:`Contact` of your own is pressed to a :class:`State` or
along a :class:`LoadingPath`; :func:`run` follows an input file, and :func:`predict` decides whether a measured map is
sticky.  The docstring of each subpackage says what it contains.

Conventions (stated here once; everything else refers to this page)
--------------------------------------------------------------------
Units
    a0 = 1, the spacing of the square grid of surface atoms, which is the nearest-neighbour distance of the
    fcc crystal; E* = 1, the contact modulus.  ``contact_modulus`` is always E* = E/(1 - nu²), never Young's
    modulus.  Real units exist only at the edges, in :mod:`continuum.inputs.units`.
Signs
    Tractions are per area, compression positive.  ``gap = separation + height - displacement`` is the height
    of the rigid wall above the deformed surface; a displacement is positive towards the wall.
    A wall law gives energy, traction = -d energy/d gap and stiffness = d²energy/d gap², all per area.
Contact
    ``wall.zero_gap`` is the gap where the traction changes sign: a0 for the paper's law, 0 for a hard wall.
    Repulsive area A_rep: gap < zero_gap.  Attractive area A_att: zero_gap <= gap < zero_gap + range.
Totals
    Only :meth:`Grid.integrate` and :meth:`Grid.mean` turn fields per area into totals and means.
Fourier transforms
    ``field(x) = sum_q field_q exp(i q x)``, so that the q = 0 component is the mean.  The suffix ``_q`` marks
    a field over wavevectors, stored as the half spectrum of a real FFT, shape (nx, ny // 2 + 1); no suffix
    marks a field over the grid, shape (nx, ny).  All transforms are those of :mod:`continuum.model.fourier`.
Elastic response
    ``traction_q = -K_q displacement_q`` with K_q = 1/G_zz(q): lateral tractions vanish.  For an isotropic
    half-space K_q = E* |q|/2.
The mean mode
    The stiffness at q = 0 is an explicit argument without a default: ``"clamped"`` (a rigid base under an
    incompressible layer: the mean displacement is zero), ``"free"``, or a number (pressure per displacement).
Roughness
    Moments are spectral: h_rms² = sum |h_q|², h'_rms² = sum q² |h_q|², and ``rms_curvature`` is the paper's
    h''_rms = sqrt(<(laplacian h)²>), which some packages halve.
Random numbers
    A ``numpy.random.Generator`` is passed in; modes are drawn in shells of max(|m|, |n|), so that one seed
    gives one surface on every grid that resolves it.
"""

import re
from importlib import import_module
from pathlib import Path

__version__ = "1.0.0"

_NAMES = re.compile(r"^from (\S+) import (\w+)", re.MULTILINE)
# Imported when they are asked for: `continuum --help` needs none of them.
_MODULES = {name: module for module, name in _NAMES.findall(Path(__file__).with_suffix(".pyi").read_text())}
__all__ = sorted(_MODULES)


def __getattr__(name: str) -> object:
    if name not in _MODULES:
        raise AttributeError(f"module 'continuum' has no attribute {name!r}")
    return getattr(import_module(_MODULES[name]), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
