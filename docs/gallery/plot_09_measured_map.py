"""
A measured map
==============

Does this surface stick? We press the map without adhesion until 1 % of it touches. The gaps of this one state give
the threshold: the work of adhesion above which the surface sticks. The map comes with the package; for your own, give
its path, the unit of its heights and its size.
"""

from matplotlib import pyplot as plt

import continuum as c

given = {"size": "384nm", "unit": "nm", "material": ["silicon", "silicon"], "fill": "5%"}
verdict = c.predict("inputs/maps/wafer.txt", **given).verdict
ranges = ["0.1nm", "0.2nm", "0.5nm", "1nm", "2nm"]
thresholds = [c.predict("inputs/maps/wafer.txt", range=reach, **given).threshold for reach in ranges]
figure, axis = plt.subplots()
nm = [1e9 * one.range for one in thresholds]
axis.fill_between(nm, [1e3 * one.low for one in thresholds], [1e3 * one.high for one in thresholds], alpha=0.3)
axis.plot(nm, [1e3 * one.work for one in thresholds], "o-", mfc="none", label="threshold $w_c$ of this map")
axis.axhline(100, color="C1", label="two faces of silicon")
axis.set(xscale="log", yscale="log", xlabel="range of the attraction (nm)", ylabel="work of adhesion (mJ/m²)")
axis.set_yticks([20, 50, 100], ["20", "50", "100"])
axis.set_xticks([0.1, 0.2, 0.5, 1, 2], ["0.1", "0.2", "0.5", "1", "2"])
axis.minorticks_off()
axis.set_title(f"{verdict.answer}: work of adhesion over the threshold {verdict.factor:.1f}")
axis.legend()
