"""What people see: tables, pages, figures, progress and errors.

The only room that draws and prints; figures are made from stored results alone.  What cannot be written where it is
asked for is an OutputError.
"""
