"""
Jump-in and pull-off
====================

A strongly adhesive wave approaches and retracts. It jumps into contact, and on retraction it stays in contact beyond
the gap at which it jumped in. No equilibrium exists during a jump, so no points are shown there.
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
