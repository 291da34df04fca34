"""Atoms whose neighbours changed: none where a crystal is strained or warm, those beside a plane where it slips."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import atomistic as a
import continuum as c
from atomistic.crystal.crystal import LOST, Slab, distortion, slipped
from atomistic.crystal.faces import cell_of
from atomistic.lammps.result import DeckDescription, DeckResult, DeckStatus, read_result
from atomistic.relax.deckrun import DeckStep, DeckSteps
from atomistic.show.decks import draw_slip
from tests.printed import faults_in_print

SLAB = Slab((6, 5), mobile=5)

SITES = (SLAB.layers, *SLAB.shape, 3)


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1), st.floats(0, 0.1), st.integers(0, 5))
def test_atoms_that_move_by_less_than_a_tenth_keep_their_neighbours(seed: int, size: float, axis: int) -> None:
    # Two atoms that each move by 0.1 a0 at most are 1.2 a0 apart at most, and that is no lost neighbour.
    assert LOST > 1.2
    moved = np.random.default_rng(seed).normal(size=SITES)
    moved *= size / np.linalg.norm(moved, axis=-1, keepdims=True)
    assert not slipped(SLAB, moved).any()
    assert not slipped(SLAB, np.roll(moved, axis, axis=1)).any()


def test_a_crystal_that_is_stretched_to_its_strength_keeps_its_neighbours() -> None:
    # By a third across: bonds to the next layer are 1 to (1/2 + (4/3)²/2)^(1/2) = 1.179.
    moved = np.zeros(SITES)
    moved[..., 2] = SLAB.positions[..., 2] / 3
    assert not slipped(SLAB, moved).any()


@pytest.mark.parametrize("above", [1, 2, 4])
@pytest.mark.parametrize("along", [(1, 0), (0, 1), (0, -1), (1, 1)])
def test_where_a_crystal_slips_both_sides_of_the_plane_have_other_neighbours(
    above: int, along: tuple[int, int]
) -> None:
    moved = np.zeros(SITES)
    moved[:above, ..., :2] = along
    expected = np.zeros(SITES[:3], np.bool_)
    expected[above - 1 : above + 1] = True
    assert (slipped(SLAB, moved) == expected).all()


@pytest.mark.parametrize("seed", range(4))
def test_lost_and_found_neighbours_are_those_of_all_pairs(seed: int) -> None:
    """Against all pairs of atoms and their images: strong random displacements, on a period that is no square."""
    slab = Slab((4, 6), mobile=3)
    rng = np.random.default_rng(seed)
    moved = rng.normal(scale=0.25, size=(slab.layers, *slab.shape, 3))
    moved[slab.mobile :] = 0
    if seed % 2:
        moved[0, ..., 0] += 1.0
    sites = slab.positions.reshape(-1, 3)

    def apart(at: np.ndarray) -> np.ndarray:
        r = at[:, None] - at
        r[..., :2] -= np.array(slab.shape) * np.rint(r[..., :2] / slab.shape)
        return np.linalg.norm(r, axis=-1)

    mobile = np.arange(len(sites)) < slab.mobile * 24
    before = (np.abs(apart(sites) - 1) < 1e-9) & (mobile[:, None] | mobile)
    after = sites + moved.reshape(-1, 3)
    shifts = [np.array([i * 4, j * 6, 0]) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    # A bond is the same one while it is short to the same image.
    bonds = sites[:, None] - sites
    image = np.zeros_like(bonds)
    image[..., :2] = np.array(slab.shape) * np.rint(bonds[..., :2] / slab.shape)
    now = np.linalg.norm(after[:, None] - after - image, axis=-1)
    lost = (before & (now > LOST)).any(axis=1)
    near = np.min([np.linalg.norm(after[:, None] - after + shift, axis=-1) for shift in shifts], axis=0) < LOST
    gained = (near & ~(apart(sites) < LOST) & lost & lost[:, None]).any(axis=1)
    assert 0 < np.count_nonzero(lost & gained) < lost.size
    np.testing.assert_array_equal(slipped(slab, moved).ravel(), lost & gained)
    assert distortion(slab, moved) == pytest.approx(
        np.linalg.norm(moved.reshape(-1, 1, 3) - moved.reshape(-1, 3), axis=-1)[before].max(), rel=1e-12
    )


def test_atoms_that_leave_for_the_wall_have_lost_neighbours_and_found_none() -> None:
    moved = np.zeros(SITES)
    moved[0, ..., 2] = 5.0
    assert not slipped(SLAB, moved).any()


def test_atoms_that_exchange_neighbours_before_any_pair_has_moved_by_half_are_seen() -> None:
    # Second neighbours along the normal move to 0.97 of each other; the four beyond each of them stay behind.
    moved = np.zeros(SITES)
    for site, beyond, way in ((1, 0, -1), (3, 4, 1)):
        moved[site, 2, 2, 2] = 0.22 * way
        moved[beyond, ..., 2] = -0.2 * way
    found = slipped(SLAB, moved)
    assert found[1, 2, 2]
    assert found[3, 2, 2]
    assert distortion(SLAB, moved) < 0.5
    assert state(moved).status is DeckStatus.YIELDED
    assert state(np.zeros(SITES)).status is DeckStatus.CONVERGED


def state(moved: np.ndarray) -> DeckResult:
    flat = np.zeros(SLAB.shape)
    numbers = {column.name: 0.0 for column in fields(DeckResult) if column.metadata}
    return DeckResult(SLAB, flat, flat, flat, moved, np.zeros(SITES), **numbers)


def test_fixed_bonds_never_yield() -> None:
    moved = np.zeros(SITES)
    moved[0, ..., 0] = 1.0
    assert state(moved).slipped.any()
    assert not replace(state(moved), bonded=True).slipped.any()


@pytest.mark.parametrize("above", [1, 2, 3])
@pytest.mark.parametrize("along", [(1, 0), (-0.5, 0.75**0.5), (0, 1 / 3**0.5), (0, -1 / 3**0.5)])
def test_slip_on_a_close_packed_plane_changes_its_two_planes_and_no_other(
    above: int, along: tuple[float, float]
) -> None:
    """By a vector of the lattice, which restores the crystal, and by a partial one, which leaves a stacking fault."""
    slab = cell_of("fcc", "111").slab((6.0, 5.0), depth=3.0, reach=1.5, skin=0.25)
    plane = np.rint(-slab.positions[:, 2] / (2 / 3) ** 0.5)
    moved = np.zeros((slab.size, 3))
    moved[plane < above, :2] = along
    # Of the two opposite partial vectors one would put atoms on top of others, where no crystal slips to.
    r = (slab.positions + moved)[plane == above - 1][0] - slab.positions[plane == above]
    r[:, :2] -= slab.lengths * np.rint(r[:, :2] / slab.lengths)
    found = slipped(slab, moved)
    if np.linalg.norm(r, axis=1).min() > 0.99:
        np.testing.assert_array_equal(found, (plane == above - 1) | (plane == above))
    else:
        assert np.isclose(along[0], 0)
    # Periodic images: the crystal moved by any part of its period is the same one.
    assert not slipped(slab, np.full((slab.size, 3), (4.3, 2.1, 0.0))).any()


def steps_of(
    separations: list[float], slipped_from: int | None = None, moved: np.ndarray | None = None, power: float = 1.0
) -> DeckSteps:
    """A staircase under a wall whose load is a power of a0 less the separation, and whose area is constant."""
    zero = {column.name: 0.0 for column in fields(DeckStep) if column.metadata}
    loads = [max(1 - s, 0.0) ** power for s in separations]
    first = len(separations) if slipped_from is None else slipped_from
    steps = tuple(
        DeckStep(**zero | {
            "separation": s, "load": load, "load_rep": load, "area_rep": 0.5, "slipped": 3 * (i >= first),
            "status": "YIELDED" if i >= first else "CONVERGED",
        }) for i, (s, load) in enumerate(zip(separations, loads, strict=True))
    )  # fmt: skip
    last = state(np.zeros(SITES) if moved is None else moved)
    about = DeckDescription("", len(steps), {}, "X", "", 0.0, (), 1.0, None)
    return DeckSteps(Path("deck"), about, c.LennardJonesSpline(0.0), last.heights, steps, last.gap, last)


@settings(max_examples=30)
@given(st.lists(st.floats(-1, 0.9), min_size=2, max_size=8, unique=True))
def test_a_staircase_that_is_elastic_has_no_yield_and_gives_back_all_work(found: list[float]) -> None:
    down = [1.0, *sorted(found, reverse=True)]
    run = steps_of([*down, *down[-2::-1]], power=1.5)
    assert run.first_yield is None
    assert run.plastic is False
    assert run.imprint is not None
    assert (run.imprint.displaced, run.imprint.depth) == (0, 0)
    assert run.imprint.recovered == pytest.approx(1, abs=1e-12)  # sums of the same numbers in another order
    # Longer steps up err as longer steps down would.
    longer = steps_of([*down, down[-2], 1.0], power=1.5).imprint
    assert longer is not None
    assert longer.recovered == pytest.approx(1, abs=1e-12)
    # Without a way back, and while it bears a load, nobody knows what stays.
    assert steps_of(down).imprint is None
    assert steps_of([*down, *down[-2:0:-1]]).imprint is None


@settings(max_examples=30)
@given(st.lists(st.floats(0.01, 0.5), min_size=3, max_size=8), st.data())
def test_first_yield_lies_between_two_steps_where_a_straight_load_says(each: list[float], data: st.DataObject) -> None:
    s = (0.9 - np.cumsum(each)).tolist()
    at = data.draw(st.integers(2, len(s) - 1))
    found = steps_of(s, at).first_yield
    assert found is not None
    ends = np.array([s[at - 1], s[at]])
    for value, (middle, half) in ((ends, found.separation), (1 - ends, found.load), (2 * (1 - ends), found.pressure)):
        # The slope is a difference of numbers of order one over 0.01 at least.
        assert middle == pytest.approx(value.mean(), abs=1e-12)
        assert half == pytest.approx(abs(value[1] - value[0]) / 2, abs=1e-12)
    # Less than two states before it, or one out of contact, tell no slope.
    assert steps_of(s, 1).first_yield is None
    lost = list(steps_of(s, 2).steps)
    lost[0] = replace(lost[0], area_rep=0.0)
    assert replace(steps_of(s, 2), steps=tuple(lost)).first_yield is None


def test_slip_that_a_smaller_load_keeps_and_none_does_not_is_not_plastic() -> None:
    run = steps_of([1.0, 0.5, 0.0, -0.1, 0.3, 0.7, 1.0], 3)
    assert run.unloaded == 6
    assert run.plastic is True
    back = [replace(step, slipped=0, status="CONVERGED") for step in run.steps[5:]]
    sprang = replace(run, steps=(*run.steps[:5], *back))
    assert sprang.steps[4].slipped
    assert sprang.unloaded == 6
    assert sprang.plastic is False
    assert replace(run, steps=run.steps[:5]).plastic is None


def test_an_imprint_is_what_has_not_sprung_back() -> None:
    moved = np.zeros(SITES)
    moved[0, 2, 2] = (0.0, 0.0, -0.6)
    moved[1, 2, 2, 0] = 0.4
    found = steps_of([1.0, 0.5, 0.0, 1.0], 2, moved).imprint
    assert found is not None
    # Down 1/8 + 3/8 of the work, and up 1/2 of it in one step.
    assert (found.displaced, found.depth, found.recovered) == (1, 0.6, pytest.approx(1))
    lost = steps_of([1.0, 0.5, 0.0, 0.5, 1.0], 2, moved)
    half = [replace(step, load=step.load * (i < 3)) for i, step in enumerate(lost.steps)]
    given_back = replace(lost, steps=tuple(half)).imprint
    assert given_back is not None
    assert given_back.recovered == pytest.approx(0.5)  # a triangle of half a step


def test_copper_slips_under_a_sharp_sphere_and_springs_back(tmp_path: Path) -> None:
    # 3 a0 deep into 11 a0: mean strains of tens of percent, beyond the strength of any crystal.
    with pytest.warns(UserWarning, match="slope"):
        contact = c.Contact(c.sphere(c.Grid.square(11), 5.5), wall=c.LennardJonesSpline(0.0))
    copper = a.EmbeddedAtom.read(a.find_potential("Cu_mishin1.eam.alloy"))
    deck = a.deck(contact, copper, separations=[0.4, -0.2, -0.6, 0.4], depth=6)
    deck = replace(deck, tolerance=1e-5)  # neighbours are counted
    run = a.run_deck(deck.write(tmp_path / "deck"))
    assert (run.yielded, run.unloaded, run.plastic) == (2, 3, False)
    assert [step.status for step in run.steps] == ["CONVERGED", "CONVERGED", "YIELDED", "CONVERGED"]
    assert [step.slipped > 0 for step in run.steps] == [False, False, True, False]
    # LAMMPS' common neighbours: a stacking fault under load, none before and after.
    assert [step.faulted > 0 for step in run.steps] == [False, False, True, False]
    # Surface and frozen base have too few neighbours for any structure; all between is fcc once more.
    assert run.last.structure is not None
    assert (run.last.structure[6:-1] == 1).all()
    assert run.slips[2].sum() == run.steps[2].slipped
    assert not run.converged
    text = run.sheets()[0].text()
    assert f"slipped in step 3: {run.steps[2].slipped} atoms have other nearest neighbours" in text
    assert f"{run.steps[2].faulted} stand in stacking faults (hcp)" in text
    assert f"before it the crystal held {run.steps[1].load:.4g} E*" in text
    assert "In step 4, unloaded, none has: it sprang back, and is not plastic." in text
    first = run.first_yield
    assert first is not None
    assert first.separation == pytest.approx((-0.4, 0.2))
    assert first.load[0] - first.load[1] == pytest.approx(run.steps[1].load)
    assert "First yield, half way between steps 2 and 3: separation -0.4 ± 0.2 a0" in text
    assert run.imprint is None  # the last step still bears a load
    elastic = replace(run, steps=run.steps[:2])
    assert f"No atom has slipped, up to N/A0 = {run.steps[1].load:.4g} E*" in elastic.sheets()[0].text()
    # Nothing is said of states that are none.
    lost = replace(run, steps=tuple(replace(step, status="FORCES_LEFT") for step in run.steps))
    for other in (lost, replace(elastic, description=replace(run.description, bonded=True))):
        assert "slipped," not in other.sheets()[0].text()
    figure = draw_slip(run)
    assert [len(line.get_xdata()) for line in figure.axes[1].lines][1:] == [
        run.steps[2].slipped - run.steps[2].faulted, run.steps[2].faulted,
    ]  # fmt: skip
    assert faults_in_print(figure) == []
    with pytest.raises(c.NotConvergedError, match="the crystal has slipped"):
        read_result(run.directory, 3).require()
    # Had some kept their new neighbours, under less load and without any; and without a step that is unloaded.
    for load, plastic, words in (
        (run.steps[3].load, None, f"7 still have at N/A0 = {run.steps[3].load:.4g} E*"),
        (0.0, True, "unloaded, 7 still have: it is plastic."),
    ):
        step = replace(run.steps[3], slipped=7, status="YIELDED", load=load)
        kept = replace(run, steps=(*run.steps[:3], step))
        assert kept.plastic is plastic
        assert f"In step 4, {words}" in kept.sheets()[0].text()
    under_load = replace(run, steps=run.steps[:3])
    assert under_load.plastic is None
    assert "Whether that is plastic is not known" in under_load.sheets()[0].text()
    # Less load further down is not unloaded: the crystal has given way.
    deeper = replace(run, steps=(*run.steps[:3], replace(run.steps[3], separation=-0.8)))
    assert deeper.unloaded is None
