"""Equations of the paper, and classical solutions of smooth and of rough contact.

Functions of numbers, in any consistent units.  They import nothing else of this package, and the solver is tested
against them.
"""
