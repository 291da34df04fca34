"""LAMMPS outside of any MPI world: what a launcher tells a process that is one of several, and how to leave it unheard.

A process of ``mpiexec -n 4 python script.py`` inherits variables by which MPI in it, or in an ``lmp`` that it starts,
joins the others and waits for them; another MPI than the launcher's ends the process.  Without these variables it is
alone (a singleton).  What chooses where and how programs run stays: the allocation of a queue, and settings of users.
"""

import os
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

_WORLD = re.compile(
    # MPICH's Hydra and those made from it; the plugins pmi2 and cray_shasta of SLURM; PALS and ALPS of Cray.
    r"PMI2?_\w+|HYDI_\w+|HYDRA_BSTRAP_\w+|MPI_LOCALN?RANK\w+|MPIR_RANK|PALS_\w+|ALPS_APP_\w+|MV2_COMM_\w+|MPISPAWN_\w+"
    # PMIx, of SLURM, Open MPI and PRRTE: not where it is installed, nor settings of its components.
    r"|PMIX_(?!MCA_|PREFIX|INSTALL_PREFIX)\w+|PRTE_LAUNCHED"
    # Open MPI: not OMPI_MCA_btl and other settings.
    r"|OMPI_(?:COMM_WORLD|WORLD|UNIVERSE|APP_CTX|NUM_APP|FIRST_RANKS|FILE_LOCATION|PARENT)\w*|OMPI_(?:ARGV|COMMAND)"
    r"|OMPI_MCA_(?:orte_\w+|ess\w*|pmix|initial_wdir|num_procs)|ORTE_SCHIZO_DETECTION"
    # SLURM's libpmi and Open MPI 4 take these for a world.  srun asks others, as SLURM_NTASKS.
    r"|SLURM_(?:STEP_?ID|STEP_NUM_TASKS|PROCID|NPROCS|GTIDS|PMI2_\w+|PMIX_MAPPING_SERV|PMIXP_\w+)"
    # jsrun, Flux and LSF.
    r"|JSM_\w+|FLUX_(?:JOB_ID|JOB_SIZE|JOB_NNODES|TASK_RANK|PMI_LIBRARY_PATH)|LSF_PM_\w+"
)


def alone(environment: Mapping[str, str]) -> dict[str, str]:
    """The variables of a process without those that make it one of an MPI world."""
    return {name: value for name, value in environment.items() if not _WORLD.fullmatch(name)}


@contextmanager
def outside_world() -> Iterator[None]:
    """Run what initialises MPI in this process without those variables, which are there again afterwards."""
    hidden = os.environ.keys() - alone(os.environ).keys()
    before = {name: os.environ.pop(name) for name in hidden}
    try:
        yield
    finally:
        os.environ |= before
