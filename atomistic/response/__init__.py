"""Linear response of a slab: its force constants, measured in LAMMPS or exact, and the Green's function of its surface.

Measurements are stored on disk under a hash of all that they depend on.
"""
