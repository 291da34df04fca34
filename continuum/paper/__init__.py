"""The reproduction of the paper, from stored sweeps: its figures, its claims with verdicts, and its worked examples.

Also the dispute about it: the work of adhesion at which surfaces turn sticky, beside the theory of each camp.  A sweep
that has no points for what is asked of it is a FigureError.
"""
