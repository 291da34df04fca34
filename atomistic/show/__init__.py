"""Figures and pages of validations, crystals and decks, based on :mod:`continuum.show`."""
