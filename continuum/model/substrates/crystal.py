"""Response of crystal faces: (100) of a cubic crystal, half-space or bonded layer; basal of a hexagonal one.

On a cubic crystal, displacements u(z) exp(iq m.x) along a direction m in the surface, with n its normal and s = q z,
obey Stroh's equations; in terms of (ab)_jk = Σ_il a_i C_ijkl b_l, Q = (mm), R = (mn), T = (nn), and τ = traction/q::

    du/ds = -i T^-1 R^T u + T^-1 τ
    dτ/ds = (Q - R T^-1 R^T) u - i R T^-1 τ

A thin layer is integrated by a matrix exponential and doubled until it is as thick as asked, in terms of the forces on
its two faces, which stay finite however thick it grows (the stiffness-matrix method of layered media: Rokhlin and
Wang, J. Acoust. Soc. Am. 112, 822 (2002)).

The basal face stands for any solid that is isotropic about the normal of its face.
"""

from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np
import scipy
from pydantic import Field

from continuum.inputs.arguments import ArgumentError, instance
from continuum.inputs.keys import OrInfinite, frozen
from continuum.inputs.tables import Fault, constraint
from continuum.model.fourier import Real
from continuum.model.grid import LONGEST, Grid
from continuum.model.substrates.substrate import MeanMode, PeriodicResponse, with_mean

THICK = 40.0
"""q depth above which a layer is a half-space to all digits: fields decay as exp(-a q z), a about 1/2 or more."""
LEAST_COMPRESSIBLE = 1e4
"""C11/C44 at most: of 16 digits so many are lost in the difference of C11 and C12; metals have 2 - 5."""
_THINNEST = 0.5
_DIRECTIONS = 64
OTHER_MEAN = 1.5
"""Largest factor between E* and 1: different means over directions differ by less (fcc metals: 1.2)."""


class CubicConstants(NamedTuple):
    """Elastic constants of a cubic crystal, referred to its cubic axes, all in one unit."""

    c11: float
    c12: float
    c44: float

    def require_stable(self) -> None:
        """Check that the crystal is stable: C11 > |C12|, C11 + 2 C12 > 0 and C44 > 0.

        Raises ValueError if it is not.
        """
        if not (self.c44 > 0 and self.c11 > abs(self.c12) and self.c11 + 2 * self.c12 > 0):
            msg = f"elastic constants of a stable crystal have C11 > |C12|, C11 + 2 C12 > 0 and C44 > 0, not {self}"
            raise ValueError(msg)
        if self.c11 > LEAST_COMPRESSIBLE * self.c44:
            most = f"{LEAST_COMPRESSIBLE:g} C44, or digits are lost"
            raise ValueError(f"C11 is at most {most}, not {self}: an isotropic layer of nu = 0.5 has no such limit")

    def stiffness_tensor(self) -> Real:
        """C_ijkl, shape (3, 3, 3, 3): isotropic part plus what the cubic axes add."""
        d = np.eye(3)
        c: Real = self.c12 * np.einsum("ij,kl->ijkl", d, d)
        c += self.c44 * (np.einsum("ik,jl->ijkl", d, d) + np.einsum("il,jk->ijkl", d, d))
        for i in range(3):
            c[i, i, i, i] += self.c11 - self.c12 - 2 * self.c44
        return c


def surface_stiffness(constants: CubicConstants, angle: Real, thickness: Real) -> Real:
    """K/q = 1/(q G_zz) of a layer on a rigid base, shape (n,): vertical traction per displacement, no lateral one.

    Parameters
    ----------
    constants : elastic constants; the result has their unit.
    angle : of the wavevector to the cubic axis <100> in the surface, in radians, shape (n,).
    thickness : q depth, positive, shape (n,); anything above :data:`THICK` is a half-space.

    Raises ValueError if the crystal is not stable.
    """
    constants.require_stable()
    c = constants.stiffness_tensor()
    angle, thickness = np.broadcast_arrays(angle, np.minimum(thickness, THICK))
    m = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=-1)
    n = np.array([0.0, 0.0, 1.0])
    q, r = np.einsum("pi,ijkl,pl->pjk", m, c, m), np.einsum("pi,ijkl,l->pjk", m, c, n)
    t_inverse = np.linalg.inv(np.einsum("i,ijkl,l->jk", n, c, n))
    r_t = r @ t_inverse
    stroh = np.empty((angle.size, 6, 6), dtype=np.complex128)
    stroh[:, :3, :3] = -1j * r_t.transpose(0, 2, 1)
    stroh[:, :3, 3:] = t_inverse
    stroh[:, 3:, :3] = q - r_t @ r.transpose(0, 2, 1)
    stroh[:, 3:, 3:] = -1j * r_t

    doublings = np.maximum(0, np.ceil(np.log2(thickness / _THINNEST))).astype(int)
    thin = thickness / 2.0**doublings
    across = scipy.linalg.expm(stroh * thin[:, None, None])
    a, b, c_, d = across[:, :3, :3], across[:, :3, 3:], across[:, 3:, :3], across[:, 3:, 3:]
    inverse_b = np.linalg.inv(b)
    # Forces on the upper and lower face: (top, cross; cross_below, bottom) times their displacements.
    top, bottom = d @ inverse_b, inverse_b @ a
    cross, cross_below = c_ - d @ inverse_b @ a, -inverse_b
    for step in range(int(doublings.max(initial=0))):
        more = np.flatnonzero(doublings > step)
        # Two equal layers, one on the other: no force acts on the face between them, whose displacements drop out.
        between = np.linalg.inv(top[more] + bottom[more])
        up, down = cross[more] @ between, cross_below[more] @ between
        top[more], bottom[more] = top[more] - up @ cross_below[more], bottom[more] - down @ cross[more]
        cross[more], cross_below[more] = -up @ cross[more], -down @ cross_below[more]
    return 1 / np.linalg.inv(top)[:, 2, 2].real


def directional_contact_modulus(constants: CubicConstants, angle: Real) -> Real:
    """E*(θ) = 2 K/q of the (100) half-space, for wavevectors at angles to the cubic axis <100>, any shape.

    E*(θ) has the period π/2 and is even: a series in cos 4θ, exact to rounding with 64 samples unless the crystal is
    close to an instability.

    Raises ValueError if the crystal is not stable.
    """
    # cos 4jθ is the Chebyshev polynomial T_j of cos 4θ.
    series = _directional_series(constants)
    return np.asarray(np.polynomial.chebyshev.chebval(np.cos(4 * np.asarray(angle)), series), dtype=np.float64)


@lru_cache(maxsize=64)
def _directional_series(constants: CubicConstants) -> Real:
    """The coefficients of E*(θ): of one crystal many ask."""
    samples = np.arange(_DIRECTIONS, dtype=np.float64) * (np.pi / 2 / _DIRECTIONS)
    series = np.fft.rfft(2 * surface_stiffness(constants, samples, np.array(THICK))).real / _DIRECTIONS
    # Each cosine but the first and the last stands for two of the 64 exponentials.
    series[1:-1] *= 2
    return np.asarray(series)


def contact_modulus(constants: CubicConstants, directions: int = 128) -> float:
    """Mean contact modulus E* = 1/<1/E*(θ)> of the (100) surface, in the unit of the constants.

    The mean of the compliance is the compliance of the axially symmetric part of the response.  E*(θ) is smooth and
    periodic, so that equal weights converge exponentially.

    Raises ValueError if the crystal is not stable.
    """
    angles = np.arange(directions, dtype=np.float64) * (np.pi / 2 / directions)
    return float(1 / np.mean(1 / directional_contact_modulus(constants, angles)))


def tensor_of(matrix: Real) -> Real:
    """C_ijkl, shape (3, 3, 3, 3), from Voigt's 6 x 6 matrix."""
    at = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])
    found: Real = np.asarray(matrix)[at[:, :, None, None], at[None, None]]
    return found


def rotated(tensor: Real, axes: Real) -> Real:
    """C_ijkl along other axes, orthogonal rows of any length, which the result's 1, 2 and 3 are."""
    r = np.asarray(axes) / np.linalg.norm(axes, axis=-1, keepdims=True)
    return np.asarray(np.einsum("ai,bj,ck,dl,ijkl->abcd", r, r, r, r, tensor))


def anisotropic_contact_modulus(tensor: Real, angle: Real) -> Real:
    """E*(θ) = 2 K/q of the half-space below the plane of axes 1 and 2 of any crystal, at angles from axis 1.

    E*(θ) = 2/(L⁻¹)_33 with the integral of Barnett and Lothe, L = (1/π) ∫ [(mm) - (mn) (nn)⁻¹ (nm)] dφ, over
    directions m and n that turn in the plane of wave and normal (Ting, Anisotropic Elasticity, 1996, 7.4).
    Equal weights converge exponentially, as the integrand has the period π.  Its mean is that of compliances, 1/<1/E*>.

    Parameters
    ----------
    tensor : C_ijkl along the axes of the face, shape (3, 3, 3, 3); the result has its unit.
    angle : of the wavevector, in radians, shape (n,).
    """
    theta, phi = np.asarray(angle)[:, None, None], np.arange(400)[:, None] * np.pi / 400
    along, up = np.concatenate([np.cos(theta), np.sin(theta), 0 * theta], axis=-1), np.array([0.0, 0.0, 1.0])
    m, n = np.cos(phi) * along + np.sin(phi) * up, np.cos(phi) * up - np.sin(phi) * along
    mm, mn, nn = (np.einsum("tpi,ijkl,tpl->tpjk", a, tensor, b, optimize=True) for a, b in ((m, m), (m, n), (n, n)))
    whole = np.mean(mm - mn @ np.linalg.inv(nn) @ mn.swapaxes(-1, -2), axis=1)
    return np.asarray(2 / np.linalg.inv(whole)[:, 2, 2])


class HexagonalConstants(NamedTuple):
    """Elastic constants of a hexagonal crystal, referred to its c axis as 3, all in one unit."""

    c11: float
    c12: float
    c13: float
    c33: float
    c44: float

    def require_stable(self) -> None:
        """Check that the crystal is stable: C11 > |C12|, C44 > 0 and C33 (C11 + C12) > 2 C13².

        Raises ValueError if it is not.
        """
        if not (self.c44 > 0 and self.c11 > abs(self.c12) and self.c33 * (self.c11 + self.c12) > 2 * self.c13**2):
            rules = "C11 > |C12|, C44 > 0 and C33 (C11 + C12) > 2 C13²"
            raise ValueError(f"elastic constants of a stable hexagonal crystal have {rules}, not {self}")

    def contact_modulus(self) -> float:
        """E* of the basal face, in the unit of the constants.

        E*² = 4 (C11 C33 - C13²)/C11 / (1/C44 + 2/(√(C11 C33) + C13)), from the point load of H. A. Elliott, Proc.
        Camb. Phil. Soc. 44, 522 (1948), in this form M. T. Hanson, J. Tribol. 114, 606 (1992), and A. Delafargue and
        F.-J. Ulm, Int. J. Solids Struct. 41, 7351 (2004).

        Raises ValueError if the crystal is not stable.
        """
        self.require_stable()
        normal = (self.c11 * self.c33 - self.c13**2) / self.c11
        shear = 1 / self.c44 + 2 / ((self.c11 * self.c33) ** 0.5 + self.c13)
        return float(2 * (normal / shear) ** 0.5)


class CubicLayer(PeriodicResponse, kind="crystal"):
    """Cubic crystal with a (100) surface, a half-space or a layer bonded to a rigid base.

    In Python its constants, in E*, are one argument: ``CubicLayer(depth, (c11, c12, c44), mean)``.
    :attr:`compressive_stiffness` is the mean mode of the layer itself.

    Examples
    --------
    >>> import continuum as c
    >>> crystal = c.CubicLayer(float("inf"), (1.5, 0.9, 0.6), "clamped")
    >>> along, diagonal = crystal.stiffness(c.Grid.square(8))[[0, 1], [1, 1]]
    >>> round(float(diagonal / along / 2**0.5), 3)  # 1 for an isotropic body
    0.947
    """

    example: ClassVar[Mapping[str, Any]] = {"c11": 1.2, "c12": 0.6, "c44": 0.5, "depth": 4.0, "mean": 0.3}
    newer: ClassVar[frozenset[str]] = frozenset({"axis"})

    c11: Annotated[float, Field(gt=0, le=LONGEST)]
    """elastic constant, in E*"""
    c12: Annotated[float, Field(ge=-LONGEST, le=LONGEST)]
    """elastic constant, in E*"""
    c44: Annotated[float, Field(gt=0, le=LONGEST)]
    """elastic constant, in E*"""
    mean: MeanMode
    """stiffness of the mean displacement: "clamped" (rigid base), "free", or a number in E*/a0"""
    depth: OrInfinite = np.inf
    """thickness of a layer bonded to a rigid base, in a0; a half-space if not given"""
    axis: float = np.pi / 4
    """angle of the x axis of the grid to the cubic axis <100>, in radians; by default the sides of the grid are <110>,
    those of the square of surface atoms"""

    def __init__(self, depth: float, constants: Sequence[float], mean: MeanMode, axis: float = np.pi / 4) -> None:
        values, names = frozen(constants), ("c11", "c12", "c44")
        if not isinstance(values, tuple) or len(values) != 3:
            raise ArgumentError("constants", constants, "three elastic constants, (C11, C12, C44), in E*")
        try:
            self._take(**dict(zip(names, values, strict=True)), depth=depth, mean=mean, axis=axis)
        except ArgumentError as error:
            if error.name in names:
                raise ArgumentError("constants", constants, f"{error.name}: {error.allowed}") from None
            raise

    @constraint
    def _stable(self) -> Iterator[Fault]:
        if not (self.c11 > abs(self.c12) and self.c11 + 2 * self.c12 > 0):
            yield Fault(("c12",), "C11 > |C12| and C11 + 2 C12 > 0, or the crystal is not stable")
            return
        try:
            modulus = contact_modulus(self.constants)
        except ValueError as error:
            yield Fault(("c44",), f"the ratio of constants that a crystal has: {error}")
            return
        if not 1 / OTHER_MEAN <= modulus <= OTHER_MEAN:
            allowed = f"constants of a contact modulus of about 1, in E*; of these it is {modulus:.6g}"
            yield Fault(("c11",), allowed, "divide them, and all tractions, by that")

    @property
    def constants(self) -> CubicConstants:
        """C11, C12 and C44, in E*."""
        return CubicConstants(self.c11, self.c12, self.c44)

    @property
    def compressive_stiffness(self) -> float:
        """Pressure per mean displacement, C11/depth, in E*/a0."""
        return self.constants.c11 / self.depth

    def stiffness(self, grid: Grid) -> Real:
        """K_q over the half spectrum, in E*/a0.

        Costs about 50 µs for each mode whose wavelength exceeds a sixth of the depth; other modes are those of a
        half-space.
        """
        qx, qy = np.broadcast_arrays(*instance("grid", grid, Grid).wavevectors)
        q = grid.wavenumber
        angle = np.arctan2(qy, qx) + self.axis
        stiffness_q = q * directional_contact_modulus(self.constants, angle) / 2
        long_wave = q < THICK / self.depth
        grid.mean_mode(long_wave)[...] = False  # its value follows below
        layer = surface_stiffness(self.constants, angle[long_wave], q[long_wave] * self.depth)
        stiffness_q[long_wave] = q[long_wave] * layer
        return with_mean(grid, stiffness_q, self.mean)
