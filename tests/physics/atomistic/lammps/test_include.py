"""The wall as an include of scripts that are not ours: other atom styles, units, species and drives."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import ase.build
import ase.io
import numpy as np
import pytest
import scipy

import atomistic as a
import continuum as c
from atomistic.front.cli import main
from atomistic.inputs.deck import DeckConfig
from atomistic.lammps.engine import alone
from atomistic.lammps.include import WallInclude, _names_in
from continuum.inputs.reading import parsed, source_of
from continuum.inputs.units import ANGSTROM, GPA_PER_EV_PER_A3
from continuum.model.fourier import Real
from continuum.model.walls import Wall

LMP = Path(sys.prefix) / "bin/lmp"
OLDEST = Path(sys.prefix) / "oldest-lammps/lammps/lmp"
A0, MODULUS = 2.6, 130.0
"""In Å and GPa."""
LX, LY = 31.0, 29.0
"""Of the box, in Å, half a per cent more than the period of the wall."""
SPLINE = c.LennardJonesSpline(adhesion_length=0.005)
KCAL = 23.060547830619026
ELEMENTARY = 1.602176634
"""eV/Å in nN."""


def heights() -> Real:
    return c.SelfAffine(0.8, 0.25, 2.5, 6).synthesise(c.Grid.square(24, 0.5), np.random.default_rng(4))


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The folder of a user."""
    monkeypatch.chdir(tmp_path)


def write(law: Wall = SPLINE, **given: Any) -> WallInclude:
    contact = c.Contact(heights(), law, period=(LX / 1.005 / A0, LY / 1.005 / A0))
    return a.write_wall(
        contact, "wall", a0=A0, contact_modulus=MODULUS / GPA_PER_EV_PER_A3, **{"surface_atoms": 120} | given
    )


def run(script: str, lmp: Path = LMP, processes: int = 1) -> str:
    """Run a script of a user; returns what LAMMPS prints."""
    Path("in.mine").write_text(script)
    launcher = [str(LMP.with_name("mpiexec")), "-n", str(processes)] if processes > 1 else []
    words = [*launcher, str(lmp), "-in", "in.mine", "-log", "none"]
    found = subprocess.run(words, capture_output=True, text=True, env=alone(os.environ), check=False)
    return f"{found.stdout}{found.stderr}\nstatus {found.returncode}"


def dumped(path: Path) -> Real:
    return np.loadtxt(path, skiprows=9)


GAS = """\
units {units}
atom_style {style}
timestep {dt}
region box block -3 {hx} 2 {hy} -20 40
create_box 2 box
create_atoms 1 random 150 11 box
create_atoms 2 random 150 12 box
mass 1 28
mass 2 16
pair_style zero 6.0 nocoeff
pair_coeff * *
{before}
variable wall_surface index 4.0
variable wall_distance index 1.5
variable wall_x equal 7.0
variable wall_y equal 3.0
include wall/in.wall
fix_modify wall energy yes
thermo_style custom step pe
run 0
write_dump all custom mine.dump id x y z fx fy fz v_wall_gap v_wall_energy modify sort id format float %.17g
print "load $(v_wall_trace_load:%.17g) lateral $(v_wall_trace_lateral_x:%.17g) pe $(pe:%.17g)"
"""
GAS_OF = {
    "metal": {"units": "metal", "style": "atomic", "dt": 0.001, "before": ""},
    "real": {"units": "real", "style": "full", "dt": 1.0, "before": "variable wall_units index real"},
}


def gas(units: str) -> str:
    return GAS.format(hx=LX - 3, hy=LY + 2, **GAS_OF[units])


def by_hand(wall: WallInclude, at: Real) -> tuple[Real, Real, Real]:
    """Forces, in eV/Å, gaps, in a0, and energies, in eV, of atoms at positions in Å, by the law itself."""
    x, y = ((at[:, i] - low - shift) / 1.005 / A0 for i, (low, shift) in enumerate([(-3, 7), (2, 3)]))
    height, slope_x, slope_y = wall.shape.evaluate(x, y)
    gap = (1.5 - A0 * wall.lowest) / A0 + height - (at[:, 2] - 4.0) / A0
    law = wall.law.evaluate(gap)
    area, modulus = LX * LY / 120, MODULUS / GPA_PER_EV_PER_A3
    p = law.traction * modulus * area
    # The wall is stretched by half a per cent to the box, and so are its slopes.
    return np.column_stack([p * slope_x / 1.005, p * slope_y / 1.005, -p]), gap, law.energy * modulus * area * A0


@pytest.mark.parametrize("law", [SPLINE, c.InversePowers((9, 3), 0.5)], ids=["spline", "9-3 in layers"])
def test_forces_are_those_of_the_law_in_any_units_and_in_the_oldest_lammps(law: Wall) -> None:
    wall = write(law, layer=None if law is SPLINE else "2.1Å")
    # A formula is exact but for rounding, a table to 1e-5 of the largest tension or of the traction.
    exact = 1e-11 if law is SPLINE else 2e-5
    # The oldest has one of them for each law: a second is half as long as all else.
    units_of_oldest = ("real", KCAL) if law is SPLINE else ("metal", 1.0)
    cases = [("metal", 1.0, LMP), ("real", KCAL, LMP)] + ([(*units_of_oldest, OLDEST)] if OLDEST.is_file() else [])
    for units, eV, lmp in cases:
        said = run(gas(units), lmp)
        assert "status 0" in said, said
        rows = dumped(Path("mine.dump"))
        forces, gap, energies = by_hand(wall, rows[:, 1:4])
        assert np.count_nonzero(forces[:, 2]) > 40
        assert rows[:, 4:7] / eV == pytest.approx(forces, rel=exact, abs=exact)
        assert rows[:, 7] == pytest.approx(gap, abs=1e-11)
        printed = dict(zip(*(iter(said[said.index("load ") :].split()[:6]),) * 2, strict=True))
        assert float(printed["load"]) == pytest.approx(-forces[:, 2].sum() * ELEMENTARY, rel=exact)
        assert float(printed["lateral"]) == pytest.approx(forces[:, 0].sum() * ELEMENTARY, rel=10 * exact)
        assert float(printed["pe"]) / eV == pytest.approx(energies.sum(), rel=10 * exact)


FAULTS = {
    "variable wall_units index lj": "wall_units:_metal_or_real",
    "variable wall_units index real": "wall_units_is_real,_but_the_time_step_is_one_of_units_metal",
    "variable wall_surface_atoms index 0": "wall_surface_atoms:_the_number_of_atoms_of_the_surface_plane",
    "change_box all triclinic xy final 1.0 remap": "the_wall_needs_a_box_that_is_not_triclinic",
    "change_box all x final -3 29": "this_wall_is_for_a_box_of_30.845771_by_28.855721_Angstrom",
    "variable wall_pressure index 0.5": "wall_temperature:_that_of_the_thermostat,_in_K",
}


@pytest.mark.parametrize(("line", "message"), FAULTS.items(), ids=FAULTS.values())
def test_a_fault_in_the_script_of_the_user_is_named(line: str, message: str) -> None:
    write()
    said = run(gas("metal").replace("variable wall_surface index", f"{line}\nvariable wall_surface index"))
    assert f"Unknown command: {message}" in said


CHAINS = """\
units real
atom_style full
bond_style harmonic
angle_style harmonic
pair_style lj/cut/coul/cut 8.0
boundary p p f
read_data chains.data
pair_coeff 1 1 0.1 3.5
pair_coeff 2 2 0.15 3.0
pair_coeff 1 2 0.12 3.2
bond_coeff 1 150.0 1.6
angle_coeff 1 30.0 110.0
special_bonds lj/coul 0 0 1
timestep {dt}
fix floor all wall/lj126 zlo -12.0 0.2 3.0 2.5
fix_modify floor energy yes
variable wall_units index real
variable wall_distance index 2.0
variable wall_velocity_x index {velocity}
variable wall_every index {every}
include wall/in.wall
compute motion all ke
variable whole equal c_thermo_pe+c_motion
variable ofwall equal c_wall_energy*v_wall_energy_unit
fix energies all ave/time {every} 1 {every} v_whole v_ofwall file energies.txt format " %.17g"
fix move all nve
run {steps}
print "smallest $(v_wall_trace_smallest_gap)"
"""


def write_chains() -> None:
    """Twelve chains of four charged beads of two species, with bonds and angles, in two layers."""
    beads, bonds, angles = list[str](), list[str](), list[str]()
    for chain in range(12):
        x, y, z = 10 * (chain % 3), 14 * (chain // 3 % 2), -4.0 * (chain // 6)
        for i in range(4):
            n = len(beads) + 1
            beads.append(f"{n} {chain + 1} {1 + i % 2} {0.2 - 0.4 * (i % 2)} {x + 1.3 * i} {y + 0.9 * (i % 2)} {z}")
            if i:
                bonds.append(f"{len(bonds) + 1} 1 {n - 1} {n}")
            if i > 1:
                angles.append(f"{len(angles) + 1} 1 {n - 2} {n - 1} {n}")
    sections = {"Masses": ["1 14.0", "2 15.0"], "Atoms # full": beads, "Bonds": bonds, "Angles": angles}
    head = f"{len(beads)} atoms\n{len(bonds)} bonds\n{len(angles)} angles\n2 atom types\n1 bond types\n1 angle types\n"
    box = f"0 {LX} xlo xhi\n0 {LY} ylo yhi\n-14 20 zlo zhi\n"
    body = "".join(f"\n{name}\n\n" + "\n".join(rows) + "\n" for name, rows in sections.items())
    Path("chains.data").write_text(f"chains\n\n{head}\n{box}{body}")


@pytest.mark.long
def test_charged_chains_with_bonds_keep_their_energy_under_the_wall() -> None:
    write(surface_atoms=60)
    write_chains()
    scatter = []
    for every in (1, 2):  # the same times, by steps of 1 and 0.5 fs
        said = run(CHAINS.format(dt=1.0 / every, velocity=0, every=4 * every, steps=200 * every))
        assert "status 0" in said, said
        whole, of_wall = np.loadtxt("energies.txt").T[1:]
        scatter.append(np.std(whole))
        assert np.ptp(of_wall) > 100 * np.ptp(whole)
    # What is left is the error of Verlet's method, of second order; a force that is no gradient would stay.
    assert scatter[1] < scatter[0] / 3


def test_a_wall_that_slides_writes_its_trace() -> None:
    write(surface_atoms=60)
    write_chains()
    said = run(CHAINS.format(dt=0.5, velocity=100, every=10, steps=100))
    assert "status 0" in said, said
    trace = a.read_trace("wall.trace.txt")
    assert trace["step"] == pytest.approx(np.arange(0, 101, 10))
    assert trace["offset_x"] == pytest.approx(100 * 1e-5 * 0.5 * trace["step"], abs=1e-12)
    assert np.ptp(trace["load"]) > 0
    assert trace["smallest_gap"][-1] == pytest.approx(float(said.split("smallest")[-1].split()[0]), rel=1e-5)


def test_a_fixed_wall_has_the_load_of_our_own_deck() -> None:
    tables = {
        "interatomic": {"kind": "eam", "file": "Cu_mishin1.eam.alloy"}, "slab": {"n": [9, 9], "depth": 4.0},
        "surface": {"kind": "sine", "amplitude": 0.13, "waves": [2, 0]}, "follows": "atom", "separation": 1.1,
        "wall": {"law": "lennard-jones-spline", "adhesion_length": 0.005},
    }  # fmt: skip
    deck = a.deck(parsed(source_of(tables, "deck"), DeckConfig))
    done = a.run_deck(deck.write("deck"))
    model, shape = deck.model, deck.shape
    assert isinstance(shape, a.Waves)
    wall = a.write_wall(
        shape, "wall", law=deck.wall, a0=model.length, contact_modulus=model.energy / model.length**3, surface_atoms=81
    )
    said = run(f"""\
units metal
boundary p p f
read_data deck/slab.data
pair_style eam/alloy
pair_coeff * * deck/{next(iter(model.files))} Cu
read_dump deck/state.dump 0 x y z label x xu label y yu label z zu wrapped no box no
variable wall_surface index {model.length * deck.surface!r}
variable wall_distance index {model.length * (1.1 + wall.lowest)!r}
variable wall_trace index trace.txt
include wall/in.wall
run 0
""")
    assert "status 0" in said, said
    assert done.description.real_units is not None
    newtons = done.description.real_units.si("force") * 1e9
    assert a.read_trace("trace.txt")["load"] == pytest.approx([newtons * done.last.force], rel=1e-9)
    assert done.last.force != 0


def slab_file() -> None:
    slab = ase.build.fcc111("Cu", (12, 14, 4), a=3.6, orthogonal=True, periodic=True, vacuum=8)
    ase.io.write("slab.mine", slab, format="lammps-data", masses=True)
    x, y = slab.cell.lengths()[:2]
    np.savetxt("map.txt", c.SelfAffine(0.8, 0.2, 3, 6).synthesise(c.Grid.square(24, 0.5), np.random.default_rng(1)))
    Path("size").write_text(f"{x:.6f}Å,{y:.6f}Å")


WORDS = "--a0 2.55Å --estar 135GPa --work 0.1J/m2 --slab slab.mine --edges periodic --unit Å"


def test_the_command_counts_the_exposed_atoms_and_names_the_next_step(capsys: pytest.CaptureFixture[str]) -> None:
    slab_file()
    size = Path("size").read_text()
    assert main(["wall", "map.txt", *WORDS.split(), "--size", size]) == 0
    said = capsys.readouterr().out
    assert "168 surface atoms" in said
    # Its folder is taken for that of a deck.
    assert main(["read", "wall"]) == 2
    assert "read the trace of its run" in capsys.readouterr().err
    assert "include  wall/in.wall" in said
    assert "variable        wall_surface_atoms index 168 " in Path("wall/in.wall").read_text()
    # All names are its own.
    names = set().union(*(_names_in(path.read_text()) for path in Path("wall").glob("in.*")))
    assert not names
    assert "variable        wall_gap atom v_wall_separation+" in Path("wall/in.wall").read_text()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("--a0 2.55", "a0"),
        ("--a0 2.55nm", "about the distance of neighbours in the slab"),
        ("--edges mirror", "at least 32 a0 a side"),
        ("--estar 135eV/A3", "possible are"),
        ("--work 20J/m2", "the law would reach further"),
        ("--surface-atoms 3", "with it, each of 3 atoms"),
        ("--slab nowhere.data", "slab"),
        ("--size 10Å", "within 2%"),
        ("--law law.toml", "not both"),
        ("-o with$name", "as LAMMPS reads it"),
        ("-o .", "choose another"),
    ],
)
def test_what_is_not_allowed_is_refused_before_anything_is_written(
    words: str, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    slab_file()
    size = Path("size").read_text()
    given = dict(zip(*(iter([*WORDS.split(), "--size", size]),) * 2, strict=True))
    name, value = words.split()
    given[name] = value
    assert main(["wall", "map.txt", *(word for pair in given.items() for word in pair)]) == 2
    said = capsys.readouterr().err
    assert message in said
    assert not Path("wall").exists()


FREE = """\
units {units}
region box block 0 {lx} 0 {ly} -20 60
create_box 1 box
create_atoms 1 single 1 1 -10
mass 1 63.5
pair_style zero 3.0 nocoeff
pair_coeff * *
timestep {dt}
variable wall_units index {units}
variable wall_surface index 0
variable wall_distance index 30
variable wall_velocity_x index 400
variable wall_temperature index 300
variable wall_drag_x index 0.002
variable wall_drag_y index 0.002
variable wall_drag_z index 0.002
variable wall_spring_x index 20
variable wall_spring_y index 20
variable wall_spring_z index 20
variable wall_every index 5
include wall/in.wall
run 12000
"""


@pytest.mark.long
@pytest.mark.parametrize("units", ["metal", "real"])
def test_a_free_wall_on_springs_has_the_energy_of_its_temperature(units: str) -> None:
    """Each axis has the variance k_B T/K, and lags behind the end of its spring by drag times velocity over K."""
    wave = a.Waves((LX / A0, LY / A0), 0.0, ((0.2, 1, 0, 0.0),))
    a.write_wall(wave, "wall", law=SPLINE, a0=A0, contact_modulus="130GPa", surface_atoms=60)
    said = run(FREE.format(units=units, lx=LX, ly=LY, dt={"metal": 0.002, "real": 2.0}[units]))
    assert "status 0" in said, said
    trace = a.read_trace("wall.trace.txt").after(1000)
    way = 400e-5 * 2 * trace["step"]  # m/s in Å/fs, by steps of 2 fs
    drag, spring, dt = 0.002e-9, 20.0, 2e-15  # SI
    # Euler's steps of an overdamped wall: the variance is that of equipartition over 1 - K dt/(2 drag).
    wanted = scipy.constants.k * 300 / spring / (1 - spring * dt / (2 * drag)) / ANGSTROM**2
    found = [np.var(values) for values in (trace["offset_x"] - way, trace["offset_y"], trace["distance"])]
    # It forgets in drag/K, 50 steps: 110 independent values along each of three axes have a standard error of 8 %.
    assert np.mean(found) == pytest.approx(wanted, rel=0.32)
    mean = 4 * np.sqrt(wanted / 110)
    lag = way.mean() - trace["offset_x"].mean()
    assert lag == pytest.approx(400 * drag / spring / ANGSTROM, abs=mean)
    assert trace["pull_x"].mean() == pytest.approx(lag * ANGSTROM * spring * 1e9, rel=1e-3)
    assert trace["distance"].mean() == pytest.approx(30, abs=mean)


LOADED = """\
units metal
boundary p p f
lattice fcc 3.6
region box block 0 {lx} 0 {ly} -20 30 units box
create_box 2 box
region slab block INF INF INF INF -7.3 0.1 units box
create_atoms 1 region slab
set type 1 type/fraction 2 0.3 77
mass 1 63.5
mass 2 58.7
pair_style lj/cut 5.5
pair_coeff 1 1 0.4 2.3
pair_coeff 2 2 0.45 2.25
pair_coeff 1 2 0.42 2.28
region low block INF INF INF INF -8 -5 units box
group base region low
group mobile subtract all base
region top block INF INF INF INF -0.5 1 units box
group top region top
timestep 0.002
velocity mobile create 300 5
variable wall_group string mobile
variable wall_surface_atoms equal $(count(top))
variable wall_distance index 1.7
variable wall_temperature index 150
variable wall_velocity_x index 50
{drive}
include wall/in.wall
fix base base setforce 0 0 0
fix warm mobile langevin 150 150 0.2 3
fix move mobile nve
run 2500
"""
DRIVES = {
    "load": "variable wall_pressure index 2.0",
    "load and lateral springs": "\n".join(
        ["variable wall_pressure index 2.0", "variable wall_spring_x index 40", "variable wall_spring_y index 40"]
    ),
    "spring": "variable wall_spring_z index 100",
    "height": "",
}


def test_a_wall_that_moves_by_its_load_and_noise_is_the_same_on_two_processes() -> None:
    lx = 6 * 3.6
    shape = a.Waves((lx / A0, lx / A0), 0.0, ((0.2, 2, 1, 0.3),))
    a.write_wall(shape, "wall", law=SPLINE, a0=A0, contact_modulus="130GPa")
    script = LOADED.format(lx=lx, ly=lx, drive=DRIVES["load and lateral springs"]).replace("run 2500", "run 60")
    script = script.replace("fix warm", "# fix warm")  # whose noise depends on the number of processes
    traces = []
    for processes in (1, 2):
        assert "status 0" in (said := run(script, processes=processes)), said
        traces.append(a.read_trace("wall.trace.txt"))
    for name in ("distance", "offset_x", "load", "pull_x", "taken_by_wall"):
        # Sums over atoms differ by rounding, which sixty steps of a trajectory do not let grow beyond this.
        assert traces[0][name] == pytest.approx(traces[1][name], rel=1e-8, abs=1e-10), name
    assert np.ptp(traces[0]["distance"]) > 0


@pytest.mark.parametrize("drive", DRIVES)
def test_each_drive_is_read_by_lammps_and_moves_the_wall_as_it_says(drive: str) -> None:
    lx = 6 * 3.6
    a.write_wall(
        a.Waves((lx / A0, lx / A0), 0.0, ((0.2, 2, 1, 0.3),)), "wall", law=SPLINE, a0=A0, contact_modulus="130GPa"
    )
    said = run(LOADED.format(lx=lx, ly=lx, drive=DRIVES[drive]).replace("run 2500", "run 40"))
    assert "status 0" in said, said
    trace = a.read_trace("wall.trace.txt")
    assert (np.ptp(trace["distance"]) > 0) == (drive != "height")
    assert np.ptp(trace["offset_x"]) > 0
    assert trace["total_energy"].size > 2


@pytest.mark.long
@pytest.mark.parametrize("drive", DRIVES)
def test_each_drive_presses_on_an_alloy_and_slides(drive: str) -> None:
    lx, ly = 6 * 3.6, 6 * 3.6
    shape = a.Waves((lx / A0, ly / A0), 0.0, ((0.2, 2, 1, 0.3), (0.2, -1, 2, 1.0)))
    a.write_wall(shape, "wall", law=SPLINE, a0=A0, contact_modulus="130GPa")
    said = run(LOADED.format(lx=lx, ly=ly, drive=DRIVES[drive]))
    assert "status 0" in said, said
    trace = a.read_trace("wall.trace.txt")
    late = trace.after(1000)
    load, error = late.mean("load")
    weight = 2.0 * lx * ly * 0.01  # GPa and Å² in nN
    if "wall_pressure" in DRIVES[drive]:
        # The error is that of ten blocks, whose correlations make it too small by up to a factor of two.
        assert load == pytest.approx(weight, abs=8 * error)
        assert error < 0.1 * weight
    elif drive == "spring":
        # A wall without mass: spring and contact balance.
        assert load == pytest.approx(-late.mean("pull_z")[0], abs=8 * error + 0.02 * weight)
        assert load > 0
    else:
        assert np.ptp(trace["distance"]) == 0
    way = 50e-5 * 2 * (late["step"][-1] - late["step"][0])
    assert np.ptp(late["offset_x"]) == pytest.approx(way, abs=2.0 if "spring_x" in DRIVES[drive] else 1e-9)
    ratio, of_ratio = late.friction("x")
    assert np.isfinite([ratio, of_ratio]).all()
    assert trace["temperature"][-1] > 0


REACTIVE = """\
units real
atom_style charge
timestep 0.25
region box block -3 {hx} 2 {hy} -20 40
create_box 2 box
lattice sc 3.1
region some block INF INF INF INF -6 7 units box
create_atoms 1 region some
set type 1 type/fraction 2 0.5 7
displace_atoms all random 0.3 0.3 0.3 9
mass 1 12
mass 2 1
pair_style reaxff NULL
pair_coeff * * {field} C H
fix charges all qeq/reaxff 1 0.0 10.0 1e-6 reaxff
{wall}
run 0
write_dump all custom mine.dump id x y z fx fy fz modify sort id format float %.17g
"""


@pytest.mark.parametrize("lmp", [LMP, pytest.param(OLDEST, marks=pytest.mark.long)], ids=["present", "oldest"])
def test_the_wall_adds_its_forces_to_those_of_reaxff_with_charges(lmp: Path) -> None:
    wall, forces = write(), []
    lines = gas("real").split("variable wall_surface")[1].split("fix_modify")[0]
    for included in ("", f"variable wall_units index real\nvariable wall_surface{lines}"):
        field = a.find_potential("ffield.reax.cho")
        said = run(REACTIVE.format(hx=LX - 3, hy=LY + 2, field=field, wall=included), lmp)
        assert "status 0" in said, said
        rows = dumped(Path("mine.dump"))
        forces.append(rows[:, 4:7] / KCAL)
    expected = by_hand(wall, rows[:, 1:4])[0]
    assert np.count_nonzero(expected[:, 2]) > 100
    assert forces[1] - forces[0] == pytest.approx(expected, rel=1e-10, abs=1e-10)


OXIDE = """\
units metal
atom_style charge
boundary p p f
lattice custom 4.21 basis 0 0 0 basis .5 .5 0 basis .5 0 .5 basis 0 .5 .5 &
  basis .5 0 0 basis 0 .5 0 basis 0 0 .5 basis .5 .5 .5
region box block 0 6 0 6 0 12
create_box 2 box
region slab block INF INF INF INF 0 2.9
create_atoms 1 region slab basis 5 2 basis 6 2 basis 7 2 basis 8 2
mass 1 24.3
mass 2 16.0
set type 1 charge 2
set type 2 charge -2
{pair}
timestep 0.001
region low block INF INF INF INF INF 2.5 units box
group base region low
group mobile subtract all base
region top block INF INF INF INF 10.0 INF units box
group top region top
velocity mobile create 600 1
variable wall_surface_atoms equal count(top)
variable wall_pressure index 1.0
variable wall_temperature index 300
variable wall_velocity_x index 100
variable wall_spring_x index 20
variable wall_distance index 2.2
variable wall_every index 4
include wall/in.wall
fix held base setforce 0 0 0
fix warm mobile langevin 300 300 0.1 2
fix motion mobile nve
run 200
"""
PAIRS = {
    "long-range charges": "pair_style buck/coul/long 8.0\npair_coeff 1 1 0 1 0\npair_coeff 1 2 1428.5 0.2945 0\n"
    "pair_coeff 2 2 22764.0 0.149 27.88\nkspace_style pppm 1e-4\nkspace_modify slab 3.0",
    "screened charges": "pair_style hybrid/overlay buck 8.0 coul/wolf 0.3 8.0\npair_coeff * * coul/wolf\n"
    "pair_coeff 1 1 buck 0 1 0\npair_coeff 1 2 buck 1428.5 0.2945 0\npair_coeff 2 2 buck 22764.0 0.149 27.88",
}


@pytest.mark.long
@pytest.mark.parametrize("lmp", [LMP, OLDEST], ids=["present", "oldest"])
@pytest.mark.parametrize("pair", PAIRS.values(), ids=PAIRS)
def test_an_oxide_is_pressed_and_sheared(pair: str, lmp: Path) -> None:
    """Magnesium oxide: the wall comes into contact under its load, and no ion passes through it."""
    if not lmp.is_file():
        pytest.skip("no old LAMMPS: `make test` brings it")
    period = 6 * 4.21 / 2.1
    waves = a.Waves((period, period), 0.0, ((0.2, 1, 0, 0.3), (0.2, 0, 1, 1.0)))
    a.write_wall(waves, "wall", law=SPLINE, a0="2.1Å", contact_modulus="250GPa")
    said = run(OXIDE.format(pair=pair), lmp)
    assert "status 0" in said, said
    trace = a.read_trace("wall.trace.txt")
    assert trace["load_rep"].max() > 0
    assert trace["smallest_gap"].min() > 0.7 * 2.1
    assert np.isfinite(trace["total_energy"]).all()
    # The spring drags the wall along x, by 0.2 Å in this time less what it lags.
    assert 0.05 < trace["offset_x"][-1] < 0.4
