"""LAMMPS: the directories that it runs, starting it in three ways, and reading back what it left.

The only room that imports the library or starts a program.
"""
