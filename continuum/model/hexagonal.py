"""Response of the basal face of a hexagonal crystal, or of any solid that is isotropic about the normal of its face."""

from typing import NamedTuple


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
