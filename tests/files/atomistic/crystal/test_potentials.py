"""Potential files: what is told by their content, and one clear message for whatever is wrong."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from atomistic.crystal.potentials import EmbeddedAtom, PotentialError, find_potential
from atomistic.lammps.session import Cell
from continuum.inputs.arguments import ArgumentError


@pytest.mark.parametrize(
    ("name", "element", "style", "mass", "cutoff", "volume"),
    [
        ("Cu_mishin1.eam.alloy", None, "eam/alloy", 63.55, 5.50679, 3.615**3 / 4),
        ("Ni_u3.eam", None, "eam", 58.71, 4.8, 3.52**3 / 4),
        ("CuNi.eam.alloy", "Ni", "eam/alloy", 58.689, 6.394332378, 3.52**3 / 4),
        ("AlFe_mm.eam.fs", "Fe", "eam/fs", 55.845, 6.5, None),
    ],
)
def test_what_a_file_of_lammps_says(name, element, style, mass, cutoff, volume):
    found = EmbeddedAtom.read(find_potential(name), element)
    assert (found.style, found.mass) == (style, mass)
    assert found.cutoff == pytest.approx(cutoff, rel=1e-12)
    assert found.force_range == 2 * found.cutoff
    if volume is not None:
        assert found.guess == pytest.approx(volume, rel=1e-12)
    assert name in found.reference
    assert name not in found.interactions()


def test_only_our_names_enter_a_script(tmp_path):
    # A folder and a file whose names would end a string, start a comment or run a command of LAMMPS.
    folder = tmp_path / 'a "b" $(c) & #'
    folder.mkdir()
    path = folder / "Ni'\nshell touch broken\n.eam"
    path.write_bytes(find_potential("Ni_u3.eam").read_bytes())
    mine = EmbeddedAtom.read(path)
    assert mine.identity == EmbeddedAtom.read(find_potential("Ni_u3.eam")).identity
    assert mine.interactions() == "pair_style      eam\npair_coeff      1 1 potential.eam"
    with Cell(mine, np.array([[0, 0, 0], [1.245, 1.245, 1.76]]), np.array([2.49, 2.49, 3.52])) as cell:
        energy, _ = cell.evaluate(np.array([[0, 0, 0], [1.245, 1.245, 1.76]]))
    assert energy / 2 == pytest.approx(-4.45, abs=1e-3)  # the sublimation energy it was fitted to


def test_a_file_is_found_by_path_before_those_of_lammps(tmp_path):
    own = tmp_path / "Ni_u3.eam"
    own.write_text("mine")
    assert find_potential("Ni_u3.eam", tmp_path) == own
    assert find_potential("Ni_u3.eam").parent.name == "potentials"


def test_a_missing_file_names_the_one_probably_meant():
    with pytest.raises(PotentialError, match=r"no potential file 'Cu_mishin\.eam\.alloy'.*did you mean Cu_mishin1"):
        find_potential("Cu_mishin.eam.alloy")
    with pytest.raises(PotentialError, match="no potential file"):
        find_potential("../Ni_u3.eam")
    for name in ("\0", "x" * 5000):
        with pytest.raises(ArgumentError, match="name = "):
            find_potential(name)


@pytest.mark.parametrize(
    ("name", "element"), [("Cu_mishin1.eam.alloy", "Cu"), ("Ni_u3.eam", None), ("AlFe_mm.eam.fs", "Al")]
)
def test_a_file_is_read_as_lammps_reads_it(tmp_path, name, element):
    """With numbers too many and with comments, which change nothing; and refused where it is cut short."""
    plain = EmbeddedAtom.read(find_potential(name), element)
    lines = find_potential(name).read_text().rstrip().splitlines()
    grid = 2 if name == "Ni_u3.eam" else 4
    lines[grid] += "  # nrho, drho, nr, dr, cutoff"
    lines[grid + 3 : grid + 3] = ["# a line between numbers", ""]
    at = np.array([[0.0, 0, 0], [2, 2, 0.1]])

    def energy(potential: EmbeddedAtom) -> float:
        with Cell(potential, at, np.full(3, 4.0)) as cell:
            return cell.evaluate(at)[0]

    path = tmp_path / "own"
    for end in ("\n0.0", " 0.0   # the end\n"):
        path.write_text("\n".join(lines) + end)
        own = EmbeddedAtom.read(path, element)
        assert (own.style, own.element, own.mass, own.cutoff) == (plain.style, plain.element, plain.mass, plain.cutoff)
        assert energy(own) == energy(plain) != 0
    # Lines end as on old Macs or on Windows; a form feed or a separator of Unicode ends none.
    for end in ("\r", "\r\n"):
        path.write_bytes(end.join(["\f\x85 " + lines[0], *lines[1:]]).encode())
        own = EmbeddedAtom.read(path, element)
        assert (own.style, own.mass, own.cutoff) == (plain.style, plain.mass, plain.cutoff)
        assert energy(own) == energy(plain)
    path.write_text("\n".join(lines[:-1]))
    with pytest.raises(PotentialError, match=r"asks for \d+ numbers and it holds"):
        EmbeddedAtom.read(path, element)


@pytest.mark.parametrize("name", ["Cu.meam", "SiC.tersoff", "FeCr.cdeam", "PdHHe.eam.he", "README"])
def test_a_file_of_another_kind_is_refused(name):
    with pytest.raises(PotentialError, match="not a potential of pair_style eam, eam/alloy or eam/fs"):
        EmbeddedAtom.read(find_potential(name))


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        (b" 5.50678999999", b" -5.5067899999", "makes no sense"),
        (b"1 Cu\n", b"2 Cu\n", "announces 2 elements and names 1"),
        (b"10001 0.00016", b"10002 0.00016", "asks for 30004 numbers and it holds"),
        (b"63.5499", b"-3.5499", "mass"),
        (b"UNITS: metal", b"UNITS: real ", "units are not metal"),
    ],
)
def test_an_edited_header_is_refused(tmp_path, old, new, match):
    content = find_potential("Cu_mishin1.eam.alloy").read_bytes()
    assert old in content
    (tmp_path / "bad").write_bytes(content.replace(old, new, 1))
    with pytest.raises(PotentialError, match=match):
        EmbeddedAtom.read(tmp_path / "bad")


def test_numbers_that_are_none_and_files_cut_short_are_refused(tmp_path):
    content = find_potential("Ni_u3.eam").read_bytes()
    lines = content.splitlines()
    (tmp_path / "bad").write_bytes(
        b"\n".join([*lines[:10], lines[10].replace(lines[10].split()[0], b"nan"), *lines[11:]])
    )
    with pytest.raises(PotentialError, match="1 of its numbers are not finite"):
        EmbeddedAtom.read(tmp_path / "bad")
    (tmp_path / "short").write_bytes(content[: len(content) // 2])
    with pytest.raises(PotentialError, match="asks for 1500 numbers and it holds"):
        EmbeddedAtom.read(tmp_path / "short")
    (tmp_path / "empty").write_bytes(b"")
    with pytest.raises(PotentialError, match="cannot be read"):
        EmbeddedAtom.read(tmp_path / "empty")
    with pytest.raises(PotentialError, match="cannot be read"):
        EmbeddedAtom.read(tmp_path)


def test_an_element_that_is_not_there_is_refused():
    path = find_potential("CuNi.eam.alloy")
    with pytest.raises(PotentialError, match="holds the elements Ni, Cu: the element 'Al' is not among them"):
        EmbeddedAtom.read(path, "Al")
    with pytest.raises(PotentialError, match="no element was named"):
        EmbeddedAtom.read(path)


@given(st.binary(max_size=300) | st.text("0123456789 \n.eEdD+-CuFC#", max_size=300).map(str.encode))
def test_any_bytes_are_a_potential_or_refused(tmp_path_factory, content):
    path = tmp_path_factory.mktemp("fuzz") / "potential"
    path.write_bytes(content)
    with pytest.raises(PotentialError, match=r"is not a potential|holds the elements"):
        EmbeddedAtom.read(path)


@pytest.mark.parametrize(
    "changes",
    [
        {"element": "Cu\nshell rm x"},
        {"element": "${v}"},
        {"style": "eam\nclear"},
        {"name": "a\nb"},
        {"mass": float("nan")},
    ],
)
def test_no_text_given_by_hand_becomes_a_command(changes):
    copper = {
        "style": "eam/alloy", "element": "Cu", "mass": 63.5, "cutoff": 5.5, "guess": 11.8, "comment": "", "name": "Cu",
        "content": b"",
    }  # fmt: skip
    assert EmbeddedAtom(**copper).interactions().splitlines()[1] == "pair_coeff      * * potential.eam Cu"
    with pytest.raises(ArgumentError, match=f"{next(iter(changes))} = "):
        EmbeddedAtom(**(copper | changes))
