"""Memory and processors of the machine that this process may use: by SLURM, control groups and ``taskset``."""

import math
import os
import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path, PurePosixPath

from continuum.inputs.errors import InputError

# SLURM sets one of these, in MB; the others may have been set by hand, with a unit, as an input of srun.
_SLURM = {
    "SLURM_MEM_PER_NODE": None,
    "SLURM_MEM_PER_CPU": "SLURM_CPUS_ON_NODE",
    "SLURM_MEM_PER_GPU": "SLURM_GPUS_ON_NODE",
}
_UNITS = {"K": 2**10, "M": 2**20, "": 2**20, "G": 2**30, "T": 2**40}


def granted_memory() -> float:
    """Memory that this process may use, in bytes.

    Raises InputError if a variable of SLURM is not an amount of memory.
    """
    allowed = min(slurm_memory(os.environ), cgroup_memory(Path("/")))
    try:
        return min(allowed, float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")))
    except (ValueError, OSError, AttributeError):
        return allowed


def slurm_memory(environment: Mapping[str, str]) -> float:
    """Memory of this node that SLURM gives the job, in bytes; infinite without a limit.

    Raises InputError if a variable is not an amount of memory.
    """
    limit = math.inf
    for name, counter in _SLURM.items():
        if name in environment and (counter is None or counter in environment):
            found = re.fullmatch(r"(\d+)([KMGT]?)B?", environment[name].strip(), re.IGNORECASE)
            times = environment[counter] if counter else "1"
            if not found or not times.isdecimal():
                given = f"{name} = {environment[name]!r}" + (f" with {counter} = {times!r}" if counter else "")
                raise InputError(
                    f"{given}: allowed: a number of MB, as SLURM sets it; unset the variable outside a SLURM job"
                )
            # --mem=0 is all memory of the node.
            limit = min(limit, int(found[1]) * _UNITS[found[2].upper()] * int(times) or math.inf)
    return limit


def cgroup_memory(root: Path) -> float:
    """The lowest limit of the control groups of this process and of their parents; infinite without one.

    Parameters
    ----------
    root : where ``proc`` and ``sys`` are.
    """
    limit = math.inf
    for path in _of_groups(root, "memory", ("memory.max", "memory.limit_in_bytes")):
        try:
            text = path.read_text().strip()
        except OSError:  # no limit can be set there, as in the group of the whole machine
            continue
        # "max" in version 2; in version 1 a number larger than any memory.
        limit = min(limit, float(text) if text.isdecimal() else math.inf)
    return limit


def granted_processors() -> int:
    """Number of processors that this process may use: of the machine, less what is granted to others.

    Raises InputError if a variable of SLURM is not a number of processors.
    """
    try:
        seen = len(os.sched_getaffinity(0))  # by taskset, a cpuset, or a SLURM that binds tasks
    except AttributeError:  # no Linux
        seen = os.cpu_count() or 1
    return max(1, math.floor(min(seen, slurm_processors(os.environ), cgroup_processors(Path("/")))))


def slurm_processors(environment: Mapping[str, str]) -> float:
    """Processors that SLURM gives a task, or the job on this node; infinite without a limit.

    Raises InputError if a variable is not a number of processors.
    """
    for name in ("SLURM_CPUS_PER_TASK", "SLURM_CPUS_ON_NODE"):  # the second is of all tasks on the node
        if (given := environment.get(name)) is not None:
            if not given.isdecimal() or not int(given):
                allowed = "allowed: a number of processors, as SLURM sets it; unset the variable outside a SLURM job"
                raise InputError(f"{name} = {given!r}: {allowed}")
            return int(given)
    return math.inf


def cgroup_processors(root: Path) -> float:
    """The lowest limit of the control groups of this process and of their parents, as a container has; rounded up.

    Parameters
    ----------
    root : where ``proc`` and ``sys`` are.
    """
    limit = math.inf
    for path in _of_groups(root, "cpu", ("cpu.max", "cpu.cfs_quota_us")):
        # Times in µs: one file in version 2, as "max 100000"; two in version 1, where -1 is no limit.
        with suppress(OSError, ValueError):
            quota, *period = path.read_text().split()
            period = period or [path.with_name("cpu.cfs_period_us").read_text()]
            if float(quota) > 0:
                limit = min(limit, math.ceil(float(quota) / float(period[0])))
    return limit


def _of_groups(root: Path, controller: str, names: tuple[str, str]) -> Iterator[Path]:
    """Files with the limits of this process, of these names in version 2 and version 1 of control groups."""
    groups = root / "sys" / "fs" / "cgroup"
    try:
        lines = (root / "proc" / "self" / "cgroup").read_text().splitlines()
    except OSError:  # no Linux
        return
    for line in lines:
        _, controllers, group = line.split(":", 2)
        inside = [group.strip("/"), *map(str, PurePosixPath(group.strip("/")).parents)]
        if not controllers:
            yield from (groups / mount / path / names[0] for mount in ("", "unified") for path in inside)
        elif controller in controllers.split(","):
            # Controllers that are mounted together are found under either name, too.
            yield from (groups / controller / path / names[1] for path in inside)
