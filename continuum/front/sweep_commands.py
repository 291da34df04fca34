"""The commands of ``continuum sweep``: each calls the function of its name and shows what it returns."""

import time
import warnings
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from continuum.front import sweeps
from continuum.front.options import like
from continuum.inputs.errors import OK, InputError
from continuum.show.console import clear, report, until_ctrl_c, warn
from continuum.show.sweep_progress import SweepProgress
from continuum.store.sweeps import collect as collecting
from continuum.store.sweeps import status


@like(sweeps.sweep, help={"memory": "memory to use, in GB (default: all of this machine)"})
def sweep_run(file: str, **given: Any) -> int:
    with SweepProgress(Path(file).stem) as told:
        done = sweeps.sweep(
            file, **given, warn=warn, begun=told.begin, progress=lambda ended, n, total: told.end(ended),
            meanwhile=told.advance,
        )  # fmt: skip
    what = "searches" if done.crossings else "systems"
    lines = [f"{done.folder}: {done.done} {what} done, {done.found} were done before, {len(done.failed)} failed"]
    lines += [f"a process died: {death}" for death in done.died]
    if done.held:
        lines.append(f"{len(done.held)} are locked by another process: {done.held[0].reason}")
    report(lines=lines)
    without = [f"{one.label}: {one.status}" for one in done.crossings if one.complete and not one.found]
    failed = [f"{ended.task.label}: {ended.reason}" for ended in done.failed]
    return report(warnings=failed[:20] + without[:20], ok=done.ok and not without)


@like(sweeps.sweep_slurm, help={
    "memory": "memory of each process, in GB (default: that of the largest system)",
    "modules": "module to load first, as gcc/13.2; may be repeated",
    "lines": "further line of the script, as 'source ~/venv/bin/activate'; may be repeated",
})  # fmt: skip
def sweep_slurm(**given: Any) -> int:
    print(sweeps.sweep_slurm(**given, warn=warn), end="")
    return OK


Watch = Annotated[
    float | None,
    Parameter(help="interval in seconds of reports, until all systems are done or Ctrl-C is pressed (default: one)"),
]


@like(status.sweep_status)
def sweep_status(*, watch: Watch = None, **given: Any) -> int:
    if watch is not None and not 0 < watch <= 86400:
        raise InputError(f"--watch {watch:g}: give seconds, more than 0 and at most a day")
    with until_ctrl_c():
        while True:
            found = status.sweep_status(**given)
            if watch is not None:
                clear()
            report(*found.sheets(), lines=[f"would change: {change}" for change in found.changes])
            if watch is None or not found.left:
                break
            time.sleep(watch)
    return OK


@like(sweeps.sweep_collect)
def sweep_collect(**given: Any) -> int:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", collecting.LeftOutWarning)  # each fault is reported below
        found = sweeps.sweep_collect(**given)
    faults = [*found.faults, *found.lacking]
    return report(*found.sheets(), warnings=faults, lines=found.files, ok=not faults)


@like(collecting.sweep_verify)
def sweep_verify(sweep: Path, **given: Any) -> int:
    found = collecting.sweep_verify(sweep, **given)
    said = f"{sweep}: {found.files} files, {len(found.faults)} of them damaged"
    said += f", {len(found.unread)} could not be read now" if found.unread else ""
    return report(warnings=[*found.faults, *found.unread], lines=[said], ok=found.ok)
