"""
A sweep
=======

One input describes twelve paths: three strengths of adhesion on four surfaces. Each path is stored in a file, so that
a second call would compute nothing, and one table collects all points. Bars show the scatter over surfaces.
"""

import tempfile

from matplotlib import pyplot as plt

import continuum as c

given = {
    "grid": {"n": 64},
    "surface": {"kind": "self-affine", "hurst": 0.8, "rms_slope": 0.1, "lambda_s": 4.0, "lambda_L": 32.0, "seed": 1},
    "wall": {"law": "lennard-jones-spline", "adhesion_length": 0.005},
    "substrate": {"response": "half-space", "mean": "clamped"},
    "loading": {"control": "repulsive-area", "targets": [0.02, 0.05, 0.1, 0.15]},
    "sweep": {"axes": {"wall.adhesion_length": [0.0, 0.005, 0.02], "surface.seed": [1, 2, 3, 4]}},
}
with tempfile.TemporaryDirectory() as folder:
    table = c.sweep(given, folder, name="adhesion", workers=1).collect().to_pandas()
figure, axis = plt.subplots()
for length, points in table.groupby("wall.adhesion_length"):
    found = points.groupby("step")[["area_rep", "load"]].agg(["mean", "std"])
    bars = found["load", "std"]
    axis.errorbar(
        found["area_rep", "mean"], found["load", "mean"], bars, fmt="o-", label=rf"$\ell_a$ = {length:g} $a_0$"
    )
axis.axhline(0, color="0.7", linewidth=0.6, zorder=0)
axis.set(xlabel=r"repulsive area $A_\mathrm{rep}/A_0$", ylabel="load $N/(E^*A_0)$")
axis.legend()
