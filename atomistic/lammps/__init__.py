"""LAMMPS: write decks, run them in three ways, and read their results.

The only subpackage that imports the library or starts a program.
"""
