"""One measurement in a process of its own: ``python -m docs.benchmarks.job ours.search '{"n": 512, ...}'``.

Prints one line of JSON: what the function returned, the largest memory of the process, the threads it was given.
"""

from __future__ import annotations

import importlib
import json
import resource
import sys
from pathlib import Path
from typing import Any


def peak() -> float:
    """Largest resident memory of this process, in MiB."""
    status = Path("/proc/self/status")
    if status.exists():
        # The resource usage of Linux has the memory of the starting process in it.
        line = next(line for line in status.read_text().splitlines() if line.startswith("VmHWM:"))
        return int(line.split()[1]) / 2**10
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20  # macOS counts in bytes


def main(name: str, arguments: str) -> None:
    module, function = name.split(".")
    result: dict[str, Any]
    try:
        result = getattr(importlib.import_module(f"docs.benchmarks.{module}"), function)(**json.loads(arguments))
    except ModuleNotFoundError as missing:
        result = {"skipped": f"{missing.name} is not installed"}
    result["peak_mib"] = peak()
    sys.stdout.write("\n" + json.dumps(result) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
