"""The crystal: an fcc(100) slab whose surface atoms are the points of a grid, and its interatomic model.

Descriptions only: nothing here starts LAMMPS.
"""
