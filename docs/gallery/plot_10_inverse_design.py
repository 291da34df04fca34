"""
Lower a threshold by removing material
======================================

Two linear solves give the derivative of the threshold with respect to the height of every point. It shows where a tool
2 a0 wide lowers the threshold most by removing 0.1 a0: on the contacts (outlined), which hold the surfaces apart. The
derivative predicts a reduction by a fifth; a search shows the actual reduction.
"""

import numpy as np
from matplotlib import pyplot as plt

import continuum as c

grid = c.Grid.square(96)
heights = c.SelfAffine(0.8, 0.1, 8, 32).synthesise(grid, np.random.default_rng(1))


def wall(work):
    """An attraction of one range and any strength."""
    return c.attraction_on_core("spline", work, 0.4, core_stiffness=5.0)


def threshold(heights):
    """The work of adhesion above which the surface sticks, at 4 % of the area."""
    return c.Contact(heights, wall(0.002)).find_threshold(wall, area=0.04).require()


def by_tool(field):
    """A field as a tool 2 a0 wide leaves it."""
    return grid.inverse(np.exp(-((grid.wavenumber * 2) ** 2) / 2) * grid.forward(field))


first = threshold(heights)
gain = by_tool(first.gradient()) / first.work  # removing material of the upper wall increases its heights
best, amount = np.argsort(gain, axis=None), np.zeros(grid.shape)
amount.flat[best[: np.searchsorted(np.cumsum(-0.1 * gain.flat[best]), 0.2) + 1]] = 0.1
gone = by_tool(amount)
ratio = threshold(heights + gone).work / first.work
figure, axes = plt.subplots(1, 2, figsize=(7.0, 3.0))
for axis, values, colours, least, most in ((axes[0], gain, "RdBu_r", -0.01, 0.01), (axes[1], gone, "Greys", 0, 0.1)):
    figure.colorbar(axis.imshow(values, colours, vmin=least, vmax=most, origin="lower"), ax=axis, shrink=0.8)
    axis.contour(first.state.contact_map == 2, [0.5], colors="black", linewidths=0.4)
    axis.set(xlabel="y ($a_0$)", ylabel="x ($a_0$)")
axes[0].set_title("derivative of $w_c$ over $w_c$ (1/$a_0$)")
axes[1].set_title(f"removed ($a_0$): $w_c$ x {ratio:.2f}")
