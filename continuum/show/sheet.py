"""Tables, which moved to :mod:`continuum.sheet`, where results can use them, too."""

from continuum.sheet import Column as Column
from continuum.sheet import Entry as Entry
from continuum.sheet import Sheet as Sheet
from continuum.sheet import pairs as pairs
