"""Numbers of a deck that no crystal stands: bounded by physics, told in real units, before anything is written."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.constants import atomic_mass, k

import atomistic as a
import continuum as c
from atomistic.front.cli import main
from atomistic.inputs.deck import DeckConfig
from atomistic.inputs.motion import FASTEST, HOTTEST
from atomistic.relax.limits import FARTHEST
from atomistic.response.material import model_of
from continuum.inputs.errors import InputError
from continuum.inputs.reading import parsed
from continuum.inputs.tables import table_of
from continuum.inputs.toml import Source, find
from continuum.model.surface import Surface
from continuum.model.walls import Wall
from tests import kinds

COPPER = 'kind = "eam"\nfile = "Cu_mishin1.eam.alloy"'
SPRINGS = 'kind = "springs"'


def deck(tmp_path: Path, what: str, crystal: str = SPRINGS) -> Path:
    """An input whose protocol, or separation, is given."""
    top, protocol = ("", what) if what.startswith("[") else (what, "")
    path = tmp_path / "deck.toml"
    path.write_text(
        f'{top}\n[interatomic]\n{crystal}\n[slab]\nn = 12\ndepth = 6.0\n[surface]\nkind = "sphere"\nradius = 40.0\n'
        f'[wall]\nlaw = "lennard-jones-spline"\nadhesion_length = 0.02\n{protocol}\n'
    )
    return path


def moving(**changes: object) -> str:
    keys: dict[str, object] = {
        "temperature": 1e-4,
        "separations": [1.6, 1.1],
        "velocity": 0.01,
        "window": 10.0,
    } | changes
    return "\n".join(['[protocol]\nkind = "velocity"', *(f"{name} = {value}" for name, value in keys.items())])


@pytest.mark.parametrize(
    ("what", "crystal", "words"),
    [
        (moving(temperature=50), SPRINGS, ["protocol.temperature = 50", "at most 0.015 E* a0³", "kelvin where k_B T"]),
        (moving(temperature=1e300), SPRINGS, ["protocol.temperature = 1e+300", "at most 0.015 E* a0³"]),
        (moving(temperature=300), COPPER, ["temperature = 300", "(2453 K)", "300 E* a0³ are 4.91e+07 K", '"300K"']),
        (moving(temperature='"5000K"'), COPPER, ['temperature = "5000K"', "(2453 K)"]),
        (moving(temperature='"1e5C"'), COPPER, ['temperature = "1e5C"', 'not a unit of temperature']),
        (moving(velocity=1e9), SPRINGS, ["velocity = 1000000000.0", "at most 0.3 (E* a0³/m)^(1/2)", "shear"]),
        (moving(velocity=20.0), COPPER, ["velocity = 20.0", "(1388 m/s)", "9.25e+04 m/s", "1 m/s is 0.000216"]),
        (moving(temperature=50, velocity=20.0), COPPER, ["temperature = 50", "velocity = 20.0"]),
        (moving(window=1e300), SPRINGS, ["window = 1e+300"]),
        (moving(window=1e-300), SPRINGS, ["window = 1e-300"]),
        (moving(separations=[1.1], window=1e-300), SPRINGS, ["window = 1e-300"]),
        (moving(separations=[1.2, 1.2 + 1e-9]), SPRINGS, ["separations = ", "shortest window"]),
        (moving(damping=1e300), SPRINGS, ["damping = 1e+300"]),
        (moving(damping=1e-300), SPRINGS, ["damping = 1e-300"]),
        (moving(thermostat_layers=10000), SPRINGS, ["thermostat_layers = 10000", "fewer than the layers that move, 8"]),
        (moving(separations=[1e300, 1.2], window=1e6), SPRINGS, ["separations"]),
        ("separation = 1e300", SPRINGS, ["separation = 1e+300", "100 a0 above"]),
        ("separation = -1e9", SPRINGS, ["separation = -1000000000.0", "frozen base"]),
        ('[protocol]\nkind = "separations"\nseparations = [1.2, 1e9]', SPRINGS, ["separations = [1.2, 1", "100 a0"]),
        ('[protocol]\nkind = "mean-pressures"\npressures = [0.01, 3.0]', SPRINGS, ["pressures = [0.01", "-1 to 1"]),
    ],
)  # fmt: skip
def test_no_deck_is_written_of_what_no_crystal_stands(tmp_path, capsys, what, crystal, words):
    path = deck(tmp_path, what, crystal)
    for command in (["check", str(path)], ["deck", str(path), "-o", str(tmp_path / "deck")]):
        assert main(command) == 2
        said = capsys.readouterr().err
        for word in (f"{path}:", *words):
            assert word in said
        assert "Traceback" not in said
    assert not (tmp_path / "deck").exists()


CONTACT = c.Contact(c.sine(c.Grid.square(8), 0.05, (1, 0)), c.LennardJonesSpline(adhesion_length=0.005))
MOTION = {"kind": "velocity", "separations": [1.2, 1.1], "velocity": 0.01, "temperature": 1e-4, "window": 10.0}


@pytest.mark.parametrize(
    ("given_", "words"),
    [
        ({"protocol": MOTION | {"temperature": 50}}, "temperature = 50"),
        ({"protocol": MOTION | {"velocity": 1e9}}, "velocity = 1000000000.0"),
        ({"protocol": MOTION | {"thermostat_layers": 10000}}, "thermostat_layers = 10000"),
        ({"separation": 1e300}, r"separation = 1e\+300"),
        ({"separations": [1.2, -1e9]}, r"separations = \[1\.2, -1000000000\.0\]"),
        ({"pressures": [0.01, 3.0]}, r"pressures\[1\] = 3\.0"),
        ({"pressures": [0.01, 0.0]}, r"pressures = \[0\.01, 0\.0\]: allowed: other than zero"),
        ({"separation": 1.2, "depth": 1e300}, r"depth = 1e\+300"),
    ],
)
def test_what_no_crystal_stands_is_refused_from_python_too(given_, words):
    with pytest.raises(InputError, match=words):
        a.deck(CONTACT, **({"depth": 4} | given_))


def test_what_a_deck_of_a_file_does_not_take_is_named(tmp_path):
    path = deck(tmp_path, "separation = 1.2")
    with pytest.raises(TypeError, match=r"deck\.toml.*leave out model, separation, pressures and depth"):
        a.deck(path, a.Springs(), separation=9, pressures=[0.1], depth=3)
    with pytest.raises(TypeError, match="leave out follows"):
        a.deck(str(path), follows="site")
    assert a.deck(path).separation == 1.2


# Melting points in K, of any table; potentials miss them by some tenths.
MELTING = {
    "Cu_mishin1.eam.alloy": 1358, "Al_zhou.eam.alloy": 933, "Ni_u3.eam": 1728, "Ag_u3.eam": 1235, "Au_u3.eam": 1337,
    "Pd_u3.eam": 1828, "Pt_u3.eam": 2041,
}  # fmt: skip


@pytest.mark.parametrize("name", MELTING)
def test_the_bounds_lie_where_crystals_melt_and_where_their_sound_ends(name):
    model = model_of(a.EmbeddedAtom.read(a.find_potential(name)))
    real = model.real_units
    assert 0.005 < MELTING[name] / real.si("temperature") < 0.0115 < HOTTEST < 0.02
    c11, c12, c44 = model.elastic_constants
    density = np.sqrt(2)  # atoms per a0³
    slowest = np.sqrt(min(c44, (c11 - c12) / 2) / density)
    assert 0.29 < slowest < 0.47
    assert slowest > FASTEST / 1.05
    # In SI units, from the constants as they are measured.
    si = np.sqrt(
        min(c44, (c11 - c12) / 2) * real.contact_modulus / (np.sqrt(2) * model.mass * atomic_mass / real.a0**3)
    )
    assert slowest * real.si("velocity") == pytest.approx(si, rel=1e-9)
    assert real.si("temperature") == pytest.approx(real.contact_modulus * real.a0**3 / k, rel=1e-9)


def test_lennard_jones_melts_below_the_bound_too():
    assert 0.005 < 0.694 / model_of(a.LennardJones()).energy < HOTTEST  # the triple point, k_B T = 0.694 ε


def test_a_wall_is_far_where_no_law_is_felt():
    assert c.InversePowers((9, 3), adhesion_length=0.375).evaluate(np.array([FARTHEST])).traction[0] > -1e-7


class Accepted(Exception):
    """What the solving of a deck is replaced by."""


INPUTS = [Source.read(path).data for path in sorted(find("inputs/lammps/rough.toml").parent.glob("*.toml"))]
"""There is one of each crystal and of each protocol: see tests/physics/atomistic/ladder/test_cost.py."""
CRYSTALS = {tables["interatomic"]["kind"]: tables["interatomic"] for tables in INPUTS if "crystal" not in tables}
PROTOCOLS = [tables["protocol"] for tables in INPUTS if "protocol" in tables]
NUMBERS = st.one_of(
    st.floats(), st.integers(), st.integers(-3, 3), st.lists(st.floats(), max_size=3), st.booleans(),
    st.text(max_size=4), st.sampled_from([1e300, -1e300, 1e-300, 1e9, -1e9, 10**400, 0, -0.0]),
    st.sampled_from(["1e9K", "-3K", "K", "1e-3K"]),
)  # fmt: skip


def places(tables: Mapping[str, Mapping[str, Any]]) -> list[tuple[str, str]]:
    """Tables and their keys, also those that the input leaves at their defaults, but for kinds and files."""
    found = []
    for name, table in tables.items():
        kind = table_of(DeckConfig.model_fields[name], table)
        assert kind is not None
        found += [(name, key) for key in kind.model_fields if key not in ("kind", "law", "file", "files")]
    return found


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.sampled_from(sorted(CRYSTALS)), st.sampled_from(list(kinds.tables(Surface).values())),
    st.sampled_from(list(kinds.tables(Wall).values())), st.sampled_from(PROTOCOLS), st.integers(0, 99), NUMBERS,
)  # fmt: skip
def test_any_number_in_an_input_gives_a_deck_or_one_message(
    monkeypatch, crystal, surface, wall, protocol, which, number
):
    """What is sound is not solved."""

    def accept(*_: object) -> None:
        raise Accepted

    monkeypatch.setattr("atomistic.relax.decks.Specimen.of_slab", accept)
    tables: dict[str, dict[str, Any]] = {
        "interatomic": dict(CRYSTALS[crystal]), "slab": {"n": 12, "depth": 6.0}, "surface": dict(surface),
        "wall": dict(wall), "protocol": dict(protocol), "solver": {"tolerance": 1e-9, "force_tolerance": 1e-8},
    }  # fmt: skip
    table, key = (found := places(tables))[which % len(found)]
    tables[table][key] = number
    with contextlib.suppress(Accepted, InputError):
        a.deck(parsed(Source(Path("deck.toml"), "", {"follows": "atom", **tables}), DeckConfig))
