"""One run: from an input, along its path, to a stored result, and what can be measured on that later.

The only room that knows the whole chain, from the tables of a file to the record on disk.
"""
