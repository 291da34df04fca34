"""Compile what the tests import, and the solver's loops, before several processes of tests begin: `make test`.

Both are kept on disk.  Two processes that begin together each compile all of it: 43 s of CPU, and 33 s after this.
"""

from __future__ import annotations

import matplotlib.pyplot
import pandas
import xarray

from continuum.front.cli import app
from continuum.path.loading import solve
from continuum.solve.solution import Settings
from tests.problems import Rough

USED = matplotlib.pyplot, pandas, xarray, app
"""Imported so that their modules are compiled."""


def main() -> None:
    for n, hard in ((64, False), (64, True), (512, False)):
        solve(Rough(n, hard=hard).problem(), "repulsive-area", 0.05, Settings(1e-7)).require()


if __name__ == "__main__":
    main()
