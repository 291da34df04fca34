"""Measured lattice responses on disk, one file each.

The name of a file is a hash of the model, by the content of its potential, and of the slab.  It contains the table of
K_q, the force constants, the relaxation of the surface, and their provenance.
"""

import contextlib
import hashlib
import json
import os
from pathlib import Path

from atomistic.crystal.crystal import Slab
from atomistic.crystal.model import Model
from atomistic.response.force_constants import ForceConstants, SymmetryErrors
from atomistic.response.lattice import LatticeResponse
from continuum.inputs.errors import OutputError
from continuum.model import caches
from continuum.model.grid import Grid
from continuum.store import datasets as store
from continuum.store import output
from continuum.store.datasets import Dataset
from continuum.store.hdf5 import StoreError, understood
from continuum.store.provenance import journal, provenance

SCHEMA, VERSION = "stickiness/lattice-response", 1
"""The version is increased whenever the measurement or the layout changes."""


def default_folder() -> Path:
    """$STICKINESS_CACHE, or the user's folder of caches, or one for temporary files where there is no home.

    Where none of these can be written, it is one where nothing is found or stored.
    """
    return Path(os.environ.get("STICKINESS_CACHE") or caches.folder_for() or os.devnull)


def response_key(slab: Slab, model: Model) -> str:
    """Hash of all that determines a response: content of the potential, atoms, layers, version."""
    content = {
        "schema": SCHEMA,
        "version": VERSION,
        "model": dict(model.identity),
        "slab": {"shape": list(slab.shape), "mobile": slab.mobile, "frozen": slab.frozen},
    }
    return hashlib.sha256(json.dumps(content, sort_keys=True, allow_nan=False).encode()).hexdigest()


def response_path(slab: Slab, model: Model, folder: Path) -> Path:
    """The file of a response."""
    return Path(folder) / f"lattice-{response_key(slab, model)[:32]}.h5"


def stored_response(slab: Slab, model: Model, folder: Path) -> LatticeResponse:
    """The response of a slab: read from a folder if it is there, else measured and stored.

    Parameters
    ----------
    slab, model : the atoms.
    folder : folder of the files, made if needed; nothing is stored if that fails.

    Raises ValueError if forces reach further than the slab, or the crystal is not harmonic; LammpsError if LAMMPS
    fails.
    """
    key = response_key(slab, model)
    path = response_path(slab, model, folder)
    # A file that is missing, damaged or of another kind is measured anew.
    with contextlib.suppress(StoreError), understood(path):
        return _read(path, slab, key)
    response = LatticeResponse.of_model(slab, model)
    # If the folder cannot be written, the next run measures again.
    with contextlib.suppress(OutputError):
        output.folder(path.parent)
        output.remove_stale(path)
        _write(path, response, model, key)
    return response


def slab_response(model: Model, n: int) -> LatticeResponse:
    """The response of a slab of n x n surface atoms, n a0 deep, from the cache of this user or measured.

    Raises ValueError or LammpsError: see :func:`stored_response`.
    """
    return stored_response(Slab.of_depth(Grid.square(n), float(n), model.coupled_layers), model, default_folder())


def _write(path: Path, response: LatticeResponse, model: Model, key: str) -> None:
    constants, pair = response.force_constants, ("down", "place_x", "place_y", "component", "of_displacement")
    checks = {} if constants.checks is None else {f"checks/{name}": v for name, v in vars(constants.checks).items()}
    store.write(
        path,
        {
            "stiffness": Dataset(response.stiffness_q, ("qx", "qy"), "E*/a0", "K_q = 1/G_zz of the surface"),
            "surface": Dataset(constants.surface, ("layer", *pair), "E* a0", "force constants of the first layers"),
            "bulk": Dataset(constants.bulk, pair, "E* a0", "force constants of any other layer"),
            "relaxation": Dataset(constants.relaxation, ("layer",), "a0", "rise of a layer when the surface relaxes"),
        },
        {
            "schema": SCHEMA,
            "schema_version": VERSION,
            "key": key,
            "model": model.reference,
            "identity": json.dumps(dict(model.identity), sort_keys=True),
            "slab/nx": response.slab.shape[0],
            "slab/ny": response.slab.shape[1],
            "slab/mobile": response.slab.mobile,
            "slab/frozen": response.slab.frozen,
            **checks,
            **provenance(("numpy", "scipy", "h5py", "ase", "lammps", "mpich")),
            **journal(),
        },
    )


def _read(path: Path, slab: Slab, key: str) -> LatticeResponse:
    file = store.read_datasets(path, SCHEMA, VERSION)
    if file.attributes["key"] != key:
        raise StoreError(f"{path}: holds another response")
    names = [name for name in file.attributes if name.startswith("checks/")]
    checks = (
        SymmetryErrors(**{name.removeprefix("checks/"): float(file.attributes[name]) for name in names})
        if names
        else None
    )
    constants = ForceConstants(file["surface"], file["bulk"], file["relaxation"], checks)
    return LatticeResponse(slab, constants, file["stiffness"])
