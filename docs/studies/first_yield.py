"""First yield of copper (111) under a rigid sphere, beside a published order of magnitude.

``python -m docs.studies.first_yield --into docs/measured`` runs ``inputs/lammps/yield.toml`` (a minute on one core) and
writes ``first-yield.csv``, a row for each equilibrium, and its figure.  The table of docs/studies/first_yield.md is
made of that file.

Expected, before the first run: crystals of nickel and molybdenum were found to slip first at a shear stress below the
indenter of about G/7 (L. Wang et al., Scripta Mater. 65, 179 (2011)), by the relation of Hertz, where the largest shear
stress is 0.465 of the mean contact pressure (nu = 0.3).  With G of polycrystalline copper, the mean of the bounds of
Voigt and Reuss of this potential, the mean contact pressure at first yield is then 15 GPa.  The order of magnitude
holds if the pressure found lies within a factor of three, 5 to 44 GPa: the sphere has 12 a0, its contact some dozens of
atoms, and the crystal is at rest.  A pressure outside, or no yield down to the last step, refutes it.
"""
