"""Every kernel through the compilers: ``python -m tests.continuum.solve.cuda_compiled 8 0 PTXAS FOLDER``.

In a process of its own, since what a kernel calls is compiled for one kind of GPU; without a GPU numba asks which kind
that is.  Prints one line for each kernel: name, registers, bytes spilled; of the accesses to the memory of the device
those of 16 bytes and of one number in double precision; and the instructions that would drop NaN.

With the kind alone, some kernels are compiled to machine code as for a launch, or read from the cache:
prints how many were read.
"""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numba.cuda.codegen as codegen
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


def accesses(program: str) -> tuple[int, int, int]:
    """Of 16 bytes, of one number, and how often the larger or smaller number is taken, as if NaN were none."""
    pairs, single = (len(re.findall(rf"\b(?:ld|st)\.global\.{kind}", program)) for kind in (r"v2\.f64", "f64"))
    return pairs, single, len(re.findall(r"\b(?:max|min)\.f64", program))


def read_from_cache(kind: tuple[int, int]) -> int:
    """Kernels that another process has compiled, of three."""
    device = SimpleNamespace(compute_capability=kind)
    dispatcher.get_current_device = lambda: device
    codegen.devices.get_context = lambda: SimpleNamespace(device=device)
    dispatcher._Kernel.bind = lambda kernel: kernel._codelibrary.get_cubin()
    assert callable(dispatcher._Kernel.max_cooperative_grid_blocks)  # what the number of blocks is asked of
    return sum(len(KERNELS[name].compiled.stats.cache_hits) for name in ("gradient", "move", "sum_parts"))


def main(major: str, minor: str, *rest: str) -> None:
    kind = int(major), int(minor)
    if not rest:
        sys.stdout.write(f"{read_from_cache(kind)}\n")
        return
    ptxas, folder = rest
    dispatcher.get_current_device = lambda: SimpleNamespace(compute_capability=kind)
    for name, kernel in sorted(KERNELS.items()):
        program = ptx(kernel, kind)
        numbers = *machine_code(program, kind, ptxas, Path(folder)), *accesses(program)
        sys.stdout.write(f"{name} {' '.join(map(str, numbers))}\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
