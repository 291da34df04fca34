"""Table and figure of the trace of a wall in a script."""

import numpy as np
from matplotlib.figure import Figure

from atomistic.lammps.trace import WallTrace
from continuum.inputs.arguments import ArgumentError
from continuum.show.plot import PAGE, SERIES, letter_panels, new_axes, styled
from continuum.store.sheet import Column, Entry, Sheet

_UNITS = {"area_rep": "", "temperature": "K"}
_KINDS = {"load": "nN", "lateral": "nN", "pull": "nN", "distance": "Å", "offset": "Å", "smallest": "Å"}


def _unit(name: str) -> str:
    return _UNITS.get(name, _KINDS.get(name.split("_")[0], "eV"))


def trace_sheet(trace: WallTrace) -> Sheet:
    """Mean, standard error, least and largest value of each quantity; and the friction of a wall that slides."""
    rows: list[tuple[Entry, ...]] = []
    for name in (name for name in trace if name != "step"):
        if not np.any(trace[name]):
            continue
        rows.append((name, *trace.mean(name), float(trace[name].min()), float(trace[name].max()), _unit(name)))
    for along in ("x", "y"):
        if np.ptp(trace[f"offset_{along}"]) > 0:
            try:
                rows.append((f"lateral_{along}/load", *trace.friction(along), "", "", ""))
            except ArgumentError:  # without a load there is none
                continue
    columns = ("quantity", Column("mean"), Column("±"), "least", "largest", "unit")
    return Sheet.of(f"{trace.samples} samples of the wall", columns, rows)


@styled
def draw_wall_trace(trace: WallTrace) -> Figure:
    """Friction, load and distance of each sample: against the way of a wall that slides, else against the step."""
    figure, axes = new_axes(PAGE, 2.9, 1, 3)
    along = max("xy", key=lambda name: float(np.ptp(trace[f"offset_{name}"])))
    slides = float(np.ptp(trace[f"offset_{along}"])) > 0
    at = trace[f"offset_{along}"] if slides else trace["step"]
    names = (f"lateral_{along}", "load", "distance")
    for axis, name, label, colour in zip(
        axes, names, ("lateral force (nN)", "load (nN)", "distance (Å)"), (SERIES[5], SERIES[0], SERIES[1]), strict=True
    ):
        axis.plot(at, trace[name], "-", color=colour, lw=0.5)
        axis.set(xlabel=f"way along {along} (Å)" if slides else "time step", ylabel=label)
    letter_panels(axes, ("friction", "load", "height"))
    return figure
