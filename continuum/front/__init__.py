"""The public functions and classes of ``continuum``: contacts, runs, sweeps, predictions.

Each command calls one of them.  Results show themselves as small tables in a notebook.
"""
