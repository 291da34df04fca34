"""LAMMPS runs alone in a process that a launcher of MPI started: none of them waits for the others."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from atomistic.crystal.crystal import Slab
from atomistic.crystal.interatomic import Springs
from atomistic.lammps import engine
from atomistic.lammps.deck import Deck, write_deck
from atomistic.lammps.engine import alone, outside_world, script
from atomistic.lammps.result import LammpsError
from continuum.model.walls import LennardJonesSpline

ROOT = Path(__file__).parents[4]
TOLD = {
    # What `env` printed under each launcher, but for SLURM: there its sources say what they set.
    "MPICH": "HYDI_CONTROL_FD MPI_LOCALNRANKS MPI_LOCALRANKID PMI_FD PMI_HOSTNAME PMI_RANK PMI_SIZE PMI_PORT PMI_ID",
    "Intel MPI": "HYDRA_BSTRAP_UPSTREAM_FD MPI_LOCALNRANKS MPI_LOCALRANKID PMI_FD PMI_RANK PMI_SIZE",
    "Open MPI 4": "OMPI_APP_CTX_NUM_PROCS OMPI_COMM_WORLD_RANK OMPI_COMM_WORLD_SIZE OMPI_COMM_WORLD_LOCAL_RANK "
    "OMPI_FILE_LOCATION OMPI_FIRST_RANKS OMPI_MCA_ess OMPI_MCA_ess_base_jobid OMPI_MCA_ess_base_vpid "
    "OMPI_MCA_orte_ess_num_procs OMPI_MCA_orte_hnp_uri OMPI_MCA_orte_local_daemon_uri OMPI_MCA_pmix OMPI_NUM_APP_CTX "
    "OMPI_UNIVERSE_SIZE PMIX_ID PMIX_NAMESPACE PMIX_RANK PMIX_SERVER_URI2 PMIX_SERVER_URI21 PMIX_DSTORE_21_BASE_PATH "
    "PMIX_GDS_MODULE PMIX_PTL_MODULE PMIX_SECURITY_MODE PMIX_VERSION",
    "Open MPI 5": "OMPI_COMM_WORLD_RANK OMPI_WORLD_SIZE OMPI_WORLD_LOCAL_SIZE OMPI_UNIVERSE_SIZE OMPI_MCA_num_procs "
    "PMIX_NAMESPACE PMIX_RANK PMIX_SERVER_URI4 PMIX_SERVER_URI41 PMIX_VERSION PMIX_HOSTNAME PRTE_LAUNCHED",
    "SLURM, PMI1": "SLURM_STEPID SLURM_STEP_ID SLURM_STEP_NUM_TASKS SLURM_PROCID SLURM_NPROCS SLURM_GTIDS",
    "SLURM, PMI2": "PMI_FD PMI_JOBID PMI_RANK PMI_SIZE PMI_SPAWNED SLURM_PMI2_SRUN_PORT SLURM_PMI2_STEP_NODES",
    "SLURM, PMIx": "PMIX_NAMESPACE PMIX_RANK PMIX_SERVER_TMPDIR SLURM_PMIX_MAPPING_SERV SLURM_PMIXP_ABORT_AGENT_PORT",
    "SLURM, Cray": "PALS_APID PALS_RANKID PALS_NODEID PMI_CONTROL_PORT PMI_SHARED_SECRET PMI_LOCAL_RANK",
    "jsrun": "JSM_JSRUN_PORT JSM_NAMESPACE_RANK",
    "Flux": "FLUX_JOB_ID FLUX_JOB_SIZE FLUX_TASK_RANK PMI_FD PMI_RANK",
}
KEPT = (
    "PATH HOME OMP_NUM_THREADS OPAL_PREFIX PMIX_PREFIX PMIX_INSTALL_PREFIX PMIX_MCA_gds OMPI_MCA_btl OMPI_MCA_plm "
    "OMPI_ALLOW_RUN_AS_ROOT PRTE_MCA_rmaps_ppr I_MPI_FABRICS MPICH_ASYNC_PROGRESS MPIR_CVAR_CH4_NETMOD "
    "HYDRA_LAUNCHER MPIEXEC_TIMEOUT SLURM_JOB_ID SLURM_JOBID SLURM_NTASKS SLURM_JOB_NODELIST SLURM_NODELIST "
    "SLURM_CPUS_PER_TASK SLURM_TASKS_PER_NODE SLURM_MPI_TYPE FLUX_URI PBS_NODEFILE LSB_HOSTS CUDA_VISIBLE_DEVICES"
)
"""Where things are installed, settings of users, and allocations: `srun lmp` and `mpiexec -n 4 lmp` need these."""


def test_the_world_is_left_out_and_nothing_else() -> None:
    world = {name: "1" for names in TOLD.values() for name in names.split()}
    kept = dict.fromkeys(KEPT.split(), "1")
    assert alone(world | kept) == kept


def test_the_variables_are_there_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PMI_RANK", "1")
    before = dict(os.environ)
    with outside_world():
        assert dict(os.environ) == alone(before)
    assert dict(os.environ) == before


RUN = """
import os
from pathlib import Path

if os.environ["PMI_RANK"] == "0":
    # Other launchers as well: with these, MPI would end the process.
    os.environ |= {"PMIX_NAMESPACE": "a@1", "PMIX_RANK": "0", "PRTE_LAUNCHED": "1"}
    from atomistic.lammps.engine import run_command, run_in_process, script

    here = run_in_process(Path("deck")).force
    one, two = script("lmp"), f"{script('mpiexec')} -n 2 {script('lmp')}"
    print(here, *(run_command(Path("deck"), command).force for command in (one, two)))
"""


def test_only_one_process_of_a_world_calls_lammps(tmp_path: Path) -> None:
    """The usual script, in which the first process does the work; MPI would wait for the other one, for ever."""
    wall = LennardJonesSpline(adhesion_length=0.005)
    write_deck(tmp_path / "deck", Deck(Slab((4, 4), mobile=2), Springs(), wall, np.zeros((4, 4)), 0.9))
    (tmp_path / "run.py").write_text(RUN)
    done = subprocess.run(
        [script("mpiexec"), "-n", "2", sys.executable, "run.py"],
        cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(ROOT)}, timeout=300, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    here, *others = map(float, done.stdout.split())
    assert here > 0.5
    assert others == pytest.approx([here, here], rel=1e-6)  # relaxed to 1e-9 of E* a0², in another order of sums


def test_a_world_that_was_entered_before_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """By LAMMPS of the user's own, say: MPI begins once only."""
    monkeypatch.setattr(engine, "_processes", lambda mpi: 4)
    with pytest.raises(LammpsError, match=r"as one of 4 processes, .* import mpi4py\.MPI before"):
        engine.open_library()


@pytest.mark.skipif("mpi4py" in sys.modules, reason="MPI belongs to mpi4py here")
def test_this_process_is_alone() -> None:
    engine.open_library().close()
    assert engine._processes(engine._load_mpi()) == 1
