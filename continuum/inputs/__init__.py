"""Inputs: one class for a table of TOML and for Python's arguments, with its bounds, units and errors.

Files are read with their lines, so that a message names file, line, key and what is allowed.  Nothing here knows what
is computed: each description stands where it is used, and takes its base class from here.
"""
