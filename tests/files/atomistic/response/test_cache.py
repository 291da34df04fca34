"""Lattice responses on disk."""

import dataclasses

import numpy as np
import pytest

from atomistic.crystal.crystal import Slab
from atomistic.crystal.interatomic import LennardJones, Springs
from atomistic.crystal.potentials import EmbeddedAtom, find_potential
from atomistic.response import cache
from atomistic.response.lattice import LatticeResponse
from atomistic.response.material import model_of
from continuum.store import datasets as store

SLAB = Slab((6, 5), 5, 3)


@pytest.fixture(scope="module")
def model():
    return model_of(LennardJones())


def test_a_stored_response_is_the_measured_one(tmp_path, model, monkeypatch):
    first = cache.stored_response(SLAB, model, tmp_path / "new")
    monkeypatch.setattr(LatticeResponse, "of_model", None)  # not measured again
    again = cache.stored_response(SLAB, model, tmp_path / "new")
    assert (again.stiffness_q == first.stiffness_q).all()
    assert again.force_constants.checks == first.force_constants.checks
    force = np.random.default_rng(1).standard_normal(SLAB.shape)
    moved = again.displacements_of_surface_force(force)
    assert (moved == first.displacements_of_surface_force(force)).all()
    # The table is what the recursion gives, without asking the table.
    assert np.allclose(LatticeResponse(SLAB, again.force_constants).stiffness_q, again.stiffness_q, rtol=1e-14)
    file = store.read_datasets(cache.response_path(SLAB, model, tmp_path / "new"), cache.SCHEMA, cache.VERSION)
    assert file.attributes["model"] == model.reference
    assert "provenance/lammps" in file.attributes


def test_what_is_damaged_or_another_is_measured_anew(tmp_path, model):
    path = cache.response_path(SLAB, model, tmp_path)
    first = cache.stored_response(SLAB, model, tmp_path).stiffness_q
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    assert (cache.stored_response(SLAB, model, tmp_path).stiffness_q == first).all()
    assert path.read_bytes() != content[: len(content) // 2]
    path.write_bytes(content)
    other = Slab((5, 6), 5, 3)
    cache.response_path(other, model, tmp_path).write_bytes(content)
    assert cache.stored_response(other, model, tmp_path).stiffness_q.shape == other.grid.shape_q


def test_the_key_is_the_content(tmp_path, model):
    copy = tmp_path / "another.name"
    copy.write_bytes(find_potential("Ni_u3.eam").read_bytes())
    nickel = EmbeddedAtom.read(find_potential("Ni_u3.eam"))
    assert cache.response_key(SLAB, EmbeddedAtom.read(copy)) == cache.response_key(SLAB, nickel)
    changed = dataclasses.replace(nickel, content=nickel.content + b" ")
    keys = [
        cache.response_key(slab, of)
        for slab in (SLAB, Slab((5, 6), 5, 3), Slab((6, 5), 6, 3), Slab((6, 5), 5, 4))
        for of in (model, nickel, changed, LennardJones(2.6), Springs(1.0), Springs(1.1))
    ]
    assert len(set(keys)) == len(keys)


def test_the_folder_can_be_named(monkeypatch, tmp_path):
    monkeypatch.setenv("STICKINESS_CACHE", str(tmp_path / "here"))
    assert cache.default_folder() == tmp_path / "here"
    monkeypatch.delenv("STICKINESS_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache.default_folder() == tmp_path / "stickiness"
