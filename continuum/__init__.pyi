"""The public names, each with its module: for type checkers, and for ``__init__.py``, which imports them when asked."""

from continuum.front.certify import Certificate as Certificate
from continuum.front.certify import certify as certify
from continuum.front.contact import Contact as Contact
from continuum.front.contact import FoundThreshold as FoundThreshold
from continuum.front.contact import LoadingPath as LoadingPath
from continuum.front.contact import State as State
from continuum.front.doctor import doctor as doctor
from continuum.front.predict import Prediction as Prediction
from continuum.front.predict import Study as Study
from continuum.front.predict import predict as predict
from continuum.front.predict import study as study
from continuum.front.runs import analyse as analyse
from continuum.front.runs import check as check
from continuum.front.runs import plot as plot
from continuum.front.runs import run as run
from continuum.front.runs import threshold as threshold
from continuum.front.sweeps import sweep as sweep
from continuum.front.sweeps import sweep_collect as sweep_collect
from continuum.front.sweeps import sweep_slurm as sweep_slurm
from continuum.inputs.toml import ConfigError as ConfigError
from continuum.model.grid import Grid as Grid
from continuum.model.substrates import CubicLayer as CubicLayer
from continuum.model.substrates import HalfSpace as HalfSpace
from continuum.model.substrates import Layer as Layer
from continuum.model.substrates import LayeredHalfSpace as LayeredHalfSpace
from continuum.model.substrates import NonPeriodicHalfSpace as NonPeriodicHalfSpace
from continuum.model.substrates import TabulatedSubstrate as TabulatedSubstrate
from continuum.model.surface import SelfAffine as SelfAffine
from continuum.model.surface import moments as moments
from continuum.model.surfaces import sine as sine
from continuum.model.surfaces import sphere as sphere
from continuum.model.walls import Exponential as Exponential
from continuum.model.walls import HardWall as HardWall
from continuum.model.walls import InversePowers as InversePowers
from continuum.model.walls import LennardJonesSpline as LennardJonesSpline
from continuum.model.walls import TabulatedWall as TabulatedWall
from continuum.model.walls import attraction_on_core as attraction_on_core
from continuum.paper.examples import examples as examples
from continuum.paper.page import figure as figure
from continuum.path.gradient import noise_error as noise_error
from continuum.solve.solution import NotConvergedError as NotConvergedError
from continuum.solve.solution import NotConvergedWarning as NotConvergedWarning
from continuum.store.hdf5 import StoreError as StoreError
from continuum.store.runs.result import Analysis as Analysis
from continuum.store.runs.result import Result as Result
from continuum.store.sweeps.cluster import SweepTask as SweepTask
from continuum.store.sweeps.collect import sweep_verify as sweep_verify
from continuum.store.sweeps.cube import sweep_maps as sweep_maps
from continuum.store.sweeps.status import sweep_status as sweep_status

__all__: list[str]
__version__: str
