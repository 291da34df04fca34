"""The front door: what it offers, that it says the same as the rooms behind, and how it shows itself."""

from __future__ import annotations

import base64
import operator
from collections.abc import Callable
from pathlib import Path
from typing import get_overloads, get_type_hints
from xml.etree import ElementTree

import numpy as np
import pytest
import xarray
from matplotlib.figure import Figure

import atomistic as a
import continuum as c
from continuum.inputs.arguments import ArgumentError
from continuum.inputs.errors import InputError
from continuum.path.loading import solve
from tests.problems import SMALL, Rough


@pytest.fixture(scope="module")
def contact() -> c.Contact:
    return c.Contact(Rough(48).heights(), wall=c.LennardJonesSpline(adhesion_length=0.005))


@pytest.mark.parametrize("package", [c, a])
def test_every_name_is_there_and_says_what_it_is(package) -> None:
    assert len(package.__all__) <= 50, "what is looked over at one glance"
    assert set(package.__all__) <= set(dir(package))
    for name in package.__all__:
        assert getattr(package, name).__doc__, name
    with pytest.raises(AttributeError, match="nothing"):
        operator.attrgetter("nothing")(package)


@pytest.mark.parametrize(
    ("given", "control", "target"),
    [
        ({"area": 0.05}, "repulsive-area", 0.05),
        ({"mean_gap": 2.0}, "mean-gap", 2.0),
        ({"separation": 2.0}, "separation", 2.0),
        ({"pressure": 1e-3}, "mean-pressure", 1e-3),
    ],
)
def test_pressing_is_solving(contact: c.Contact, given: dict[str, float], control, target: float) -> None:
    state = contact.press(**given).require()
    same = solve(contact.problem, control, target, contact.settings)
    np.testing.assert_array_equal(state.gap, same.gap)
    assert state.load == same.load
    m = state.measure()
    assert m.kappa == pytest.approx(contact.moments.rms_slope * state.area_rep / state.load)
    assert 1 / m.kappa == pytest.approx(1 / m.kappa_rep - 1 / m.kappa_att)
    assert "κ" in state._repr_html_()


def test_a_path_knows_its_pull_off(contact: c.Contact) -> None:
    seen = []
    path = contact.path(mean_gap=[2.5, 2.0, 1.5, 2.0, 2.5, 3.0], progress=seen.append)
    assert [s.branch for s in path] == ["start", "approach", "approach", "retract", "retract", "retract"]
    assert seen == list(path)
    assert path.pull_off == -min(s.load for s in path[2:])
    assert path[-1].mean_gap == pytest.approx(3.0)
    assert len(path[1:3]) == 2
    assert path._repr_html_().count("<tr>") == 7
    assert path.plot().axes
    assert path[0].plot().axes


def test_one_control_at_a_time_and_heights_that_are_a_map(contact: c.Contact) -> None:
    with pytest.raises(ValueError, match="give one of area, mean_gap, separation, pressure; here: none"):
        contact.press()
    with pytest.raises(ValueError, match="here: area and pressure"):
        contact.press(area=0.1, pressure=0.1)
    with pytest.raises(ValueError, match="two-dimensional"):
        c.Contact(np.arange(5.0), wall=c.HardWall())
    with pytest.raises(ValueError, match="slope"):
        c.Contact(np.ones((8, 8)), wall=c.HardWall())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"wall": None}, "wall = None: allowed: the law of a wall"),
        ({"wall": "hard"}, "wall = 'hard': allowed"),
        ({"wall": c.HardWall}, "wall = <class"),
        ({"substrate": 3}, "substrate = 3: allowed: an object with a method stiffness"),
        ({"substrate": c.HalfSpace}, "substrate = <class"),
        ({"period": 48}, "period = 48: allowed: two values"),
        ({"tolerance": 0.3}, "tolerance = 0.3: allowed: .* less than or equal to 0.01"),
        ({"area_tolerance": 0}, "area_tolerance = 0"),
        ({"threads": 0}, "threads = 0: allowed: a whole number from 1 to 1024"),
        ({"device": "abacus"}, 'device = \'abacus\': allowed: one of "cpu", "numpy", .*"cuda"'),
    ],
)
def test_a_contact_names_the_argument_that_has_no_meaning(arguments, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        c.Contact(**{"heights": Rough(16).heights(), "wall": c.HardWall(), **arguments})


def test_a_state_names_the_argument_that_has_no_meaning(contact: c.Contact) -> None:
    with pytest.raises(ValueError, match=r"area = 1\.0: allowed: .* less than 1"):
        contact.press(area=1.0)
    with pytest.raises(ValueError, match="pressure = '1e-3'"):
        contact.press(pressure="1e-3")
    with pytest.raises(ValueError, match=r"start = .*shape of the grid, \(48, 48\)"):
        contact.press(area=0.1, start=np.ones((4, 4)))
    with pytest.raises(ValueError, match=r"area = 0\.1: allowed: a list"):
        contact.path(area=0.1)
    with pytest.raises(ValueError, match=r"mean_gap = \[\]: allowed: a list of 1 to 10000 finite numbers"):
        contact.path(mean_gap=[])
    with pytest.raises(ValueError, match="progress = 3"):
        contact.path(mean_gap=[2.0], progress=3)


def test_a_start_may_be_a_state_or_its_gap(contact: c.Contact) -> None:
    start = contact.press(mean_gap=2.0)
    from_state, from_gap = (contact.press(mean_gap=1.9, start=each) for each in (start, start.gap))
    np.testing.assert_array_equal(from_state.gap, from_gap.gap)


def test_threads_and_tolerance_of_the_area_are_those_of_the_contact() -> None:
    heights = Rough(48).heights()
    one, two = (c.Contact(heights, wall=c.LennardJonesSpline(adhesion_length=0.005), threads=n) for n in (1, 2))
    np.testing.assert_array_equal(one.press(mean_gap=1.5).gap, two.press(mean_gap=1.5).gap)
    loose = c.Contact(heights, wall=c.HardWall(), area_tolerance=0.3).press(area=0.1).require()
    assert loose.search_solves < c.Contact(heights, wall=c.HardWall()).press(area=0.1).search_solves


@pytest.mark.parametrize(
    ("spectrum", "wall", "message"),
    [
        (c.SelfAffine(0.8, 0.1, 2.5, 16), c.HardWall(), "waves of fewer than 4 points"),
        (c.SelfAffine(0.8, 0.3, 8, 16), c.LennardJonesSpline(adhesion_length=0.0005), "attracts over"),
        (c.SelfAffine(0.8, 0.1, 8, 16), c.LennardJonesSpline(range=0.3, minimum_stiffness=4.0), "softens so much"),
        (c.SelfAffine(0.8, 0.31, 8, 16), c.HardWall(), r"the rms slope, 0\.31, is above 0\.3"),
    ],
)
def test_a_contact_warns_of_what_the_grid_does_not_resolve_as_an_input_does(spectrum, wall, message: str) -> None:
    heights = spectrum.synthesise(c.Grid.square(32), np.random.default_rng(1))
    with pytest.warns(UserWarning, match=message):
        c.Contact(heights, wall=wall)


@pytest.mark.parametrize("seed", range(40))
def test_the_largest_slope_of_the_paper_is_not_called_steep(seed: int) -> None:
    heights = c.SelfAffine(0.8, 0.3, 8, 16).synthesise(c.Grid.square(32), np.random.default_rng(seed))
    c.Contact(heights, wall=c.HardWall())  # a warning would be an error


@pytest.mark.filterwarnings("ignore:not converged")
def test_a_path_of_which_nothing_converged_shows_why(contact: c.Contact) -> None:
    path = c.Contact(contact.heights, wall=contact.wall, max_iterations=1).path(mean_gap=[2.0, 1.5, 2.0])
    assert repr(path) == "LoadingPath(3 states, 0 converged, pull-off tension nan E*)"
    assert path._repr_html_().count("iteration_limit") == 3
    with pytest.raises(ValueError, match="no equilibrium"):
        _ = path.adhesion
    gone = contact.path(pressure=[-0.9])
    assert "0 converged" in repr(gone)
    assert "pulled_off" in gone._repr_html_()
    assert np.isnan(gone.pull_off)


@pytest.mark.filterwarnings("ignore:not converged")
def test_what_is_not_converged_says_why_when_it_is_required(contact: c.Contact) -> None:
    hasty = c.Contact(contact.heights, wall=contact.wall, max_iterations=2)
    state = hasty.press(mean_gap=2.0)
    assert not state.converged
    with pytest.raises(c.NotConvergedError, match="iteration limit"):
        state.require()
    with pytest.raises(c.NotConvergedError, match="tension"):
        contact.press(pressure=-0.5).require()


def test_commands_as_functions(tmp_path: Path, drawn: dict[str, Figure]) -> None:
    (tmp_path / "small.toml").write_text(SMALL)
    assert "memory" in c.check(tmp_path / "small.toml").sheet.text()
    result = c.run(tmp_path / "small.toml", tmp_path)
    assert result.path == tmp_path / "small.h5"
    assert result.converged
    assert c.run(tmp_path / "small.toml", tmp_path / "small.h5").resumed == 5
    found = result.analyse()
    assert "κ_rep" in found._repr_html_()
    assert result._repr_html_().count("<tr>") == 6
    frame = result.to_pandas()
    assert list(frame["load"]) == [point.load for point in result.points]
    assert frame.index.name == "step"
    assert frame.attrs["units"]["mean_gap"] == "a0"
    data = result.to_xarray()
    for engine in ("scipy", "h5netcdf"):
        data.to_netcdf(tmp_path / f"{engine}.nc", engine=engine)
        with xarray.open_dataset(tmp_path / f"{engine}.nc", engine=engine) as stored:
            xarray.testing.assert_equal(stored, data)
    # No name is that of a method, so that each is an attribute as well.
    assert not set(map(str, data.variables)) & set(dir(xarray.Dataset))
    assert data.load_net.values.tolist() == [point.load for point in result.points]
    assert data["gap"].dims == data["repulsive"].dims == ("step", "x", "y")
    assert data["repulsive"].dtype == bool
    for step in range(5):
        np.testing.assert_array_equal(data["repulsive"][step], result.repulsive(step))
    np.testing.assert_array_equal(data["attracted"][1, 3, 2:9], result.contact_map(1)[3, 2:9] == 1)
    assert data["status"].attrs["flag_meanings"].split()[data["status"][0].item()] == "CONVERGED"
    assert repr(result).endswith("5 points, 5 converged, 0 jumps)")
    assert {path.name for path in c.plot(result.path)} == drawn.keys() == {"small-contact", "small-area-and-load"}
    assert len(c.plot(found)) == 4
    np.testing.assert_array_equal(result.contact_map(0) == 2, result.repulsive(0))
    for look in (result.gap, result.repulsive, result.contact_map):
        np.testing.assert_array_equal(look(-1), look(4))
        for index in (5, 99, -6, [0], 1.0, None, "0", True):
            with pytest.raises(ArgumentError, match="whole number from -5 to 4: the run has 5 points"):
                look(index)


def test_a_prediction_in_one_line(tmp_path: Path) -> None:
    np.save(tmp_path / "map.npy", Rough(32).heights())
    found = c.predict(tmp_path / "map.npy", size="10nm", unit="A", material=["mica", "mica"], solve=False)
    assert "threshold w_c = " in found.sentence
    assert "critical work of adhesion" in found._repr_html_()
    assert found.write(tmp_path / "page", "map")[0].stat().st_size > 10000


def test_a_deck_under_a_contact_of_your_own(contact: c.Contact, tmp_path: Path) -> None:
    deck = a.deck(contact, a.Springs(), separation=2.0, depth=6.0)
    assert deck.slab.shape == contact.grid.shape
    np.testing.assert_array_equal(deck.heights, contact.heights)
    assert (deck.write(tmp_path / "deck") / "in.contact").is_file()
    with pytest.raises(InputError, match="separation"):
        a.deck(contact)
    with pytest.raises(TypeError, match="LennardJonesSpline"):
        a.deck(c.Contact(contact.heights, wall=c.HardWall()), separation=2.0)
    with pytest.raises(ValueError, match="spacing"):
        a.deck(c.Contact(contact.heights, wall=contact.wall, period=(24.0, 24.0)), separation=2.0)


def test_the_certificate_of_a_state_is_relative_to_its_own_tractions_and_energy() -> None:
    state = c.Contact(Rough(48).heights(), wall=c.HardWall()).press(pressure=0.01).require()
    assert state.residual <= 1e-6
    assert state.residual == state.solution.residual / state.contact.moments.rms_slope
    # Clapeyron: of the elastic energy twice is the work of the tractions on the displacement, its mean apart.
    displacement = state.contact.heights - state.gap
    work = -np.mean(state.traction * (displacement - displacement.mean()))  # compression pushes the surface away
    assert state.contact.problem.elastic_energy(state.gap) == pytest.approx(work / 2, rel=1e-6)
    assert 0 <= state.duality_gap < 1e-4
    assert "duality gap, of the elastic energy" in state.sheet().text()
    soft = c.Contact(Rough(48).heights(), wall=c.LennardJonesSpline(adhesion_length=0.005)).press(mean_gap=2.0)
    assert np.isnan(soft.duality_gap)
    assert "duality" not in soft.sheet().text()


def test_python_finds_what_others_expect(contact: c.Contact, tmp_path: Path) -> None:
    path = contact.path(mean_gap=[1.6, 1.4])
    frame = path.to_pandas()
    assert list(frame["load"]) == [state.load for state in path]
    assert frame.attrs["units"]["load"] == "E*"
    assert get_type_hints(get_overloads(c.LoadingPath.__getitem__)[0])["return"] is c.State
    # VTK: x changes fastest, and each array has its length before it.
    image = ElementTree.parse(path[-1].save_vtk(tmp_path / "state.vti")).getroot()
    nx, ny = contact.grid.shape
    assert image.find(".//Piece").attrib["Extent"] == f"0 {nx - 1} 0 {ny - 1} 0 0"
    arrays = {each.attrib["Name"]: base64.b64decode(each.text or "") for each in image.iter("DataArray")}
    assert int.from_bytes(arrays["gap"][:8], "little") == len(arrays["gap"]) - 8
    gap = np.frombuffer(arrays["gap"][8:], "<f8").reshape(ny, nx)
    np.testing.assert_array_equal(gap.T, path[-1].gap)
    assert {file.name for shown in (path, path[0]) for file in c.plot(shown, tmp_path)} == {
        "loadingpath.png",
        "state.png",
    }
    with pytest.raises(TypeError, match="did you mean adhesion_length"):
        c.LennardJonesSpline(adhesion_lenght=0.005)


def test_a_state_that_is_none_is_told_once_with_the_likely_cause(contact: c.Contact) -> None:
    in_metres = c.Contact(1e-10 * np.asarray(contact.heights), c.LennardJonesSpline(0.005), max_iterations=1)
    with pytest.warns(c.NotConvergedWarning, match=r"1 of 2 states.*probably in metres") as said:
        in_metres.path(mean_gap=[1.5, 0.99])
    assert len(said) == 1
    assert said[0].filename == __file__  # the line of the caller


def test_an_unknown_argument_says_which_one_is_meant(contact: c.Contact, tmp_path: Path) -> None:
    heights, wall = contact.heights, contact.wall
    calls: list[tuple[Callable[..., object], tuple[object, ...], str, str]] = [
        (c.Contact, (heights, wall), "substarte", "substrate"),
        (contact.press, (), "mean_gaps", "mean_gap"),
        (contact.path, (), "seperation", "separation"),
        (c.run, (SMALL, tmp_path), "forse", "force"),
        (c.check, (SMALL,), "reduce", "reduced"),
        (c.sweep, (SMALL, tmp_path), "worker", "workers"),
        (c.predict, (heights,), "modulu", "modulus"),
    ]
    for called, given, wrong, meant in calls:
        with pytest.raises(TypeError, match=f"'{wrong}'; did you mean {meant}"):
            called(*given, **{wrong: 1})
    assert not list(tmp_path.iterdir())


def test_settings_merge_into_a_table_or_replace_it_by_one_that_says_its_kind(tmp_path: Path) -> None:
    (tmp_path / "small.toml").write_text(SMALL)
    changed = {"surface": {"seed": 7}, "wall": {"law": "hard"}}
    config = c.check(tmp_path / "small.toml", changed).system.config
    assert (config.surface.seed, config.surface.hurst) == (7, 0.8)
    assert config.plain()["wall"] == {"law": "hard", "hardness": None}
