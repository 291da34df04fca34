"""``python -m atomistic`` is the command ``atomistic``."""

from atomistic.front.cli import main

# Workers of a validation are started anew and import this module: only the command itself may run it.
if __name__ == "__main__":
    raise SystemExit(main())
