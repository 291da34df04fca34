"""
A measured map
==============

Does this surface stick? The map comes with the package; with a path of your own, and the size and the unit of its
heights, it is yours. It is pressed without adhesion until 1 % touches, and the gaps of that one state say from which
work of adhesion on it holds.
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
