"""What presses on what: a periodic grid, a rough wall above it, the law between wall and surface, an elastic substrate.

:class:`~continuum.model.problem.ContactProblem` puts the four together and says what their energy is; all signs live
there.  Nothing here minimises, and nothing is remembered: frozen data, and functions of arrays.
"""
