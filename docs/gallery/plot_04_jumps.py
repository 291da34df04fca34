"""
Jump-in and pull-off
====================

A strongly adhesive wave is brought near and taken away again. It jumps into contact, and on the way back it holds on
beyond the gap at which it jumped in: two branches, with a jump on each. A jump is no state: there are no points on it.
"""

import numpy as np
from matplotlib import pyplot as plt

import continuum as c

heights = c.sine(c.Grid.square(128), 1.5, (1, 0))
contact = c.Contact(heights, wall=c.LennardJonesSpline(adhesion_length=0.05))
gaps = np.concatenate([np.arange(5.0, 2.0, -0.1), np.arange(2.1, 5.0, 0.1)])
states = [state for state in contact.path(mean_gap=gaps) if state.converged]
figure, axis = plt.subplots()
for branch, style in (("approach", "."), ("retract", "s")):
    way = [state for state in states if state.branch == branch]
    axis.plot([state.mean_gap for state in way], [state.load for state in way], style, mfc="none", label=branch)
axis.axhline(0, color="0.7", linewidth=0.6, zorder=0)
axis.set(xlabel="mean gap ($a_0$)", ylabel="load $N/(E^*A_0)$")
axis.legend()
