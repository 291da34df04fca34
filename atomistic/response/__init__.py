"""How a slab answers: its force constants, measured in LAMMPS or exact, and the Green's function of its surface.

What is measured once is kept on disk and found again by what it depends on.
"""
