"""What theory says: every equation of the paper, and the classical solutions of smooth and of rough contact.

Plain functions of numbers, in any consistent units.  They know nothing of grids and solvers, which are held against
them, and import nothing of ours.
"""
