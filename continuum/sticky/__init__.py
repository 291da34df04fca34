"""Is my surface sticky?  Measured topographies, their roughness, materials, and what each theory says of them.

Everything is in SI units, where it begins with a file of an instrument, and every number names its source.
"""
