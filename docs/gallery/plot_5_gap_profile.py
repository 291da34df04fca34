"""
The gap beside a contact
========================

How the gap opens with the distance from the edge of a patch decides how wide the attracted rim is. The paper
estimates it by Eq. (S-1), from the slope and the mean diameter of the patches alone.
"""

import numpy as np
from matplotlib import pyplot as plt

import continuum as c
from continuum.measure.profile import gap_profile
from continuum.theory import paper

grid = c.Grid.square(256)
heights = c.SelfAffine(0.8, 0.1, 16, 128).synthesise(grid, np.random.default_rng(1))
state = c.Contact(heights, wall=c.LennardJonesSpline(0.0)).press(area=0.04).require()
found = gap_profile(grid, state.gap, state.contact_map == 2, farthest=20, zero_gap=1.0)
x = found.distance
figure, axis = plt.subplots()
axis.loglog(x, found.gap, "o", mfc="none", label="solver, mean over the edge")
axis.loglog(x, paper.gap_outside_contact(x, 0.1, state.measure().diameter), label="Eq. (S-1)")
axis.set(xlabel="distance from the edge ($a_0$)", ylabel="gap above that of the edge ($a_0$)")
axis.legend()
