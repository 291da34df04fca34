"""The command ``atomistic``."""

from collections.abc import Sequence

from continuum.front.options import program, run_program

COMMANDS = {
    "validate": "press walls on Green's functions and on atoms, and print the error budget",
    "deck": "write a LAMMPS deck that a stock lmp runs, serial or with MPI",
    "read": "print, store and draw the states of a deck that was run",
    "wall": "write a rough wall that any LAMMPS script can include",
    "elastic": "measure lattice and elastic constants, E* and surface relaxation of a crystal",
    "check": "check an input, and estimate memory, force evaluations and time",
    "doctor": "check the installation and LAMMPS on this machine, and say what to do",
    "init": "print a template of an input, with every key explained",
    "schema": "print the JSON schema of an input, for editors",
}
app = program(
    "atomistic",
    "Explicit atoms under a rigid rough wall, in LAMMPS, and their comparison with Green's functions.",
    "a0 = 1 (nearest-neighbour distance), E* = 1 (contact modulus)",
    COMMANDS,
    "front.commands",
    {},
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit code."""
    return run_program(app, arguments)
