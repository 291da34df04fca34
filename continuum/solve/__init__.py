"""One equilibrium: the minimum of a quadratic form in Fourier space plus a sum over points.

Smooth laws have conjugate gradients with steps of coarser grids, bounds have a dual of their own; both are mathematics
over a back end, which owns arrays, transforms and threads.  This room knows no word of contact.
"""
