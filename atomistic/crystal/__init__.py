"""The crystal: an fcc(100) slab whose surface atoms are the points of a grid, and what holds its atoms together.

Pure descriptions: nothing here starts LAMMPS.
"""
