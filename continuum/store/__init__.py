"""Results on disk: HDF5 files, where they come from, single runs, and sweeps of many with their workers and tables.

Whatever leaves is written whole or not at all.  The only room that knows HDF5.
"""
