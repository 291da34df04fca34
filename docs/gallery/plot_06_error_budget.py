"""
What each approximation costs
=============================

One wall at one mean gap on five models: half-space, layer, cubic layer, lattice, and atoms in LAMMPS. Each model
differs from the next by one approximation, so each difference of the load has one cause. ``atomistic validate`` does
this comparison with bounds and error estimates.
"""

import tempfile

import numpy as np
from matplotlib import pyplot as plt

import atomistic as a
import continuum as c
from atomistic.ladder.rungs import CONTINUUM_RUNGS, response_of
from atomistic.response.cache import slab_response

model, heights = a.Springs(), c.SelfAffine(0.8, 0.1, 8, 16).synthesise(c.Grid.square(32), np.random.default_rng(2))
contact = c.Contact(heights, wall=c.LennardJonesSpline(0.0))
atoms = a.run_deck(a.deck(contact, model, separation=1.15).write(tempfile.mkdtemp() + "/deck")).steps[-1]
responses = [response_of(rung, slab_response(model, 32), model.elastic_constants) for rung in CONTINUUM_RUNGS]
contacts = [c.Contact(heights, wall=contact.wall, substrate=response) for response in responses]
loads = [one.press(mean_gap=atoms.mean_gap).require().load for one in contacts] + [atoms.load]
figure, axis = plt.subplots()
axis.barh(["depth", "anisotropy", "discreteness", "nonlinearity"], 100 * np.abs(np.diff(loads)) / atoms.load_rep)
axis.invert_yaxis()
axis.set(
    xlabel=r"difference of the load (% of $N_\mathrm{rep}$)", title=rf"at $A_\mathrm{{rep}}/A_0$ = {atoms.area_rep:.2f}"
)
