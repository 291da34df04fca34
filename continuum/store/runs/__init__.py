"""One run: from an input, along its path, to a stored result and measurements on it.

It covers the whole chain from the tables of a file to the record on disk.
"""
