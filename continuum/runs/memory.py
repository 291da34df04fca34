"""How much memory this process may use: that of the machine, or what a batch system or a container allows of it."""

import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path, PurePosixPath

import numpy as np

from continuum.errors import InputError

# SLURM sets one of these, in MB; the others may have been set by hand, with a unit, as an input of srun.
_SLURM = {
    "SLURM_MEM_PER_NODE": None,
    "SLURM_MEM_PER_CPU": "SLURM_CPUS_ON_NODE",
    "SLURM_MEM_PER_GPU": "SLURM_GPUS_ON_NODE",
}
_UNITS = {"K": 2**10, "M": 2**20, "": 2**20, "G": 2**30, "T": 2**40}


def physical_memory() -> float:
    """Memory that this process may use, in bytes.

    Raises InputError if a variable of SLURM holds no amount of memory.
    """
    allowed = min(slurm_limit(os.environ), cgroup_limit(Path("/")))
    try:
        return min(allowed, float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")))
    except (ValueError, OSError, AttributeError):
        return allowed


def slurm_limit(environment: Mapping[str, str]) -> float:
    """Memory of this node that SLURM gives the job, in bytes; infinite without a limit.

    Raises InputError if a variable holds no amount of memory.
    """
    limit = np.inf
    for name, counter in _SLURM.items():
        if name in environment and (counter is None or counter in environment):
            found = re.fullmatch(r"(\d+)([KMGT]?)B?", environment[name].strip(), re.IGNORECASE)
            times = environment[counter] if counter else "1"
            if not found or not times.isdecimal():
                given = f"{name} = {environment[name]!r}" + (f" with {counter} = {times!r}" if counter else "")
                raise InputError(
                    f"{given}: allowed: a number of MB, as SLURM sets it; unset the variable if this is no job of SLURM"
                )
            # --mem=0 is all memory of the node.
            limit = min(limit, int(found[1]) * _UNITS[found[2].upper()] * int(times) or np.inf)
    return limit


def cgroup_limit(root: Path) -> float:
    """The lowest limit of the control groups of this process and of all that these lie in; infinite without one.

    Parameters
    ----------
    root : where ``proc`` and ``sys`` are.
    """
    limit = np.inf
    for path in _limits(root):
        try:
            text = path.read_text().strip()
        except OSError:  # no limit can be set there, as in the group of the whole machine
            continue
        # "max" in version 2; in version 1 a number larger than any memory.
        limit = min(limit, float(text) if text.isdecimal() else np.inf)
    return limit


def _limits(root: Path) -> Iterator[Path]:
    """Files that hold the limits of this process, whatever version of control groups there is."""
    groups = root / "sys" / "fs" / "cgroup"
    try:
        lines = (root / "proc" / "self" / "cgroup").read_text().splitlines()
    except OSError:  # no Linux
        return
    for line in lines:
        _, controllers, group = line.split(":", 2)
        inside = [group.strip("/"), *map(str, PurePosixPath(group.strip("/")).parents)]
        if not controllers:
            yield from (groups / mount / path / "memory.max" for mount in ("", "unified") for path in inside)
        elif "memory" in controllers.split(","):
            yield from (groups / "memory" / path / "memory.limit_in_bytes" for path in inside)
