"""Output: tables, pages, figures, progress and errors.

The only subpackage that draws and prints; figures are made from stored results alone.  Files that cannot be written
raise OutputError.
"""
