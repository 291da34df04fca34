"""
Contact maps with increasing adhesion
=====================================

The same surface at 4 % repulsive area, with three strengths of adhesion. The attracted rim (black) widens while the
repulsive patches (orange) hardly change, as in the paper's Figure 1.
"""

import numpy as np
from matplotlib import pyplot as plt

import continuum as c
from continuum.show.plot import PAGE, contact_image

heights = c.SelfAffine(0.8, 0.1, 8, 64).synthesise(c.Grid.square(128), np.random.default_rng(1))
figure, axes = plt.subplots(1, 3, figsize=(PAGE, 2.6), sharey=True)
for axis, length in zip(axes, (0.0005, 0.005, 0.05), strict=True):
    state = c.Contact(heights, wall=c.LennardJonesSpline(adhesion_length=length)).press(area=0.04).require()
    contact_image(axis, state.contact_map, (128, 128))
    axis.set(xlabel="x ($a_0$)", title=rf"$\ell_a$ = {length:g} $a_0$: $N/(E^*A_0)$ = {state.load:.1e}")
axes[0].set_ylabel("y ($a_0$)")
