"""One contact divided over several devices: what each holds and sends, from counts.

``python -m docs.studies.shards`` writes the table in a second; it measures nothing.
"""

from __future__ import annotations

from typing import NamedTuple

from pandas import read_csv

from continuum.solve.backend import SMOOTH_FIELDS
from continuum.store.runs.config import Share
from continuum.store.sheet import Column, Sheet
from docs.studies.tables import KEPT, keep


class Machine(NamedTuple):
    """Devices of one kind, and what joins them."""

    name: str
    joined: str
    rate: float
    """Bytes that a device sends in a second: what its maker states, in one direction."""
    iteration: float
    """Seconds of an iteration on one grid of 8192² points on one device."""
    memory: float
    """Bytes of a device."""


def machines() -> tuple[Machine, ...]:
    """A GPU within a machine and between machines, and a machine of processor cores."""
    gpu = float(read_csv(KEPT["gpu-1"]).set_index("grid").at["8192²", "iteration on one grid, ms"]) / 1e3
    times = read_csv(KEPT["gpu-2"]).set_index("on 4096²")
    # From rest, on 16 threads of a CPU and on the GPU, of which 8192² take four times as long.
    cores = gpu * float(times.at["from rest", "16 threads, s"]) / float(times.at["from rest", "GPU, s"])
    return (
        Machine("H200", "NVLink", 450e9, gpu, 141e9),
        Machine("H200", "400 Gbit/s each", 50e9, gpu, 141e9),
        Machine("16 cores", "200 Gbit/s", 25e9, cores, 128e9),
    )


def scaling() -> Sheet:
    """Memory, exchange and time of an iteration, by counts."""
    head = [
        Column(name)
        for name in (
            "grid", "devices", "joined by", "memory on each, GB", "sent by each in an iteration, GB", "exchange, ms",
            "transforms and passes, ms", "limited by",
        )
    ]  # fmt: skip
    rows = []
    for machine in machines():
        for n, devices in ((16384, 4), (32768, 8), (65536, 8), (65536, 64)):
            if machine.joined == "NVLink" and devices > 8:
                continue  # that joins the eight of one machine
            modes = n * devices * -(-(n // 2 + 1) // devices)
            share = Share(devices, n * n, modes, SMOOTH_FIELDS)
            exchange, own = share.sent / machine.rate, machine.iteration * (n / 8192) ** 2 / devices
            limit = "memory" if share.memory > machine.memory else "exchange" if exchange > own else "passes"
            numbers = (
                f"{share.memory / 1e9:.3g}", f"{share.sent / 1e9:.2g}", f"{1e3 * exchange:.2g}", f"{1e3 * own:.2g}"
            )  # fmt: skip
            rows.append((f"{n}²", f"{devices} {machine.name}", machine.joined, *numbers, limit))
    return Sheet.of("shards", head, rows)


if __name__ == "__main__":
    keep("shards", scaling())
