"""Every kernel through the compilers: ``python -m tests.continuum.solve.cuda_compiled 8 0 PTXAS FOLDER``.

In a process of its own, since what a kernel calls is compiled for one kind of GPU; without a GPU numba asks which kind
that is.  Prints one line for each kernel: name, registers, bytes spilled.
"""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numba.cuda.dispatcher as dispatcher
from numba import cuda

from continuum.solve.cuda.engine import KERNELS


def ptx(kernel: Any, kind: tuple[int, int]) -> str:
    """The program of a kernel, as the driver of a GPU takes it."""
    return str(cuda.compile_ptx(kernel.function, kernel.signature, cc=kind)[0])


def machine_code(program: str, kind: tuple[int, int], ptxas: str, folder: Path) -> tuple[int, int]:
    """Registers of a thread, and bytes spilled, of the compiled program."""
    source = folder / "kernel.ptx"
    source.write_text(program)
    command = [ptxas, "-v", f"--gpu-name=sm_{kind[0]}{kind[1]}", str(source), "-o", str(folder / "kernel.cubin")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(done.stderr)
    spilled = sum(map(int, re.findall(r"(\d+) bytes spill", done.stderr)))
    return max(map(int, re.findall(r"Used (\d+) registers", done.stderr))), spilled


def main(major: str, minor: str, ptxas: str, folder: str) -> None:
    kind = int(major), int(minor)
    dispatcher.get_current_device = lambda: SimpleNamespace(compute_capability=kind)
    for name, kernel in sorted(KERNELS.items()):
        registers, spilled = machine_code(ptx(kernel, kind), kind, ptxas, Path(folder))
        sys.stdout.write(f"{name} {registers} {spilled}\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
