"""Equilibrium of the atoms under the wall, from the lattice's own linear response or by LAMMPS' minimisers."""
