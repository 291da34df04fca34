"""
The threshold of stickiness
===========================

The work of adhesion above which a surface sticks: at this threshold the load at 2 % of the area is zero. A search
finds it for four surfaces, in units of *U*, the elastic energy of full contact per area.
"""

import numpy as np
from matplotlib import pyplot as plt

import continuum as c

grid, reach = c.Grid.square(96), 0.4


def wall(work):
    """An attraction of one range and any strength."""
    return c.attraction_on_core("spline", work, reach, core_stiffness=5.0)


figure, axis = plt.subplots()
for i, hurst in enumerate((0.3, 0.8)):
    for seed, marker in ((1, "o"), (2, "s")):
        heights = c.SelfAffine(hurst, 0.1, 8, 24).synthesise(grid, np.random.default_rng(seed))
        energy = 0.25 * grid.inner_q(grid.forward(heights), grid.wavenumber * grid.forward(heights))
        found = c.Contact(heights, wall(0.002)).find_threshold(wall, area=0.02).require().work / energy
        works = np.array([0.6, 0.8, 1.0, 1.2, 1.4]) * found
        loads = [c.Contact(heights, wall(w * energy)).press(area=0.02).require().load / energy for w in works]
        label = f"$H$ = {hurst:g}, surface {seed}: $w_c$ = {found:.2f} $U$"
        axis.plot(works, loads, marker + "-", mfc="none", color=f"C{i}", label=label)
axis.axhline(0, color="0.7", linewidth=0.6, zorder=0)
axis.set(xlabel="work of adhesion $w/U$", ylabel="load $N a_0/(U A_0)$", ylim=(None, 0.12))
axis.legend()
