"""Control by pressure and by area; jumps found, bracketed and named; targets that no state has."""

from __future__ import annotations

import shutil
import signal
import subprocess
import sys
import tracemalloc
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from continuum.front.cli import main
from continuum.inputs.reading import load
from continuum.model.grid import Grid
from continuum.model.problem import ContactProblem, unresolved
from continuum.model.substrates import HalfSpace, MeanMode
from continuum.model.surface import SelfAffine, moments
from continuum.model.surfaces import sine, sphere
from continuum.model.walls import Exponential, HardWall, InversePowers, LennardJonesSpline, Wall
from continuum.path.area import RESOLUTION
from continuum.path.equilibrium import solver_of
from continuum.path.loading import follow, solve
from continuum.path.state import Control, Event, Outcome, PathState, Search
from continuum.solve.solution import Settings, Status
from continuum.store import datasets as store
from continuum.store.runs.config import LoadingTable, RunConfig
from continuum.store.runs.result import Result
from continuum.store.runs.run import follow_run
from tests.kinds import covering
from tests.problems import SMALL, Rough
from tests.stored import same, stop_after

TIGHT = Settings(1e-9)


def rough(n: int, wall: Wall, seed: int = 1, mean: MeanMode = "clamped") -> ContactProblem:
    return Rough(n, lambda_s=16.0, seed=seed).problem(wall, HalfSpace(mean))


def jumps(states: Sequence[PathState]) -> list[Event]:
    return [event for state in states for event in state.events]


# --- mean pressure -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("mean", "wall"),
    covering(
        ["clamped", "free", 0.03],
        [LennardJonesSpline(0.0), LennardJonesSpline(0.3464), InversePowers((9, 3), adhesion_length=0.005)],
    ),
)
def test_control_by_pressure_is_control_by_mean_gap_at_the_same_state(wall: Wall, mean: MeanMode) -> None:
    problem = rough(128, wall, mean=mean)
    by_pressure = solve(problem, "mean-pressure", 0.002, TIGHT)
    assert by_pressure.status.ok
    # The residual bounds the error of the mean traction.
    assert by_pressure.load == pytest.approx(0.002, abs=2e-9)
    by_gap = solve(problem, "mean-gap", by_pressure.mean_gap, TIGHT)
    np.testing.assert_allclose(by_gap.gap, by_pressure.gap, atol=1e-6)
    assert by_gap.load == pytest.approx(0.002, rel=1e-6)
    if mean == "free":
        assert np.isnan(by_pressure.separation)
    else:
        by_separation = solve(problem, "separation", by_pressure.separation, TIGHT)
        np.testing.assert_allclose(by_separation.gap, by_pressure.gap, atol=1e-6)


@pytest.mark.parametrize(
    "wall", [LennardJonesSpline(0.3464), pytest.param(Exponential(0.005, 0.3, 5.0), marks=pytest.mark.long)]
)
def test_a_tension_is_held_up_to_pull_off_and_not_beyond(wall: Wall) -> None:
    problem = rough(64, wall)
    search = Search(event_resolution=1e-5)
    states = list(follow(problem, "mean-pressure", [0.0, 1e-3, 0.0, -4e-3, -8e-3, 0.0], Settings(1e-8), (), search))
    assert [s.status.ok for s in states] == [True, True, True, False, False, True]
    off, further = states[3], states[4]
    assert off.status is further.status is Outcome.PULLED_OFF
    assert off.area_rep == off.load == 0
    assert np.isposinf(off.mean_gap)
    assert further.search_solves == 0
    *_, event = off.events
    assert event.kind == "pull-off"
    assert not further.events
    held, lost = event.before.value, event.after.value
    assert 0 < held - lost <= 1e-5
    assert event.before.load == pytest.approx(held, abs=2e-8)
    # Under mean gap the same contact passes through that tension, and not much through more.
    least = min(s.load for s in follow(
        problem, "mean-gap", np.linspace(event.before.mean_gap - 0.05, event.before.mean_gap + 0.05, 9), Settings(1e-8),
        [solve(problem, "mean-pressure", 0.0, Settings(1e-8), states[2].gap)],
    ))  # fmt: skip
    assert least == pytest.approx(held, abs=2e-5)


def test_without_adhesion_no_tension_is_held() -> None:
    state = solve(rough(64, LennardJonesSpline(0.0)), "mean-pressure", -1e-4, Settings(1e-8))
    assert state.status is Outcome.PULLED_OFF
    assert state.solution.residual == 1e-4
    assert not state.solution.status.ok


# --- repulsive area ----------------------------------------------------------------------------------------


@given(st.integers(0, 10**6), st.sampled_from([0.0, 0.005, 0.05]), st.floats(0.004, 0.3), st.sampled_from([0.01, 0.1]))
@settings(max_examples=5)  # of three states each
def test_an_area_is_met_or_said_to_be_jumped_over(seed: int, length: float, target: float, tolerance: float) -> None:
    problem = rough(64, LennardJonesSpline(adhesion_length=length), seed)
    # Half the area on the approach, then the target, then back.
    search = Search(area_tolerance=tolerance)
    states = list(follow(problem, "repulsive-area", [target / 2, target, target / 2], Settings(1e-7), (), search))
    allowed = max(tolerance * target, 0.5 / problem.grid.size) * 1.001
    for state in states:
        assert state.solution.status.ok
        if state.status.ok:
            assert abs(state.area_rep - state.target) <= allowed
            alone = solve(problem, "mean-gap", state.mean_gap, Settings(1e-7), state.gap)
            assert abs(alone.area_rep - state.area_rep) <= 1 / problem.grid.size
        else:
            assert state.status is Outcome.JUMPED_OVER
            assert state.beyond is not None
            (event,) = state.events
            sides = sorted([event.before.area_rep, event.after.area_rep])
            assert sides[0] < state.target < sides[1]
            assert abs(event.before.mean_gap - event.after.mean_gap) <= RESOLUTION * problem.heights.std()
            assert state.area_rep == event.before.area_rep
            assert state.beyond.area_rep == event.after.area_rep


def test_a_search_begins_on_coarser_grids_and_says_what_it_took() -> None:
    problem = rough(256, LennardJonesSpline(0.3464))
    state = solve(problem, "repulsive-area", 0.03, Settings(1e-7))
    assert state.status.ok
    assert state.area_rep == pytest.approx(0.03, rel=0.01)
    assert state.search_solves > 3
    # The grids of 128 and 64 points a side do most of it; in all it is a few solves of the fine grid.
    cold = solve(problem, "mean-gap", state.mean_gap, Settings(1e-7)).solution.fft_pairs
    assert state.solution.fft_pairs < cold
    assert state.search_pairs < 4 * cold


WALLS: list[Wall] = [
    LennardJonesSpline(0.3464),
    InversePowers((9, 3), adhesion_length=0.005),
    HardWall(),
]


@pytest.mark.parametrize("wall", WALLS, ids=lambda wall: type(wall).__name__)
def test_an_area_is_reached_there_and_back(wall: Wall) -> None:
    problem = rough(64, wall)
    gaps = [wall.zero_gap + gap for gap in (0.9, 0.6, 0.45, 0.7)]
    path = list(follow(problem, "mean-gap", gaps, Settings(1e-7)))
    areas = [state.area_rep for state in path]
    found = list(follow(problem, "repulsive-area", areas, Settings(1e-7)))
    assert [state.branch for state in found] == ["start", "approach", "approach", "retract"]
    for one, other in zip(found, path, strict=True):
        assert one.status.ok
        # 1 % of the area, of 100 to 1000 points; where it grows by e in about 0.5 a0, that is 0.005 a0, and
        # twice that with half a point.
        assert one.area_rep == pytest.approx(other.area_rep, rel=0.01 * (1 + 1e-9), abs=0.5 / problem.grid.size)
        assert one.mean_gap == pytest.approx(other.mean_gap, abs=0.01)
    loads = [state.load for state in path if state.load > 0]
    for state in follow(problem, "mean-pressure", loads, Settings(1e-8)):
        near = min(path, key=lambda other: abs(other.load - state.target))
        assert state.area_rep == pytest.approx(near.area_rep, abs=1.5 / problem.grid.size)
        assert state.mean_gap == pytest.approx(near.mean_gap, abs=1e-4)


def test_under_a_hard_wall_no_load_is_a_touch_and_tension_is_none() -> None:
    problem = rough(64, HardWall())
    touch, pull = follow(problem, "mean-pressure", [0.0, -1e-6], TIGHT)
    assert touch.status.ok
    assert touch.area_rep == touch.load == 0
    np.testing.assert_allclose(touch.gap, problem.heights - problem.heights.min(), atol=1e-300)
    assert pull.status is Outcome.PULLED_OFF


# --- jumps -------------------------------------------------------------------------------------------------

FLAT_WALL = LennardJonesSpline(0.3)


def flat(stiffness: float) -> ContactProblem:
    grid = Grid.square(4)
    return ContactProblem(grid, FLAT_WALL, np.zeros(grid.shape), HalfSpace(stiffness))


def snaps(stiffness: float) -> tuple[float, float]:
    """Separations at which flats on springs snap in and out: where the law softens by the stiffness.

    K (z - D) = p(z), stable where K > p'(z) = -(law's stiffness); x = z - a0, p = -k x (1 - x/r)², k = 1/2::

        p' = -k (1 - x/r)(1 - 3x/r) = K,     D = z - p(z)/K
    """
    k, r = 0.5, 0.3

    def softening(x: float) -> float:
        return -k * (1 - x / r) * (1 - 3 * x / r) - stiffness

    def separation(x: float) -> float:
        return 1 + x + k * x * (1 - x / r) ** 2 / stiffness

    most = 2 / 3 * r  # of the softening
    return separation(brentq(softening, most, r)), separation(brentq(softening, r / 3, most))


@pytest.mark.parametrize("stiffness", [0.02, 0.12])
def test_flats_on_springs_snap_where_the_law_softens_by_their_stiffness(stiffness: float) -> None:
    snap_in, snap_out = snaps(stiffness)
    assert snap_in < snap_out
    targets = [snap_out + 0.5, 0.95, snap_out + 0.5]
    search = Search(event_resolution=1e-3, event_threshold=0.05)
    states = list(follow(flat(stiffness), "separation", targets, TIGHT, (), search))
    assert all(state.status.ok for state in states)
    inward, outward = jumps(states)
    assert (inward.kind, outward.kind) == ("jump-in", "pull-off")
    for event, exact in ((inward, snap_in), (outward, snap_out)):
        low, high = sorted([event.before.value, event.after.value])
        assert high - low <= 1e-3
        assert low <= exact <= high


def test_flats_on_stiff_springs_do_not_snap() -> None:
    # Largest softening 1/6.  The repulsive area passes from 0 to 1 at once as the gap passes a0: no jump.
    search = Search(event_resolution=1e-3, event_threshold=0.05)
    states = list(follow(flat(0.2), "separation", [1.5, 0.9, 1.5], TIGHT, (), search))
    assert [state.area_rep for state in states] == [0, 1, 0]
    assert not jumps(states)


@pytest.mark.long
def test_a_bracket_holds_the_jump_that_a_fine_path_finds() -> None:
    grid = Grid((64, 8), (64.0, 8.0))
    heights = sine(grid, 1.0, (1, 0))
    problem = ContactProblem(grid, LennardJonesSpline(adhesion_length=0.05), heights, HalfSpace("clamped"))
    fine = 0.01
    ends = (3.2, 2.2)
    down = np.round(np.arange(ends[0], ends[1] - fine / 2, -fine), 6).tolist()
    path = list(follow(problem, "mean-gap", [*down, *down[-2::-1]], Settings(1e-8)))
    loads = np.array([state.load for state in path])
    search = Search(event_resolution=0.002, event_threshold=0.02)
    inward, *rest = jumps(list(follow(problem, "mean-gap", [*ends, ends[0]], Settings(1e-8), (), search)))
    outward = rest[-1]
    # The work of a closed loop is what its jumps dissipate: positive.
    assert np.trapezoid(loads, [state.mean_gap for state in path]) < -1e-4
    # Hysteresis: the wave lets go farther out than it caught on.
    assert inward.kind == "jump-in"
    assert outward.kind in ("jump-out", "pull-off")
    assert outward.after.value > inward.before.value
    for event, part in ((inward, slice(0, len(down))), (outward, slice(len(down) - 1, None))):
        change = np.abs(np.diff(loads[part]))
        i = int(change.argmax())
        one, other = path[part][i].target, path[part][i + 1].target
        assert min(one, other) - 1e-3 <= event.before.value <= max(one, other) + 1e-3
        assert min(one, other) - 1e-3 <= event.after.value <= max(one, other) + 1e-3
        assert abs(event.after.load - event.before.load) == pytest.approx(change[i], rel=0.2)


def test_a_sphere_comes_off_between_jkr_and_dmt() -> None:
    # Maugis' λ = σ0 (9R/(2π w E*²))^(1/3) = 1.5: P between 1.5 π w R (JKR) and 2 π w R (DMT), nearer to the first.
    grid, wall, radius = Grid.square(96, 1.5), LennardJonesSpline(adhesion_length=0.05), 200.0
    problem = ContactProblem(grid, wall, sphere(grid, radius), HalfSpace("clamped"))
    scale = np.pi * wall.work_of_adhesion * radius / grid.area
    tensions = []
    for control, ends, resolution in (
        ("mean-gap", [9.0, 12.0], 0.02),
        ("mean-pressure", [0.0, -3 * scale], 0.01 * scale),
    ):
        search = Search(event_resolution=resolution, event_threshold=0.003)
        first, last = follow(problem, control, ends, Settings(1e-7), (), search)
        assert first.status.ok
        assert last.branch == "retract"
        (off,) = (event for event in last.events if event.kind == "pull-off")
        assert abs(off.after.value - off.before.value) <= resolution
        assert last.lowest is not None
        tensions.append(-last.lowest[0] / scale)
    # The images of the sphere, 144 a0 away, pull the surface up with it: contact radius 19 a0, a few percent.
    assert 1.5 * 0.97 < tensions[0] < 2.0
    # Grips hold the sphere on beyond the largest tension, which they see smoothly; a load does not.
    assert off.before.load / scale == pytest.approx(-tensions[0], abs=0.02)
    assert off.after.load == 0


# --- memory --------------------------------------------------------------------------------------------------


def _arrays() -> int:
    """Memory of numpy's arrays, without what the interpreter and other libraries hold."""
    domain = tracemalloc.DomainFilter(True, np.lib.tracemalloc_domain)
    return sum(trace.size for trace in tracemalloc.take_snapshot().filter_traces([domain]).traces)


@pytest.mark.parametrize(
    ("control", "targets", "resolution"),
    [
        pytest.param("mean-gap", [2.2, 2.1, 2.0], None, marks=pytest.mark.long),
        ("mean-gap", [3.0, 2.95, 3.0], 0.1),
        pytest.param("repulsive-area", [0.1, 0.15], None, marks=pytest.mark.long),
    ],
)
def test_a_path_holds_one_field_between_points(
    control: Control, targets: list[float], resolution: float | None
) -> None:
    problem, loose = rough(256, LennardJonesSpline(0.3464)), Settings(1e-5)
    size = problem.grid.size * 8
    search = Search(event_resolution=resolution, area_tolerance=0.1)
    solver = solver_of(problem, loose)
    list(follow(problem, control, targets, loose, (), search, solver))  # compiles, and makes the arrays of the solver
    tracemalloc.start()
    try:
        for state in follow(problem, control, targets, loose, (), search, solver):
            assert state.status.ok
            del state
            # Its gap, with padded rows (3 %); the numbers of another state.
            assert _arrays() < 1.1 * size
        # Of a solve 9.0, of the state it starts from 1.0; the start on coarser grids 0.3.
        assert tracemalloc.get_traced_memory()[1] < 10.5 * size
    finally:
        tracemalloc.stop()


# --- runs --------------------------------------------------------------------------------------------------

PATH = (
    SMALL[: SMALL.index("[loading]")].replace("adhesion_length = 0.005", "adhesion_length = 0.05")
    + """\
[loading]
control = "repulsive-area"
targets = [0.02, 0.1, 0.11]
event_resolution = 0.01
event_threshold = 0.03

[loading.retraction]
control = "mean-pressure"
targets = [0.0, -0.004, -0.09, -0.1]

[output]
fields = true
"""
)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Result:
    """The path that nothing has stopped."""
    folder = tmp_path_factory.mktemp("whole")
    (folder / "path.toml").write_text(PATH)
    return follow_run(load(folder / "path.toml", RunConfig), folder / "whole.h5")


@pytest.mark.parametrize(
    "points", [pytest.param(1, marks=pytest.mark.long), 3, pytest.param(5, marks=pytest.mark.long)]
)
def test_a_stopped_path_with_jumps_goes_on_as_if_it_had_not(whole: Result, tmp_path: Path, points: int) -> None:
    (tmp_path / "path.toml").write_text(PATH)
    config = load(tmp_path / "path.toml", RunConfig)
    with pytest.raises(KeyboardInterrupt):
        follow_run(config, tmp_path / "stopped.h5", progress=stop_after(points, KeyboardInterrupt))
    assert follow_run(config, tmp_path / "stopped.h5").events == whole.events
    same(tmp_path / "stopped.h5", whole.path)
    assert [step.status for step in whole.points[-2:]] == ["PULLED_OFF", "PULLED_OFF"]
    assert [event.kind for _, event in whole.events].count("pull-off") == 1
    file = store.read_datasets(whole.path, RunConfig.result_schema, RunConfig.result_version)
    assert file.attributes["smallest_load"] == min(e.before.load for _, e in whole.events if e.kind == "pull-off")
    assert file.attributes["jumps"] == len(whole.events)


def test_what_has_no_state_is_shown_with_both_sides(
    whole: Result, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "path.toml").write_text(PATH)
    shutil.copy(whole.path, tmp_path / "path.h5")
    assert main(["run", str(tmp_path / "path.toml"), "-o", str(tmp_path)]) == 1
    out = capsys.readouterr().out
    assert "pulled off" in out
    assert "the contact does not hold this tension" in out
    assert "states on both sides" in out
    assert "left" in out
    assert main(["plot", str(tmp_path / "path.h5")]) == 0


@pytest.mark.parametrize(
    ("old", "new", "key", "words"),
    [
        ("[0.02, 0.1, 0.11]", "[0.1, 0.02]", "loading.targets", "increasing"),
        ("[0.02, 0.1, 0.11]", "[2.0, 10.0]", "loading.targets", "between 0 and 1"),
        ("[0.0, -0.004, -0.09, -0.1]", "[0.0, 0.1]", "loading.retraction.targets", "decreasing"),
        ("event_resolution = 0.01", "retract = true", "loading.retract", "false"),
        ("event_resolution = 0.01", "event_resolution = 0.0", "loading.event_resolution", "greater"),
        ("event_threshold = 0.03", "event_treshold = 0.03", "loading.event_treshold", "event_threshold"),
        ('"mean-pressure"', '"pressure"', "loading.retraction.control", "mean-pressure"),
    ],
)
def test_a_path_that_is_none_is_told(
    tmp_path: Path, old: str, new: str, key: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert old in PATH
    (tmp_path / "path.toml").write_text(PATH.replace(old, new))
    assert main(["run", str(tmp_path / "path.toml"), "-o", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert key in error
    assert words in error
    assert not (tmp_path / "out").exists()


@given(
    st.sampled_from(["separation", "mean-gap", "mean-pressure", "repulsive-area"]),
    st.lists(st.floats(0.001, 0.9), min_size=1, max_size=5, unique=True).map(sorted),
    st.booleans(),
)
def test_a_path_visits_each_target_and_the_same_ones_back(control: str, values: list[float], retract: bool) -> None:
    targets = tuple(values if control in ("mean-pressure", "repulsive-area") else values[::-1])
    table = LoadingTable(control=control, targets=targets, retract=retract)
    ((_, path),) = table.legs
    assert path[: len(targets)] == targets
    assert path[len(targets) :] == (targets[-2::-1] if retract else ())
    assert table.points == len(path)


SEARCH = """
import signal, sys, time
from functools import partial
from pathlib import Path
from continuum.front.cli import main
from continuum.front import runs as commands
from continuum.store.runs.result import Result
from continuum.solve.solver import Solver
config, folder, points = sys.argv[1:]
solve, seen, file = Solver.minimise, 0, Path(folder) / "path.h5"
def waiting(*arguments, **given):
    # In the second solve after so many points: here it is stopped, however fast this machine is.
    global seen
    seen += file.exists() and len(Result.read(file).points) == int(points)
    if seen == 2:
        print("now", flush=True)
        time.sleep(30)
    return solve(*arguments, **given)
Solver.minimise = waiting
commands.follow_run = partial(commands.follow_run, every=0.0)  # each point is in the file
# A test runner that was itself started in the background ignores it, and so do all that it starts.
signal.signal(signal.SIGINT, signal.default_int_handler)
sys.exit(main(["run", config, "-o", folder]))
"""


@pytest.mark.long
def test_ctrl_c_in_the_middle_of_a_search_leaves_what_is_finished(tmp_path: Path) -> None:
    """The second point takes a search, the fourth one bisection: each is stopped in the second of its solves."""
    config = tmp_path / "path.toml"
    config.write_text(PATH)
    assert main(["run", str(config), "-o", str(tmp_path / "whole")]) == 1
    result = tmp_path / "stopped" / "path.h5"
    for points in (1, 3):
        command = [sys.executable, "-c", SEARCH, str(config), str(result.parent), str(points)]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        assert process.stdout is not None
        assert "now\n" in process.stdout  # read until it says so
        process.send_signal(signal.SIGINT)
        _, error = process.communicate(timeout=120)
        assert process.returncode == 130
        assert "the same command continues from there" in error
        assert _points(result) == points
        assert not list(result.parent.glob(".*.tmp"))
    assert main(["run", str(config), "-o", str(result.parent)]) == 1
    same(result, tmp_path / "whole" / "path.h5")


def _points(result: Path) -> int:
    return int(store.read_datasets(result, RunConfig.result_schema, RunConfig.result_version)["step"].size)


# --- resolution --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("cut", "slope", "wall", "words"),
    [
        (8.0, 0.1, LennardJonesSpline(adhesion_length=0.005), []),
        (3.0, 0.1, LennardJonesSpline(0.0), ["shortest wavelength"]),
        (4.0, 0.1, LennardJonesSpline(0.0), []),  # just the four points that are needed
        (8.0, 0.3, LennardJonesSpline(adhesion_length=0.0005), ["attracts over 0.11"]),
        (8.0, 0.1, Exponential(0.2, 0.4, 5.0), ["softens"]),  # γ/ρ² = 1.25: waves above 2.5 a0 snap in
    ],
)
def test_what_the_grid_does_not_resolve_is_warned_of(cut: float, slope: float, wall: Wall, words: list[str]) -> None:
    grid = Grid.square(64)
    heights = SelfAffine(0.8, slope, cut, 32.0).synthesise(grid, np.random.default_rng(1))
    problem = ContactProblem(grid, wall, heights, HalfSpace("clamped"))
    rms_slope = moments(grid, heights).rms_slope
    for shortest in (cut, None):  # given, or seen from the heights
        found = list(unresolved(problem, rms_slope, shortest))
        assert len(found) == len(words)
        for sentence, word in zip(found, words, strict=True):
            assert word in sentence or (shortest is None and "waves of fewer than 4 points" in sentence)
            assert "raise" in sentence


def test_warnings_are_shown_and_stored(small: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    small.write_text(SMALL.replace("lambda_s = 6.0", "lambda_s = 3.0"))
    for command in (["check", str(small)], ["run", str(small), "-o", str(tmp_path)]):
        assert main(command) == 0
        assert "warning: the shortest wavelength, 3 a0" in capsys.readouterr().err
    file = store.read_datasets(tmp_path / "small.h5", RunConfig.result_schema, RunConfig.result_version)
    assert "shortest wavelength" in str(file.attributes["warnings"])


def test_every_state_of_a_path_knows_how_it_ended() -> None:
    state = solve(rough(64, LennardJonesSpline(0.3464)), "repulsive-area", 0.05, Settings(1e-9, max_iterations=2))
    assert state.status is Status.ITERATION_LIMIT


def test_a_rough_tolerance_on_many_grids_still_finds_the_area() -> None:
    # Each of the coarser grids used to take three times the tolerance of the one before, which ended above 1.
    grid = Grid.square(512)
    heights = SelfAffine(0.8, 0.1, 64.0, 256.0).synthesise(grid, np.random.default_rng(1))
    problem = ContactProblem(grid, LennardJonesSpline(0.0), heights, HalfSpace("clamped"))
    state = solve(problem, "repulsive-area", 0.02, Settings(1e-7), search=Search(area_tolerance=0.3))
    assert state.status.ok
    assert state.area_rep == pytest.approx(0.02, rel=0.3)
