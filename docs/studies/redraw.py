"""Draw the figures of stored sweeps anew from the tables beside them: `python -m docs.studies.redraw docs/measured`.

For those whose files are not kept.  Figures that show more than their table, such as maps, are left as they are.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from pandas import read_csv

from continuum.paper.dispute import draw_crossover_table
from continuum.paper.figures import FIGURES
from continuum.show import plot


def redrawn(table: Path) -> bool:
    """Draw the figure of a table, paper-SWEEP-FIGURE.csv or dispute-WHAT.csv; False if it cannot be drawn from that."""
    stem = table.name.partition(".")[0]  # the largest tables are compressed: .csv.gz
    names = [name for name in FIGURES if stem.endswith(f"-{name}") and not FIGURES[name].whole]
    if stem.startswith("dispute-"):
        draw = draw_crossover_table
    elif names:
        draw = plot.styled(FIGURES[max(names, key=len)].draw)
    else:
        return False
    try:
        figure = draw(read_csv(table))
    except KeyError:  # the figure shows other columns since
        return False
    with plot.written_as(["png"]):
        plot.save_figure(figure, table.with_name(stem), own=True)
    return True


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    for table in sorted([*folder.glob("paper-*.csv*"), *folder.glob("dispute-*.csv")]):
        sys.stdout.write(f"{table.stem}: {'drawn' if redrawn(table) else 'left'}\n")


if __name__ == "__main__":
    main()
