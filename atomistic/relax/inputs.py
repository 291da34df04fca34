"""Inputs of decks with units, which are converted to those of the crystal after measuring it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from atomistic.config.crystal import ElasticConfig
from atomistic.config.deck import DeckConfig
from atomistic.config.quantities import in_reduced, with_units
from atomistic.crystal.interatomic import Potential
from atomistic.response.material import model_of
from continuum.files.inputs import parsed
from continuum.files.toml import ConfigError, Source, find


def deck_input(path: str | Path) -> DeckConfig:
    """Read the input of a deck, and convert its units to reduced ones.

    Raises ConfigError with all faults of the file; PotentialError or LammpsError if a number has a unit, and the
    crystal is not a stable fcc one, or LAMMPS fails.
    """
    source = Source.read(find(path))
    if not with_units(source.data):
        return parsed(source, DeckConfig)
    try:
        potential = parsed(source, ElasticConfig).interatomic.potential()
    except ConfigError:
        return parsed(source, DeckConfig)  # which reports this fault together with the others
    values, faults = in_reduced(source.data, model_of(potential).real_units)
    try:
        return parsed(source, DeckConfig, values)
    except ConfigError as error:
        told = [fault.key for fault in faults]
        others = [fault for fault in error.faults if not any(fault.key[: len(key)] == key for key in told)]
        raise ConfigError(source, [*faults, *others]) from None


def steps_in_units(given: Mapping[str, Any], model: Potential) -> Mapping[str, Any]:
    """The separations, pressures or protocol of a call, with units converted to a0 and E*.

    Raises ConfigError, PotentialError or LammpsError as :func:`deck_input`.
    """
    if not with_units(given):
        return given
    values, faults = in_reduced(given, model_of(model).real_units)
    if faults:
        raise ConfigError(Source(Path("protocol"), "", given, {}), faults)
    return values
