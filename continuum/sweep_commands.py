"""The commands of ``continuum sweep``: each calls the function of its name and shows what it returns."""

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from continuum.commands import Settings
from continuum.errors import NOT_CONVERGED, OK, InputError
from continuum.front import sweeps
from continuum.options import like
from continuum.paper import publication
from continuum.show.console import EstimatedProgress, clear, show, until_ctrl_c, warn
from continuum.sweeps import collect as collecting
from continuum.sweeps import status


def _shard(_: type, tokens: Sequence[Any]) -> tuple[int, int]:
    part, slash, parts = tokens[0].value.partition("/")
    if not (slash and part.isdecimal() and parts.isdecimal() and 1 <= int(part) <= int(parts)):
        raise ValueError(f"{tokens[0].value!r}: write I/N with I from 1 to N, such as 2/8")
    return int(part), int(parts)


Gigabytes = Annotated[float | None, Parameter(help="memory to use, in GB (default: all of this machine)")]
Shard = Annotated[tuple[int, int], Parameter(converter=_shard, n_tokens=1, help="part I/N of the systems, as 2/8")]
Modules = Annotated[list[str] | None, Parameter(name="--module", help="module to load first, as gcc/13.2; may be "
                    "repeated")]  # fmt: skip
Lines = Annotated[list[str] | None, Parameter(name="--line", help="further line of the script, as 'source "
                  "~/venv/bin/activate'; may be repeated")]  # fmt: skip
Creators = Annotated[list[str] | None, Parameter(name="--creator", help="author of the data, as 'Family, Given'; may "
                     "be repeated")]  # fmt: skip


@like(sweeps.sweep)
def sweep_run(file: str, *, settings: Settings = None, memory: Gigabytes = None, shard: Shard = (1, 1),
              **given: Any) -> int:  # fmt: skip
    with EstimatedProgress(Path(file).stem) as report:
        done = sweeps.sweep(
            file, settings=dict(settings or ()), memory=None if memory is None else 1e9 * memory, shard=shard, **given,
            warn=warn, begun=lambda tasks: report.begin({task.path: task.cost for task in tasks}),
            progress=lambda ended, n, total: report.end(ended.task.path, str(ended), new=not ended.found),
            meanwhile=lambda task, share: report.advance(task.path, share, f"{task.label}: {share:.0%} of its points"),
        )  # fmt: skip
    what = "searches" if done.crossings else "systems"
    print(f"{done.folder}: {done.done} {what} done, {done.found} were done before, {len(done.failed)} failed")
    for death in done.died:
        print(f"a process died: {death}")
    if done.held:
        print(f"{len(done.held)} are locked by another process: {done.held[0].reason}")
    warn([f"{ended.task.label}: {ended.reason}" for ended in done.failed[:20]])
    without = [one for one in done.crossings if one.complete and not one.found]
    warn([f"{one.label}: {one.status}" for one in without[:20]])
    return OK if done.ok and not without else NOT_CONVERGED


@like(sweeps.sweep_slurm)
def sweep_slurm(*, settings: Settings = None, shards: Annotated[int | None, Parameter(name="--array")] = None,
                memory: Annotated[float | None, Parameter(help="memory of each process, in GB (default: that of "
                "the largest system)")] = None, modules: Modules = None, lines: Lines = None,
                **given: Any) -> int:  # fmt: skip
    bytes_each = None if memory is None else 1e9 * memory
    print(sweeps.sweep_slurm(settings=dict(settings or ()), shards=shards, memory=bytes_each, modules=modules or (),
                             lines=lines or (), **given), end="")  # fmt: skip
    return OK


@like(status.sweep_status)
def sweep_status(sweep: Path, *, settings: Settings = None, watch: Annotated[float | None, Parameter(help="repeat "
                 "every so many seconds, until all systems are done or Ctrl-C is pressed")] = None,
                 **given: Any) -> int:  # fmt: skip
    if watch is not None and not 0 < watch <= 86400:
        raise InputError(f"--watch {watch:g}: give seconds, more than 0 and at most a day")
    with until_ctrl_c():
        while True:
            found = status.sweep_status(sweep, settings=dict(settings or ()), **given)
            if watch is not None:
                clear()
            for sheet in found.sheets():
                show(sheet)
            for change in found.changes:
                print(f"would change: {change}")
            if watch is None or not found.left:
                break
            time.sleep(watch)
    return OK


@like(sweeps.sweep_collect)
def sweep_collect(**given: Any) -> int:
    found = sweeps.sweep_collect(**given)
    for sheet in found.sheets():
        show(sheet)
    warn([*found.faults, *found.lacking])
    for path in found.files:
        print(path)
    return NOT_CONVERGED if found.faults or found.lacking else OK


@like(publication.sweep_publish)
def sweep_publish(*, creators: Creators = None, **given: Any) -> int:
    found = publication.sweep_publish(creators=creators or (), **given)
    for sheet in found.table.sheets():
        show(sheet)
    warn(found.warnings)
    for path in found.files:
        print(path)
    return NOT_CONVERGED if found.table.faults or found.table.lacking else OK


@like(collecting.sweep_verify)
def sweep_verify(sweep: Path, **given: Any) -> int:
    found = collecting.sweep_verify(sweep, **given)
    warn(found.faults)
    print(f"{sweep}: {found.files} files, {len(found.faults)} of them damaged")
    return OK if found.ok else NOT_CONVERGED
