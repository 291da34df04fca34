"""Public functions and classes of ``continuum``, and the commands made from them.

Results show themselves as small tables in a notebook.
"""
