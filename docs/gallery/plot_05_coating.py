"""
A coating
=========

The same rough wall presses on a half-space, and on half-spaces with a film that is ten times stiffer or more compliant.
Waves much longer than the thickness of the film feel the half-space below it.
"""

import numpy as np
from matplotlib import pyplot as plt

import continuum as c

heights = c.SelfAffine(0.8, 0.05, 8, 64).synthesise(c.Grid.square(128), np.random.default_rng(1))
bodies = {"half-space": c.HalfSpace()}
for name, factor in (("stiff film, 2 $a_0$", 10.0), ("compliant film, 2 $a_0$", 0.1)):
    # Thickness, E* and Poisson's ratio of the film; E* and Poisson's ratio of what it lies on.
    bodies[name] = c.LayeredHalfSpace([(2.0, factor, 0.3)], base=(1.0, 0.3))
figure, axis = plt.subplots()
for (name, body), marker in zip(bodies.items(), "osv", strict=True):
    contact = c.Contact(heights, wall=c.HardWall(), substrate=body)
    states = [state.require() for state in contact.path(mean_gap=[0.6, 0.5, 0.4, 0.3, 0.2])]
    axis.plot([one.load for one in states], [one.area_rep for one in states], marker + "-", mfc="none", label=name)
axis.set(xscale="log", xlim=(1e-4, 1e-2), ylim=(0, None))
axis.set(xlabel="load $N/(E^*A_0)$", ylabel=r"repulsive area $A_\mathrm{rep}/A_0$")
axis.legend()
