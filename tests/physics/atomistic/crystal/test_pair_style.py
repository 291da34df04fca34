"""Any pair_style in a whitelisted form: what hostile input cannot do, and one potential of LAMMPS end to end."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given as drawn
from hypothesis import strategies as st

import atomistic as a
import continuum as c
from atomistic.crystal.model import Potential
from atomistic.crystal.potentials import EmbeddedAtom, PairStyle, PotentialError, find_potential
from atomistic.inputs.crystal import ElasticConfig
from atomistic.lammps.deck import Deck, render
from atomistic.lammps.result import DeckStatus
from atomistic.lammps.session import Cell
from atomistic.response.material import model_of
from continuum.inputs.arguments import ArgumentError
from continuum.inputs.reading import load

TEXT = st.text(max_size=30) | st.sampled_from(
    [
        "a\nshell rm x",
        "${v}",
        "$(1)",
        "a b",
        "a;b",
        "&",
        '"',
        "'",
        "#",
        "../x",
        "/etc/passwd",
        "a\\",
        "python",
        "*",
        "1e5",
    ]
)


@drawn(style=TEXT, element=TEXT, words=st.lists(TEXT, max_size=4), name=TEXT, content=st.binary(max_size=20))
def test_no_text_of_a_user_becomes_a_command(style, element, words, name, content):
    said: list[str] = []
    for kind, symbol in ((style, "Cu"), ("adp", element), ("adp", "Cu")):
        try:
            potential = PairStyle(kind, symbol, 63.5, 5.0, 3.6, tuple(words), (("*", *words, name),), {name: content})
        except ArgumentError as error:
            said.append(str(error))
            continue
        lines = potential.interactions().splitlines()
        assert len(lines) == 2
        for line, command in zip(lines, ("pair_style", "pair_coeff"), strict=True):
            # One command of words and nothing that LAMMPS expands, joins or ends.
            assert re.fullmatch(rf"{command} +[A-Za-z0-9_.+*/= -]+", line)
            assert ".." not in line or "/" not in line
        assert not set(lines[0].split()[1:]) & {"python"} or kind != "python"
        assert all(map(str.isprintable, said))
        assert all(re.fullmatch(r"potential\.\d+", file) for file in potential.files)


PLAIN = Deck(a.Slab((4, 4), mobile=2), a.Springs(), c.LennardJonesSpline(0.1), np.zeros((4, 4)), 1.2)


@drawn(note=st.text(max_size=200))
def test_notes_and_comments_reach_no_script(note):
    texts, expected = render(replace(PLAIN, notes=(note,))), render(PLAIN)
    assert {name for name in texts if texts[name] != expected[name]} <= {"README.txt"}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"style": "python"}, "style = "),
        ({"style": "hybrid/scaled"}, "style = .*hybrid/overlay adds several"),
        ({"style": "hybrid/overlay", "arguments": ("adp", "python", "2")}, "arguments = .*python is not"),
        ({"style": "hybrid/overlay", "coefficients": (("*", "*", "../a/b"),)}, "coefficients = .*under files"),
        ({"style": "adp", "coefficients": (("*", "*", "eam/alloy"),)}, "coefficients = .*under files"),
        ({"coefficients": (("*", "*", "/etc/passwd"),)}, "coefficients = .* under files"),
        ({"style": "mliap", "arguments": ("unified", "a.pkl", "0"), "contents": {"a.pkl": b""}}, "unified is Python's"),
        (
            {"style": "mliap/kk", "arguments": ("model", "mliappy", "a", "descriptor", "sna", "b")},
            "mliappy is Python's",
        ),
        ({"style": "hybrid/overlay", "arguments": ("mliap", "unified", "a", "zbl", "1", "2")}, "unified is Python's"),
        ({"contents": {"model": b"\x80\x04\x95"}}, "contents = 'model'.*a pickle runs code"),
        ({"coefficients": ()}, "coefficients = "),
        ({"coefficients": (("*", "*", "Al"),)}, "coefficients = .* the elements of the input, Cu: it has Al in place"),
        ({"coefficients": (("*", "*", "Cu", "Ni"),), "others": (("Al", 27.0),)}, "Ni in place of Al"),
        ({"mass": 6.3546}, "mass = 6.3546: allowed: .*as Cu has 63.55 u"),
        ({"element": "H", "mass": 12.0}, "mass = 12.0: allowed: .*as H has 1.008 u"),
        ({"lattice_constant": 0.36}, "lattice_constant = 0.36: .*no solid has this"),
        ({"element": "Cu; clear"}, "element = .* chemical symbol"),
        ({"cutoff": float("nan")}, "cutoff = nan"),
        ({"mass": -1.0}, "mass = -1.0"),
    ],
)
def test_what_is_no_pair_style_is_refused(changes, message):
    with pytest.raises(ArgumentError, match=message):
        PairStyle(**({"style": "adp", "element": "Cu", "mass": 63.5, "cutoff": 5.0, "lattice_constant": 3.6} | changes))


def test_a_style_that_lammps_does_not_have_is_named():
    with pytest.raises(PotentialError, match=r"no pair_style 'adb'; did you mean adp"):
        model_of(PairStyle("adb", "Cu", 63.5, 5.0, 3.6))
    with pytest.raises(PotentialError, match=r"no pair_style 'eam/aloy'; did you mean eam/alloy"):
        model_of(PairStyle("hybrid/overlay", "Cu", 63.5, 5.0, 3.6, ("eam/aloy",), (("*", "*", "eam/aloy", "Cu"),)))


@pytest.mark.parametrize(
    ("style", "words", "file", "why"),
    [("comb", (), "ffield.comb", "no charges here"), ("reaxff", ("NULL",), "ffield.reax.cho", "units `metal`")],
)
def test_a_potential_that_is_none_for_a_deck_is_refused_with_the_reason(style, words, file, why) -> None:
    element = "C" if style == "reaxff" else "Cu"
    table = {"style": style, "element": element, "mass": 12.011 if element == "C" else 63.5}
    with pytest.raises(PotentialError, match=why):
        model_of(given(**table, arguments=words, files=(file,), coefficients=(("*", "*", file, element),)))


def test_what_lammps_refuses_names_the_files_of_the_user_and_is_an_error_of_the_input() -> None:
    """Not potential.1, our name of it, nor a remedy for a LAMMPS that is well."""
    with pytest.raises(PotentialError) as caught:
        model_of(given(style="hybrid/overlay", arguments=("meam", "zbl", "1", "2"), files=("library.meam",),
                       coefficients=(("*", "*", "library.meam", "Cu", "NULL", "Cu"),)))  # fmt: skip
    message = str(caught.value)
    assert "Expected hybrid sub-style instead of library.meam" in message
    assert "* * library.meam Cu NULL Cu" in message
    assert "doctor" not in message
    assert "potential.1" not in message


CELL = np.array([[0.0, 0, 0], [1.8, 1.8, 0.2]]), np.full(3, 3.6)


def energy(potential: Potential) -> float:
    with Cell(potential, *CELL) as cell:
        return cell.evaluate(CELL[0])[0]


def given(**keys: object) -> PairStyle:
    """The potential of a table of an input."""
    table = {"kind": "pair-style", "element": "Cu", "mass": 63.5, "cutoff": 5.6, "lattice_constant": 3.6} | keys
    found = load({"interatomic": table}, ElasticConfig).interatomic.potential()
    assert isinstance(found, PairStyle)
    return found


def test_every_file_that_a_command_names_travels_with_the_deck(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Files of a pair_style mliap stand among its arguments; no list names them, and one is in another folder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own").mkdir()
    (tmp_path / "Cu").write_text("a file of the name of the element is not meant")
    model = (tmp_path / "own/any.model").write_bytes(find_potential("Cu.nn.mliap.model").read_bytes())
    words = ("model", "nn", "own/any.model", "descriptor", "sna", "Cu.snap.mliap.descriptor")
    found = given(style="mliap", arguments=words, coefficients=(("*", "*", "Cu"),))
    assert sorted(map(len, found.files.values()))[-1] == model
    assert found.interactions().splitlines() == [
        "pair_style      mliap model nn potential.2 descriptor sna potential.1",
        "pair_coeff      * * Cu",
    ]
    assert energy(found) < 0


def test_styles_that_are_added_up_are_those_alone() -> None:
    name = "Cu_mishin1.eam.alloy"
    words = (("*", "*", "eam/alloy", name, "Cu"), ("1", "1", "lj/cut", "0.1", "2.3"))
    both = given(style="hybrid/overlay", arguments=("eam/alloy", "lj/cut", "5.0"), coefficients=words)
    pairs = given(style="lj/cut", arguments=("5.0",), coefficients=(("*", "*", "0.1", "2.3"),))
    alone = EmbeddedAtom.read(find_potential(name))
    assert energy(both) == pytest.approx(energy(alone) + energy(pairs), rel=1e-12)
    assert abs(energy(pairs)) > 0.1


def test_a_potential_of_another_style_runs_end_to_end(tmp_path: Path):
    # Angular-dependent potential of Apostol and Mishin, PRB 83, 054116 (2011): a = 3.615 Å and C11, C12, C44 of
    # 170, 123, 76 GPa are those of copper that it was fitted to.
    path = find_potential("AlCu.adp")
    copper = PairStyle(
        "adp", "Cu", 63.546, 6.3, 3.6, coefficients=(("*", "*", path.name, "Cu"),),
        contents=PairStyle.read_files((path,)),
    )  # fmt: skip
    model = model_of(copper)
    assert model.length * np.sqrt(2) == pytest.approx(3.615, abs=0.005)
    c11, c12, c44 = (constant * model.energy / model.length**3 * 160.2177 for constant in model.elastic_constants)
    assert (c11, c12, c44) == (pytest.approx(170, rel=0.03), pytest.approx(123, rel=0.03), pytest.approx(76, rel=0.03))
    heights = c.sphere(c.Grid.square(10), 60.0)
    with pytest.warns(UserWarning, match="fewer than 4 points"):  # the edge of the sphere's period
        contact = c.Contact(heights, c.LennardJonesSpline(adhesion_length=0.005))
    deck = replace(a.deck(contact, copper, separation=0.95, depth=4), tolerance=1e-6)
    run = a.run_deck(deck.write(tmp_path / "deck"))
    assert run.converged, DeckStatus[run.steps[-1].status].value
    assert run.last.area_rep > 0.02
    assert run.description.element == "Cu"
