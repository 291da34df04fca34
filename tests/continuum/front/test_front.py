"""The front door: what it offers, that it says the same as the rooms behind, and how it shows itself."""

from __future__ import annotations

import operator
from pathlib import Path

import numpy as np
import pytest

import atomistic as a
import continuum as c
from continuum.errors import InputError
from continuum.path.loading import solve
from tests.problems import SMALL, Rough


@pytest.fixture(scope="module")
def contact() -> c.Contact:
    return c.Contact(Rough(48).heights(), wall=c.LennardJonesSpline(adhesion_length=0.005))


@pytest.mark.parametrize("package", [c, a])
def test_every_name_is_there_and_says_what_it_is(package) -> None:
    assert len(package.__all__) <= 40, "what is looked over at one glance"
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
    with pytest.raises(ValueError, match="two directions"):
        c.Contact(np.arange(5.0), wall=c.HardWall())
    with pytest.raises(ValueError, match="slope"):
        c.Contact(np.ones((8, 8)), wall=c.HardWall())


def test_what_is_not_converged_says_why_when_it_is_required(contact: c.Contact) -> None:
    hasty = c.Contact(contact.heights, wall=contact.wall, max_iterations=2)
    state = hasty.press(mean_gap=2.0)
    assert not state.converged
    with pytest.raises(c.NotConvergedError, match="iteration limit"):
        state.require()
    with pytest.raises(c.NotConvergedError, match="tension"):
        contact.press(pressure=-0.5).require()


def test_commands_as_functions(tmp_path: Path) -> None:
    (tmp_path / "small.toml").write_text(SMALL)
    assert "memory" in c.check(tmp_path / "small.toml").sheet.text()
    result = c.run(tmp_path / "small.toml", tmp_path)
    assert result.path == tmp_path / "small.h5"
    assert result.converged
    assert c.run(tmp_path / "small.toml", tmp_path / "small.h5").resumed == 5
    found = result.analyse()
    assert "κ_rep" in found._repr_html_()
    assert result._repr_html_().count("<tr>") == 6
    assert result.to_xarray()["gap"].dims == ("step", "x", "y")
    assert {path.name for path in c.plot(result.path)} == {"small-contact.png", "small-area-and-load.png"}
    assert len(found.plot()) == 4
    np.testing.assert_array_equal(result.contact_map(0) == 2, result.repulsive(0))


def test_a_prediction_in_one_line(tmp_path: Path) -> None:
    np.save(tmp_path / "map.npy", Rough(32).heights())
    found = c.predict(tmp_path / "map.npy", size="10nm", unit="A", material=["mica", "mica"])
    assert "The paper's criterion by itself: " in found.sentence
    assert "Pastewka-Robbins" in found._repr_html_()
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
