"""The outside world: input files with their lines, arrays of users, results on disk, where results come from.

Whatever enters is checked here, and whatever leaves is written whole or not at all.  The only room that knows HDF5.
"""
