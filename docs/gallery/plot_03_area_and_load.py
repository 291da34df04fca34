"""
Area against load
=================

The paper's Figure 2 at small size. Without adhesion the repulsive area is proportional to the load; adhesion
shifts the line to the left, and where it crosses zero the surfaces hold one another without being pushed.
"""

import numpy as np
from matplotlib import pyplot as plt

import continuum as c

heights = c.SelfAffine(0.8, 0.1, 4, 64).synthesise(c.Grid.square(128), np.random.default_rng(1))
figure, axis = plt.subplots()
for length, marker in ((0.0, "o"), (0.0005, "s"), (0.002, "^"), (0.005, "v")):
    contact = c.Contact(heights, wall=c.LennardJonesSpline(adhesion_length=length))
    states = [state for state in contact.path(area=[0.02, 0.04, 0.07, 0.1]) if state.converged]
    load = [state.load / contact.moments.rms_slope for state in states]
    area = [state.area_rep for state in states]
    axis.plot(load, area, marker + "-", mfc="none", label=rf"$\ell_a$ = {length:g} $a_0$")
axis.axvline(0, color="0.7", linewidth=0.6, zorder=0)
axis.set(xlabel=r"load $N/(h'_\mathrm{rms}E^*A_0)$", ylabel=r"repulsive area $A_\mathrm{rep}/A_0$", ylim=(0, None))
axis.locator_params(axis="x", nbins=6)
axis.legend()
