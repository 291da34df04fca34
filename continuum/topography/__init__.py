"""Measured topographies: reading, artefacts, mending, roughness, line scans.

Lengths are in m, as files of instruments give them; the statistics hold in any one unit.
"""
