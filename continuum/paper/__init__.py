"""The reproduction of the paper, from stored sweeps: its figures, its claims with verdicts, and its worked examples.

Also the dispute about it: the work of adhesion at which surfaces become sticky, compared with each theory.  A sweep
without the points for a figure raises FigureError.
"""
