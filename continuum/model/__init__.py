"""The contact problem: a periodic grid, a rough wall, the law between wall and surface, an elastic substrate.

:class:`~continuum.model.problem.ContactProblem` combines the four and defines their energy and all signs.  Nothing
here minimises or keeps state: there are only frozen dataclasses and functions of arrays.
"""
