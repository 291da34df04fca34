"""A tension that a contact does not hold: the message says which it does."""

from __future__ import annotations

import re

import pytest

import atomistic as a
import continuum as c

WALL = c.LennardJonesSpline(adhesion_length=0.005)


@pytest.mark.parametrize("pressures", [[-0.5], [0.01, -0.05], [-0.01, -0.03]])
def test_flat_on_flat_holds_the_largest_tension_of_the_law(pressures: list[float]) -> None:
    # Flat to a ten-thousandth, all points pull alike: (2/27) of the range, 0.0257 E*.  A period of 8 a0 is too short
    # for the surface to part wave by wave before.
    contact = c.Contact(c.sine(c.Grid.square(8), 1e-4, (1, 0)), wall=WALL)
    with pytest.raises(c.NotConvergedError, match="does not hold a mean tension of") as error:
        a.deck(contact, pressures=pressures, depth=4)
    held = float(re.search(r"largest that it holds is ([\d.]+) E\*", str(error.value)).group(1))
    assert held == pytest.approx(WALL.largest_tension, rel=0.011)  # looked for to a hundredth
    assert held <= WALL.largest_tension * 1.0005  # printed with three digits
    a.deck(contact, pressures=[-0.98 * held], depth=4)


def test_what_does_not_attract_holds_no_tension() -> None:
    contact = c.Contact(c.sine(c.Grid.square(8), 0.05, (1, 0)), wall=c.LennardJonesSpline(0.0))
    with pytest.raises(c.NotConvergedError, match="it holds none"):
        a.deck(contact, pressures=[-0.01], depth=4)
