"""The command ``continuum``."""

from collections.abc import Sequence

from cyclopts import App

from continuum.front.options import program, run_program

COMMANDS = {
    "check": "print grid, roughness, memory and states of a run or a sweep",
    "run": """follow a loading path; store areas, loads, maps and jumps

The table [loading] of the input sets the control (separation, mean-gap, mean-pressure, repulsive-area) and its \
targets, the way back (retract or [loading.retraction]), and whether jumps are bracketed (event_resolution).  A run \
that was stopped continues with the same command.""",
    "threshold": """find the work of adhesion above which a surface is sticky

At this work the load at 1 % repulsive area, or at --area, changes its sign on approach.  The bracket of works is \
stored with the states at both ends.""",
    "plot": """draw the figures of a run, or of the paper from a sweep

`plot RESULT` draws a run.  `plot FIGURE DIR` draws a figure from the files of a sweep: figure1 - figure4, figure-s1 - \
figure-s3, a further figure, `verdicts`, `page` (all of these) or `dispute` (simulations and every theory).""",
    "analyse": "measure a stored run: patches, perimeter, κ, gaps, pull-off",
    "certify": """check stored states against the equations, with independent code

Recomputes residual, curvature of the energy, areas and their maps, loads, energies, mean gap and separation from \
heights and gap, with other transforms, sums and derivatives than the solver's, and compares them with the stored \
numbers: for a run, or for some systems of a sweep.  For a LAMMPS deck use `atomistic read DIR --certify`.""",
    "predict": """decide whether a measured surface is sticky, and find its threshold

Presses a measured topography, or two that face each other, once without adhesion.  Prints the work of adhesion above \
which the surface is sticky, its error, and what would change the answer.  Writes figures and a one-page HTML report, \
which also has the answers of other theories.  Every quantity has a unit: 70GPa, 50mJ/m2.
Example: continuum predict map.npy --size 10um --unit nm --modulus 2MPa --poisson 0.5 --work 50mJ/m2 --range 0.5nm""",
    "view": """show a height map or stored results in a browser

Only this machine can open the page.  For a map it shows the answer of `predict`, with sliders for w, E*, the range \
and the cut-off, and a button that solves the contact.  For a run, a sweep or a deck that `atomistic read` stored it \
shows load, areas and the contact map of every state.  Name a file here, or drop it on the page.""",
    "doctor": "check the installation on this machine, and say what to do",
    "init": "print a template of an input, with every key explained",
    "schema": "print the JSON schema of an input, for editors",
    "examples": "print the paper's worked examples beside our numbers",
}
app = program(
    "continuum",
    "Adhesive contact of a rigid rough wall with an elastic substrate, by FFT Green's functions.",
    "a0 = 1 (atomic spacing), E* = 1 (contact modulus)",
    COMMANDS,
    "front.commands",
    {"predict": "front.map_commands", "view": "view.commands", "plot": "paper.commands", "examples": "paper.commands"},
)
sweep = App(name="sweep", help="run many systems from one input, on a laptop or a cluster")
app.command(sweep)
OF_SWEEPS = {
    "run": "run the systems that are not done yet",
    "slurm": "print a job script for sbatch",
    "status": "show the progress of a sweep, from its files alone",
    "collect": "write one table of all points: table.csv, and table.h5 for xarray",
    "publish": "write one folder for an archive: page, tables, input, and metadata for Zenodo",
    "verify": "check every file: checksums, schema, identity",
}
# Imported when they are called: `continuum --help` needs none of them.
for name, text in OF_SWEEPS.items():
    module = "paper.commands" if name == "publish" else "front.commands"
    sweep.command(f"continuum.{module}:sweep_{name}", name=name, help=text)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit code."""
    return run_program(app, arguments)
