"""Steps that solve the equations of a stiff contact, for a wall that is stiffer than the substrate's shortest waves.

With the stiffness D of the wall on the contact, where it is stiff, and G = 1/K, Newton's equation (K + D) s = g is one
for a traction y on the contact alone::

    (1/D + G) y = G g  on the contact,   y = 0  elsewhere
    s = G (g - y)  off the contact,   y/D  on it

A few conjugate gradients solve it, preconditioned by K and the stiffness k of the contact in series, K/(1 + K/k): about
the inverse of 1/k + G, with a kernel of a few points, so that it needs no transform.  What they leave is put on the
contact.  As attraction takes no part, s is a direction only, conjugate to the last one under K + φ''.

A step takes one and a half pairs of transforms, and one for each conjugate gradient; no coarser grid takes part.  Under
a wall as soft as the substrate, or with much contact, steps of coarser grids (:mod:`continuum.solve.smooth`) cost less.
The mean of u is held, or G would have a mean that is large or infinite.
"""

import numpy as np

from continuum.solve.conjugate import Line
from continuum.solve.grids import StiffContact
from continuum.solve.line_search import Step

STIFF = 0.1
"""Points belong to the contact where the wall is stiffer than this part of K of the stiffest wave.

Of a quantile of the stiffnesses instead, the tail of a long-ranged attraction counted as contact, and two states of ten
did not descend.
"""
STIFFEST = 1.5
"""The contact's own step is made where the mean stiffness on the contact is at least so many K of the stiffest wave of
the finest grid.  Under the paper's law, which is softer, it took 2.1 times the pairs."""
FELT, LARGEST = 0.01, 0.12
"""It is made where the wall is stiffer than a part of that K on at most this share of the points: the step leaves out
what an attraction holds around the contact, and is too long where that is much.  With a tenth for the hundredth three
states of a sharp spline took 1.15 to 1.4 times the pairs."""
REDUCTION, DIRECTIONS = 0.1, 8
"""A step's equations are solved to this part of their residual, or in so many directions."""
PATIENCE, SLOW = 5, 0.5
"""Where so many iterations leave more than this part of the residual, a rim snaps, for which coarser grids do more."""


def pays(contact: StiffContact, depth: int) -> bool:
    """Whether the state at hand is one for the contact's own step, on a grid so often made coarser.

    K of the stiffest wave halves with each coarser grid.  A wall that is stiff for that alone is not for the finest
    one, and these steps on coarser ones took 1.06 times the pairs in all (the paper's law on 1024²).
    """
    share, stiffness = contact.find(STIFF, FELT)
    return 0 < share <= LARGEST and stiffness >= STIFFEST * 2**depth


class ContactSteps:
    """Steps of the contact: what :func:`continuum.solve.smooth._descend` asks in each iteration, while they pay."""

    def __init__(self, contact: StiffContact, depth: int) -> None:
        self.contact, self.depth, self.residuals = contact, depth, list[float]()

    def gradient(self, line: Line, step: Step, *, complete: bool) -> float:
        """Finish the last step: g, which is ``complete`` or lacks the traction of the wall; its root mean square."""
        del line
        self.residuals.append(self.contact.gradient(step.length, complete=complete))
        return self.residuals[-1]

    def direction(self, line: Line, step: Step) -> tuple[Line, float] | None:
        """The next direction, and <φ'' d d>; None where such steps pay no more."""
        if _slow(self.residuals) or not pays(self.contact, self.depth):
            return None
        line = _direction(self.contact, line, step.slope)
        # Far from equilibrium the wall is stiffer than single precision resolves: it does not descend.
        return (line, self.contact.new_direction(line.beta)) if -np.inf < line.slope < 0 else None


def _slow(residuals: list[float]) -> bool:
    """Whether the residual has hardly fallen over the last few iterations."""
    return len(residuals) > PATIENCE and not residuals[-1] < SLOW * residuals[-1 - PATIENCE]


def _direction(contact: StiffContact, last: Line, after: float) -> Line:
    """Solve the equations of the contact; the next direction is conjugate to the last one under K + φ''."""
    contact.set_up()
    beta = 0.0
    residual = first = contact.precondition()
    for _ in range(DIRECTIONS):
        contact.advance(residual / contact.curvature(beta))
        before, residual = residual, contact.precondition()
        if residual <= REDUCTION**2 * first:
            break
        beta = residual / before
    gs, ss, sd, pull, dd = contact.step()
    curvature = last.curvature + dd if last.curvature else 0.0  # no direction before the first
    beta = max(0.0, (sd + pull) / curvature) if curvature > 0 else 0.0
    if beta * after >= gs:
        beta = 0.0
    return Line(beta, beta * after - gs, ss - 2 * beta * sd + beta * beta * last.curvature)
