"""Figures and pages of a validation and of a crystal, on the means of :mod:`continuum.show`."""
