"""Nothing lost, nothing silent: what users have is never overwritten, and a failure is one message and an exit code."""

from __future__ import annotations

import multiprocessing
import os
import pty
import re
import resource
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from io import BytesIO, StringIO, TextIOWrapper
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import atomistic.front.cli
import continuum.front.cli
from continuum.inputs.errors import OutputError
from continuum.inputs.reading import load
from continuum.solve.solution import Settings
from continuum.store import output
from continuum.store.runs.config import RunConfig
from continuum.store.runs.result import Result
from continuum.store.runs.run import follow_run
from tests import problems
from tests.problems import Rough
from tests.stored import same

SMALL = problems.SMALL.replace("retract = true", "retract = true\nevent_resolution = 0.2")
"""Without a warning of long steps."""

ROOT = Path(__file__).parents[2]
VALIDATE = (ROOT / "inputs" / "validate" / "quick.toml").read_text()
DECK = (ROOT / "inputs" / "lammps" / "rough.toml").read_text()


def start(*command: str, folder: Path, **given: Any) -> subprocess.CompletedProcess[str]:
    """A command in a process of its own, as a user starts it."""
    environment = os.environ | {"PYTHONPATH": str(ROOT)} | given.pop("environment", {})
    whole = [sys.executable, "-m", *command]
    return subprocess.run(
        whole, cwd=folder, env=environment, text=True, timeout=600, check=False, capture_output=True, **given
    )


def content(folder: Path) -> dict[str, bytes]:
    """Every plain file of a folder."""
    files = {path for path in folder.rglob("*") if path.is_file() and path.resolve().parts[1:2] != ("proc",)}
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


# --- data ------------------------------------------------------------------------------------------------------


@pytest.fixture
def own(tmp_path: Path) -> Path:
    """An input that names the user's own heights, under the name that its result would have."""
    with h5py.File(tmp_path / "map.h5", "w") as file:
        file["heights"] = Rough(24, lambda_s=6.0).heights()
    head = SMALL[SMALL.index("[wall]") :]
    text = f'[grid]\nn = 24\n[surface]\nkind = "file"\npath = "map.h5"\ndataset = "heights"\n{head}'
    (tmp_path / "map.toml").write_text(text)
    return tmp_path / "map.toml"


@pytest.mark.parametrize("force", [(), ("--force",)])
@pytest.mark.parametrize("link", [None, os.symlink, os.link])
def test_a_result_is_never_written_over_an_input(
    own: Path, force: tuple[str, ...], link: Callable[[Path, Path], None] | None, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = own.parent
    if link is not None:
        folder = own.parent / "results"
        folder.mkdir()
        link(own.parent / "map.h5", folder / "map.h5")
    before = content(own.parent)
    assert continuum.front.cli.main(["run", str(own), "-o", str(folder), *force]) == 2
    error = capsys.readouterr().err
    assert "is an input" in error
    assert "--force" not in error
    assert content(own.parent) == before


def test_force_replaces_results_of_ours_only(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "run.toml").write_text(SMALL)
    (tmp_path / "run.h5").write_text("years of work")
    for force in ((), ("--force",)):
        assert continuum.front.cli.main(["run", str(tmp_path / "run.toml"), "-o", str(tmp_path), *force]) == 2
        error = capsys.readouterr().err
        assert "is left alone" in error
        assert "--force" not in error
    assert (tmp_path / "run.h5").read_text() == "years of work"


def test_two_runs_of_one_name_do_not_replace_one_another(tmp_path: Path) -> None:
    """The second begins while the first has the file, and says who holds it."""
    for name, seed in (("A", 3), ("B", 4)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "run.toml").write_text(SMALL.replace("seed = 3", f"seed = {seed}"))
    one, other = (load(tmp_path / name / "run.toml", RunConfig) for name in ("A", "B"))
    path, said = tmp_path / "results" / "run.h5", []

    def meanwhile(*_: object) -> None:
        if not said:
            for config, force in ((other, False), (other, True), (one, False)):
                with pytest.raises(OutputError) as caught:
                    follow_run(config, path, force=force)
                said.append(str(caught.value))

    first = follow_run(one, path, progress=meanwhile, every=0.0)
    assert first.converged
    assert any(f"process {os.getpid()}" in text for text in said[1:])
    assert "holds another result" in said[0]  # by then the first has stored a point
    same(path, _undisturbed(one, tmp_path))
    assert not list(path.parent.glob(".*"))


def _undisturbed(config: RunConfig, folder: Path) -> Path:
    follow_run(config, folder / "alone" / "run.h5")
    return folder / "alone" / "run.h5"


def test_a_mark_that_a_killed_process_left_is_no_lock(tmp_path: Path) -> None:
    (tmp_path / ".a.h5.lock").write_text("process 999999999 on elsewhere")
    with output.reserved(tmp_path / "a.h5"):
        assert str(os.getpid()) in (tmp_path / ".a.h5.lock").read_text()
    assert not list(tmp_path.iterdir())


@contextmanager
def little() -> Iterator[None]:
    """No file of this process can be larger than a small disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.fixture
def stored(tmp_path: Path) -> Path:
    """A run, and its result."""
    (tmp_path / "run.toml").write_text(SMALL)
    assert continuum.front.cli.main(["run", str(tmp_path / "run.toml"), "-o", str(tmp_path / "results"), "-q"]) == 0
    return tmp_path / "results" / "run.h5"


@pytest.mark.usefixtures("really_drawn")
@pytest.mark.parametrize("command", [["run", "run.toml", "--force", "-o", "results"], ["plot", "results/run.h5"]])
def test_a_full_disk_is_one_message_and_leaves_the_older_result(
    command: list[str], stored: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    before = content(stored.parent)
    monkeypatch.chdir(stored.parents[1])
    capsys.readouterr()
    with little():
        code = continuum.front.cli.main(command)
    assert code == 2
    error = capsys.readouterr().err
    assert "cannot be written: File too large" in error
    assert "Traceback" not in error
    assert content(stored.parent) == before


def test_links_in_a_users_file_do_not_refuse_a_plain_dataset(own: Path) -> None:
    """NeXus files have links to other files, to nothing, and in circles."""
    with h5py.File(own.parent / "map.h5", "a") as file:
        file["elsewhere"] = h5py.ExternalLink("no-such-file.h5", "/x")
        file["nothing"] = h5py.SoftLink("/no/such/dataset")
        file["group/up"] = h5py.SoftLink("/group")
        file["entry/data"] = h5py.SoftLink("/heights")
    assert continuum.front.cli.main(["check", str(own)]) == 0


# --- messages --------------------------------------------------------------------------------------------------


def test_a_terminal_that_is_not_utf8_gets_ascii(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "run.toml").write_text(SMALL)
    (tmp_path / "bad.toml").write_text(SMALL.replace("hurst = 0.8", "hurst = 8.0"))
    out, error = (TextIOWrapper(BytesIO(), encoding="ascii", write_through=True) for _ in range(2))
    with monkeypatch.context() as patch:
        patch.setattr(sys, "stdout", out)
        patch.setattr(sys, "stderr", error)
        codes = [continuum.front.cli.main(["check", str(tmp_path / name)]) for name in ("run.toml", "bad.toml")]
        codes.append(continuum.front.cli.main(["examples"]))
    assert codes == [0, 2, 0]
    printed, said = (stream.buffer.getvalue().decode() for stream in (out, error))
    assert "kappa" in printed
    assert "hurst" in said


@pytest.mark.long
def test_examples_are_printed_in_ascii_where_nothing_else_can_be(tmp_path: Path) -> None:
    environment = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "PYTHONIOENCODING": ""}
    assert "kappa" in start("continuum", "examples", folder=tmp_path, environment=environment).stdout


@pytest.mark.parametrize("closed", [1, pytest.param(2, marks=pytest.mark.long)])
def test_a_closed_stream_is_no_reason_to_fail_or_to_write_elsewhere(tmp_path: Path, closed: int) -> None:
    (tmp_path / "run.toml").write_text(SMALL)
    command = ("continuum", "run", "run.toml", "-o", "results")
    done = start(*command, folder=tmp_path, preexec_fn=lambda: os.close(closed))
    assert done.returncode == 0, done.stderr
    assert sorted(content(tmp_path / "results")) == ["run.h5"]
    assert Result.read(tmp_path / "results" / "run.h5").converged


WAITING = """
import sys
from continuum.front.cli import main
from continuum.solve.solver import Solver
solve = Solver.minimise
def waiting(*arguments, **given):
    print("now", flush=True)
    print(sys.stdin.readline(), end="", flush=True)
    sys.stdin.readline()
    return solve(*arguments, **given)
Solver.minimise = waiting
sys.exit(main(["run", "run.toml", "-o", "results", "-q"]))
"""


STOPPED = "stopped; finished work is stored, and the same command continues from there\n"


def hearing() -> None:
    """A test runner that was itself started in the background ignores these, and so do all that it starts."""
    for name in (signal.SIGINT, signal.SIGHUP, signal.SIGTERM):
        signal.signal(name, signal.SIG_DFL)


def waiting(folder: Path, *before: str) -> subprocess.Popen[str]:
    """A run that waits in its first solve until it is told to go on, twice."""
    (folder / "run.toml").write_text(SMALL)
    command = [*before, sys.executable, "-c", WAITING]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    process = subprocess.Popen(command, cwd=folder, env=environment, text=True, preexec_fn=hearing, **pipes)
    assert process.stdout is not None
    assert process.stdout.readline() == "now\n"
    return process


@pytest.mark.long
@pytest.mark.parametrize("stopped_by", [signal.SIGTERM, signal.SIGHUP])
def test_a_run_that_is_stopped_says_so(tmp_path: Path, stopped_by: signal.Signals) -> None:
    process = waiting(tmp_path)
    process.send_signal(stopped_by)
    _, error = process.communicate(timeout=120)
    assert process.returncode == 128 + stopped_by
    assert error == STOPPED


def test_in_the_background_only_kill_stops_a_run(tmp_path: Path) -> None:
    """What `nohup` and `&` in a script let a command ignore, it ignores."""
    process = waiting(tmp_path, "sh", "-c", "trap '' INT HUP; exec \"$@\"", "sh")
    assert process.stdin is not None
    assert process.stdout is not None
    for ignored in (signal.SIGINT, signal.SIGHUP):
        process.send_signal(ignored)
    process.stdin.write("still here\n")
    process.stdin.flush()
    assert process.stdout.readline() == "still here\n"
    process.terminate()
    _, error = process.communicate(timeout=120)
    assert process.returncode == 128 + signal.SIGTERM
    assert error == STOPPED


def test_a_reader_that_has_seen_enough_of_a_table_is_no_fault() -> None:
    """As `head`; a table is written by another library than a line."""
    ours, theirs = os.pipe()
    os.close(ours)
    program = "from continuum.show import console; from continuum.store.sheet import Column, Sheet; import sys; "
    program += "sys.exit(console.exit_code(lambda: console.show(Sheet.of('t', (Column('a'),), [(1,)])) or 0))"
    done = subprocess.run(
        [sys.executable, "-c", program], stdout=theirs, stderr=subprocess.PIPE, text=True, check=False,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    os.close(theirs)
    assert done.returncode == 128 + signal.SIGPIPE
    assert done.stderr == "stopped, as the output cannot be written\n"


@pytest.mark.parametrize(
    ("opened", "words"),
    [
        (pty.openpty, ["init", "run"]),
        pytest.param(pty.openpty, ["run", "run.toml", "-o", "results"], marks=pytest.mark.long),
        pytest.param(os.pipe, ["run", "run.toml", "-o", "results"], marks=pytest.mark.long),
    ],
)
def test_a_terminal_or_a_reader_that_is_gone_stops_a_command_in_order(
    tmp_path: Path, opened: Callable[[], tuple[int, int]], words: list[str]
) -> None:
    """Nothing can be said any more, which is no fault of the input."""
    (tmp_path / "run.toml").write_text(SMALL)
    ours, theirs = opened()
    command = [sys.executable, "-m", "continuum", *words]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    with (tmp_path / "log").open("w") as log:
        process = subprocess.Popen(
            command, cwd=tmp_path, env=environment, stdout=theirs, stderr=log, start_new_session=True
        )
    os.close(theirs)
    os.close(ours)
    assert process.wait(timeout=120) == 128 + signal.SIGPIPE
    stored = "; finished work is stored" if words[0] == "run" else ""
    assert (tmp_path / "log").read_text() == f"stopped, as the output cannot be written{stored}\n"


@pytest.mark.parametrize(
    ("program", "command"), [("continuum", "check"), ("continuum", "run"), ("atomistic", "validate")]
)
def test_a_long_name_is_shortened_in_messages(
    program: str, command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """One of 250 characters was told whole for each of many faults, and again for each point of a path."""
    monkeypatch.chdir(tmp_path)
    name = f"begin{'n' * 240}.toml"
    (tmp_path / name).write_text(SMALL.replace("hurst = 0.8", "hurst = 8").replace("seed = 3", "seed = -3"))
    main = {"atomistic": atomistic.front.cli.main, "continuum": continuum.front.cli.main}[program]
    for argument in (name, f"no-{name}"):
        assert main([command, argument, "-o", "out"][: 2 if command == "check" else 4]) == 2
        said = capsys.readouterr().err
        assert "n" * 100 not in said
        assert "begin" in said
        assert ".toml" in said


def test_a_long_name_is_shortened_in_the_line_of_each_point(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / f"{'n' * 200}.toml"
    path.write_text(SMALL)
    assert continuum.front.cli.main(["run", str(path), "-o", str(tmp_path)]) == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if "nnn" in line]
    assert len(lines) == 6
    assert not any("n" * 100 in line for line in lines[:5])
    assert lines[5] == f"result   {path.with_suffix('.h5')}", "whole, for use"


@pytest.mark.parametrize(
    ("program", "name", "value"),
    [
        ("continuum", "NUMBA_NUM_THREADS", "0"),
        ("atomistic", "DUCC0_NUM_THREADS", "x"),  # both programs begin with the same check
    ],
)
def test_a_number_of_threads_that_no_library_takes_is_one_message(
    program: str, name: str, value: str, tmp_path: Path
) -> None:
    (tmp_path / "run.toml").write_text(SMALL)
    done = start(program, "check", "run.toml", folder=tmp_path, environment={name: value})
    assert done.returncode == 2
    assert (
        done.stderr == f"{name} = '{value}', in the environment: allowed: a whole number of at least "
        f"{int('NUMBA' in name)}; or unset it\n"
    )


def test_a_command_draws_whatever_back_end_is_meant_for_windows() -> None:
    """Whatever the command is, what draws can be imported after it has begun."""
    program = "from continuum.front.cli import main; assert main(['--help']) == 0; import continuum.show.plot"
    environment = os.environ | {"PYTHONPATH": str(ROOT), "MPLBACKEND": "nonsense"}
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert "Usage" in done.stdout


def test_a_fault_in_many_places_is_said_in_twenty(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.toml").write_text(SMALL + "".join(f"\n[table{i}]" for i in range(300)))
    assert continuum.front.cli.main(["check", str(tmp_path / "a.toml")]) == 2
    error = capsys.readouterr().err
    assert "300 faults" in error
    assert "and 280 more" in error
    assert len(error) < 10_000


@pytest.mark.parametrize(
    "deep", ["a." * 2000 + "b = 1", "a = " + "[" * 200 + "]" * 200, "a = " + "[" * 9000 + "]" * 9000]
)
def test_deep_nesting_is_refused(tmp_path: Path, deep: str, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.toml").write_text(f"{deep}\n{SMALL}")
    assert continuum.front.cli.main(["check", str(tmp_path / "a.toml")]) == 2
    assert "levels of nesting" in capsys.readouterr().err


def test_as_many_targets_as_are_allowed_can_be_written_down(tmp_path: Path) -> None:
    values = ", ".join(f"{3 - 1e-5 * i:.17f}" for i in range(100_000))
    text = re.sub(r"targets = \[.*?\]", f"targets = [{values}]", SMALL, flags=re.DOTALL)
    (tmp_path / "a.toml").write_text(re.sub(r'control = ".*?"', 'control = "mean-gap"', text))
    assert load(tmp_path / "a.toml", RunConfig).loading.points >= 100_000


def test_a_count_of_threads_or_processes_is_at_least_one(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        continuum.front.cli.main(["predict", "x.npy", "--threads", "-2"])
    assert ended.value.code == 2
    assert "Must be >= 1" in capsys.readouterr().err
    # A sweep may have none: its jobs are for another scheduler.
    assert atomistic.front.cli.main(["validate", "inputs/validate/quick.toml", "-j", "0", "-o", "unused"]) == 2
    assert "workers" in capsys.readouterr().err
    assert not Path("unused").exists()


def test_a_sweep_without_workers_makes_its_folder_only(tmp_path: Path) -> None:
    path = tmp_path / "many.toml"
    path.write_text(SMALL + '[sweep.axes]\n"surface.seed" = [1, 2]\n')
    assert continuum.front.cli.main(["sweep", "run", str(path), "-o", str(tmp_path), "-j", "0", "-q"]) == 0
    assert (tmp_path / "many" / "systems.json").exists()
    assert not list((tmp_path / "many" / "points").iterdir())


def test_a_forked_process_solves_with_threads_of_its_own() -> None:
    """The threads of its parent are not there any more, and it waited for them for ever."""
    _solve()
    process = multiprocessing.get_context("fork").Process(target=_solve)
    process.start()
    process.join(120)  # seconds; a second or two are needed
    hung = process.is_alive()
    process.kill()
    assert not hung
    assert process.exitcode == 0


def _solve() -> None:
    from continuum.path.loading import solve

    assert solve(Rough(384).problem(), "mean-gap", 3.0, Settings(1e-4, threads=2)).status.ok


# --- any path at all -------------------------------------------------------------------------------------------

KINDS = (
    "missing",
    "file",
    "empty",
    "folder",
    "fifo",
    "unreadable",
    "loop",
    "below a file",
    "long",
    "text.h5",
)
COMMANDS: dict[str, tuple[Callable[[Sequence[str]], int], list[str]]] = {
    "continuum check": (continuum.front.cli.main, ["check", "PATH"]),
    "continuum run": (continuum.front.cli.main, ["run", "PATH"]),
    "continuum run -o": (continuum.front.cli.main, ["run", "run.toml", "-o", "OUT"]),
    "continuum plot": (continuum.front.cli.main, ["plot", "PATH"]),
    "continuum analyse": (continuum.front.cli.main, ["analyse", "PATH"]),
    "continuum predict": (continuum.front.cli.main, ["predict", "PATH", "--material", "mica", "--no-solve"]),
    "continuum predict -o": (
        continuum.front.cli.main,
        ["predict", "map.npy", "--size", "3um", "--unit", "nm", "--material", "mica", "--no-solve", "-o", "OUT"],
    ),
    "atomistic validate": (atomistic.front.cli.main, ["validate", "PATH"]),
    "atomistic validate -o": (atomistic.front.cli.main, ["validate", "validate.toml", "-j", "1", "-o", "OUT"]),
    "atomistic validate --keep-decks": (
        atomistic.front.cli.main,
        ["validate", "validate.toml", "-j", "1", "--keep-decks", "OUT", "-o", "results"],
    ),
    "atomistic deck": (atomistic.front.cli.main, ["deck", "PATH"]),
    "atomistic deck -o": (atomistic.front.cli.main, ["deck", "deck.toml", "-o", "OUT"]),
    "atomistic read": (atomistic.front.cli.main, ["read", "PATH"]),
    "atomistic elastic": (atomistic.front.cli.main, ["elastic", "PATH"]),
}


def _make(folder: Path, kind: str, name: str) -> Path:
    """A path of that kind, which is nothing that a command could use."""
    path = folder / name
    if kind == "file":
        path.write_text("hurst = \x00 and more\n")
    elif kind == "text.h5":
        path = path.with_suffix(".h5")
        path.write_text("no HDF5")
    elif kind == "empty":
        path.touch()
    elif kind == "folder":
        path.mkdir()
        (path / "inside").write_text("kept")
    elif kind == "fifo":
        os.mkfifo(path)
    elif kind == "unreadable":
        path.symlink_to("/proc/self/mem")
    elif kind == "loop":
        path.symlink_to(path.name)
    elif kind == "below a file":
        path.write_text("a file")
        path = path / "below" / "it"
    elif kind == "long":
        path = folder / ("n" * 300)
    return path


@settings(max_examples=20)
@given(
    command=st.sampled_from(sorted(COMMANDS)),
    kind=st.sampled_from(KINDS),
    name=st.text(st.characters(exclude_characters="/\x00", exclude_categories=["Cs"]), min_size=1, max_size=20).filter(
        lambda name: name not in (".", "..") and not name.startswith("-")
    ),
)
def test_any_path_is_used_or_refused_in_one_message(command: str, kind: str, name: str) -> None:
    main, arguments = COMMANDS[command]
    output_is_sound = "OUT" in arguments and kind in ("missing", "folder", "text.h5")
    if output_is_sound:
        return  # it would be used
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        np.save(folder / "map.npy", Rough(16, lambda_s=4.0).heights())
        (folder / "run.toml").write_text(SMALL)
        (folder / "validate.toml").write_text(VALIDATE)
        (folder / "deck.toml").write_text(DECK)
        bad = _make(folder, kind, f"x{name}")
        places = {"PATH": str(bad), "OUT": str(bad), "results": str(folder / "results")}
        words = [places.get(word, str(folder / word) if (folder / word).is_file() else word) for word in arguments]
        if "-o" not in words and words[0] in ("run", "predict", "validate", "deck"):
            words += ["-o", str(folder / "results")]
        before = content(folder)
        out, error = StringIO(), StringIO()
        with redirect_stdout(out), redirect_stderr(error):
            code = _within(60, lambda: main(words))
        assert code == 2, (command, kind, bad, error.getvalue())
        assert error.getvalue().strip(), command
        assert "Traceback" not in error.getvalue()
        assert len(error.getvalue()) < 5000
        assert content(folder) == before, command


def _within(seconds: float, work: Callable[[], int]) -> int:
    """The result of some work, which must not wait for ever, as on a FIFO."""
    found: list[int] = []
    thread = threading.Thread(target=lambda: found.append(work()), daemon=True)
    thread.start()
    thread.join(seconds)
    assert found, "it hangs, or failed otherwise than by its exit code"
    return found[0]
