"""A wrong value of any key of an input is one message about that key, whatever the other keys are checked against."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from atomistic.inputs.crystal import ElasticConfig, Interatomic
from continuum.inputs.reading import parsed
from continuum.inputs.toml import ConfigError, Source

KINDS: dict[str, dict[str, Any]] = {
    "springs": {},
    "lennard-jones": {"cutoff": 2.5, "truncation": "mdf", "inner": 2.0},
    "eam": {"file": "Ni_u3.eam", "element": "Ni"},
    "pair-style": {
        "style": "adp", "element": "Cu", "mass": 63.5, "cutoff": 6.3, "lattice_constant": 3.6, "arguments": (),
        "coefficients": (("*", "*", "AlCu.adp", "Cu"),), "files": ("AlCu.adp",), "many_body": True,
    },
}  # fmt: skip
"""Tables [interatomic] with all of their keys."""
WRONG = ("?", -1.5, {}, (), True, ("a.eam", "b"), 1e300)


def faulty(table: Mapping[str, Any]) -> Iterator[tuple[str, Any, ConfigError]]:
    """Each key with each wrong value that is refused, and how."""
    for key in table:
        for value in WRONG:
            try:
                parsed(Source(Path("input"), "", {"interatomic": {**table, key: value}}), ElasticConfig)
            except ConfigError as error:
                yield key, value, error


def test_every_kind_and_every_key_is_tried() -> None:
    assert Interatomic.kinds.keys() == KINDS.keys()
    for kind, table in KINDS.items():
        assert {*table, "kind"} == {*Interatomic.kinds[kind].model_fields}


@pytest.mark.parametrize("kind", KINDS)
def test_a_wrong_value_is_one_message_that_names_its_key(kind: str) -> None:
    found = list(faulty(KINDS[kind] | {"kind": kind}))
    assert {key for key, *_ in found} == {*KINDS[kind], "kind"}
    for key, value, error in found:
        places = [".".join(map(str, fault.key)) for fault in error.faults]
        # Two elements have two masses: either key may be the wrong one.
        keys = (key, "mass") if key == "element" and value == ("a.eam", "b") else (key,)
        assert all(place.split(".")[1] in keys for place in places), (key, value, places)
