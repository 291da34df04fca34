"""Explicit fcc(100) atoms under a rigid rough wall, in LAMMPS: the check on the Green's-function model.

Units, signs and names are those of :mod:`continuum`, with one addition: a surface atom stands for one point
of the grid, of area a0², so that the force of the wall on it is traction x a0² and its wall energy is energy
per area x a0². Forces and displacements of atoms are vectors, positive towards the wall (+z); tractions are
positive in compression.

Arrays over the atoms of a slab have the shape (layers, nx, ny) or (layers, nx, ny, 3): layer 0 is the
surface, and atom [0, i, j] is the point [i, j] of the grid.
"""
