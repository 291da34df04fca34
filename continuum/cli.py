"""The command ``continuum``."""

from collections.abc import Sequence

from cyclopts import App

from continuum.options import program, run_program

COMMANDS = {
    "check": "validate an input file of a run or a sweep, and print what it amounts to and what it will cost",
    "run": """follow a loading path and store areas, loads, contact maps and jumps

[loading] of the input says how: control (separation, mean-gap, mean-pressure, repulsive-area) and targets; retract \
or [loading.retraction] for the way back; event_resolution to bracket jumps.  Stopped with Ctrl-C or otherwise, the \
same command goes on.""",
    "turn": """from which work of adhesion on is the surface of an input sticky?

The load at a repulsive area, 1 % by default, changes its sign there, on approach.  The bracket of works is stored \
with the states at both ends.""",
    "plot": """draw the figures of a stored run, or a figure of the paper from a sweep

`plot RESULT` draws a run.  `plot FIGURE DIR` draws, from the files of a sweep alone, figure1 - figure4, figure-s1 - \
figure-s3, a further figure, `verdicts`, `page` (all) or `dispute` (theories beside).""",
    "analyse": "measure the stored points of runs: patches, perimeter, κ, gap profile, pull-off",
    "certify": """do stored states satisfy the equations, by other means than the solver's?

Residual, area, load and curvature of the energy are evaluated from heights and gap by other transforms, sums and \
derivatives, and compared with what is stored: for a run, or for a sample of the systems of a sweep.  Those of a \
LAMMPS deck: `atomistic read DIR --certify`.""",
    "predict": """is my surface sticky? every criterion on a measured topography

Roughness of a measured topography, or of two that face each other, the verdict of every criterion of stickiness \
with its margin, and warnings.  Writes figures and a one-page HTML report.  Every quantity has a unit: 70GPa, 50mJ/m2.
Example: continuum predict map.npy --size 10um --unit nm --modulus 2MPa --poisson 0.5 --work 50mJ/m2 --range 0.5nm""",
    "view": """show a height map, or stored results, on a page in a browser, on this machine only

A map gets the answer of `predict`, with sliders for w, E*, the range and the cut-off, and a button that solves the \
contact.  Of a stored run, the runs of a sweep, or what `atomistic read` stored: load, areas and the contact map of \
every state.  Name a file here, or drop it on the page.""",
    "init": "print an input to begin with, every key with its meaning",
    "schema": "print the JSON schema of an input, for editors that complete TOML",
    "examples": "print the paper's worked examples beside ours, as Markdown",
}
app = program(
    "continuum",
    "Adhesive contact of a rigid rough wall with an elastic substrate, by FFT Green's functions.",
    "a0 = 1 (atomic spacing), E* = 1 (contact modulus)",
    COMMANDS,
)
sweep = App(name="sweep", help="many systems: run, SLURM script, status, tables, verification")
app.command(sweep)
OF_SWEEPS = {
    "run": "do the systems that are not done yet",
    "slurm": "print a job script for sbatch",
    "status": "how far a sweep is, from its files alone",
    "collect": "one table of all points: table.csv, and table.h5 for xarray",
    "publish": "one folder for an archive: page, tables, input, and metadata for Zenodo",
    "verify": "read every file whole: sums, schema, identity",
}
# Imported when they are called: `continuum --help` needs none of them.
for name, text in OF_SWEEPS.items():
    sweep.command(f"continuum.sweep_commands:sweep_{name}", name=name, help=text)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit code."""
    return run_program(app, arguments)
