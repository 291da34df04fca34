"""
Any atoms under a rough wall
============================

The wall is a calculator of ASE, which we add here to that of copper (111). The optimizer measures the response of the
slab to forces once, and then needs a few evaluations for each state. As the wall approaches, atoms that were out of
range (white) are attracted (black) and then repelled (orange).
"""

import numpy as np
from ase.build import fcc111
from ase.calculators.emt import EMT
from ase.calculators.mixing import SumCalculator
from ase.constraints import FixAtoms
from ase.optimize import LBFGS
from matplotlib import pyplot as plt

import atomistic as a
import continuum as c

slab = fcc111("Cu", (8, 8, 4), vacuum=8, periodic=True, orthogonal=True)
slab.set_constraint(FixAtoms(mask=slab.get_tags() > 2))  # the two lowest layers
slab.calc = EMT()
LBFGS(slab, logfile=None).run(fmax=1e-2)  # at rest, without a wall

heights = c.SelfAffine(0.8, 0.15, 4, 8).synthesise(c.Grid.square(16, 0.5), np.random.default_rng(1))
law = c.LennardJonesSpline(adhesion_length=0.01)
atoms, response, loads, separations = slab.copy(), None, [], [1.4, 1.3, 1.2, 1.1, 1.0]
figure, axes = plt.subplots(1, 3, figsize=(7.0, 2.6), width_ratios=(2, 2, 3), layout="constrained")
for separation in separations:
    wall = a.RoughWall(heights, slab, separation, law, a0=2.55, contact_modulus=0.85)  # Å, eV/Å³
    atoms.calc = SumCalculator([EMT(), wall])
    relaxation = a.GreensRelaxation(atoms, logfile=None, response=response)
    relaxation.run(fmax=1e-2)
    response = relaxation.response
    loads.append(-wall.results["forces"][:, 2].sum())
    axis = axes[{1.3: 0, 1.1: 1}.get(separation, 2)]
    if axis is not axes[2]:
        colours = np.array(["white", "black", "C1"])[wall.results["contact"][wall.surface]]
        axis.scatter(*atoms.positions[wall.surface, :2].T, s=70, c=colours, edgecolors="0.5")
        axis.margins(0.08)
        axis.set(aspect="equal", xlabel="x (Å)", title=f"separation {separation} $a_0$")
axes[0].set_ylabel("y (Å)")
axes[2].plot(separations, loads, "o-", mfc="none")
axes[2].axhline(0, color="0.7", linewidth=0.6, zorder=0)
axes[2].set(xlabel="separation ($a_0$)", ylabel="load (eV/Å)")
