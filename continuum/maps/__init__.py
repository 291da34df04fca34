"""Measured topographies: reading, artefacts, mending, roughness, line scans; and the verdict on a contact of them.

Lengths are in m, as files of instruments give them; the statistics hold in any one unit.
"""
