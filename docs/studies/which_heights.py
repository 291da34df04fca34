"""Changes of a surface by the derivative of its threshold: ``nice python -m docs.studies.which_heights`` draws them.

Into docs/gradients.png.  A surface is changed from one that sticks at a given work of adhesion into one that does not,
and from one that does not into one that does: by the least volume that is taken off, with a tool 2 a0 wide and at most
0.1 a0 deep; and by the least rms change of the heights at an unchanged elastic energy of full contact, U.  Each is
confirmed by a search for its threshold.

The heights are those of the upper, rough wall: what is taken off makes them greater, and the contact is where they are
least.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import continuum as c
from continuum.show import plot

AREA, TOOL, DEEPEST = 0.04, 2.0, 0.1
grid = c.Grid.square(96)
heights = c.SelfAffine(0.8, 0.1, 8, 32).synthesise(grid, np.random.default_rng(1))
q = grid.wavenumber
FOOTPRINT = np.exp(-((q * TOOL) ** 2) / 2)


def wall(work):
    """An attraction of one range and any strength."""
    return c.attraction_on_core("spline", work, 0.4, core_stiffness=5.0)


def pressed(heights, work):
    """The state at the area at which the sign of the load is taken."""
    return c.Contact(heights, wall(work), area_tolerance=0.002).press(area=AREA).require()


def threshold(heights):
    """The work of adhesion from which on the load at this area is negative."""
    return c.Contact(heights, wall(0.002), area_tolerance=0.002).find_threshold(wall, area=AREA, width=0.01).require()


def filtered(field, response):
    """A field with each of its waves multiplied by a response."""
    return grid.inverse(response * grid.forward(field))


def energy(heights):
    """U of the heights."""
    return 0.25 * grid.inner_q(grid.forward(heights), q * grid.forward(heights))


def across(work, change):
    """The heights, changed until the load at the given area has another sign and at least 3 % of its size."""
    state, now = pressed(heights, work), heights
    first = state.load
    while state.load / first > -0.03:
        now = change(now, state.gradient("load", at="area"), -0.21 * first)
        state = pressed(now, work)
    return now


def least_volume():
    """Where the tool gains most, it takes off as much as it may: the least volume for a given change of the load."""
    amount = np.zeros(grid.shape)

    def change(now, gradient, wanted):
        gain = filtered(gradient, FOOTPRINT) * np.sign(wanted)
        best = np.argsort(-gain, axis=None)
        gained = np.cumsum((gain * (DEEPEST - amount)).flat[best])
        amount.flat[best[: np.searchsorted(gained, abs(wanted)) + 1]] = DEEPEST
        return heights + filtered(amount, FOOTPRINT)

    return change


def least_rms():
    """In the waves that the surface has, the shortest change along which the load changes and U does not."""
    waves = (q > 0) & (q <= 2 * np.pi / 8)

    def change(now, gradient, wanted):
        along = np.stack([filtered(gradient, waves).ravel(), filtered(now, q * waves).ravel() / 2])
        # What the last step has changed U by, to second order, is taken back.
        asked = [wanted, (energy(heights) - energy(now)) * grid.size]
        return now + (np.linalg.solve(along @ along.T, asked) @ along).reshape(grid.shape)

    return change


@plot.styled
def main() -> None:
    """Change the surface in four ways, and draw where, and what became of its threshold."""
    whole = threshold(heights)
    surfaces = {}
    for words, factor in (("not to stick at 1.25 w", 1.25), ("to stick at 0.8 w", 0.8)):
        for name, change in (("volume", least_volume()), ("rms", least_rms())):
            surfaces[f"least {name}, {words}"] = across(factor * whole.work, change)

    gradient = whole.gradient()
    noise = c.noise_error(grid, gradient, 0.01) / whole.work
    maps = {
        f"derivative of w, 1/$a_0$\nnoise of 0.01 $a_0$: {noise:.1%} of w": filtered(gradient, FOOTPRINT) / whole.work
    }
    for name, changed in surfaces.items():
        gone = changed - heights
        kept = f"U x {energy(changed) / energy(heights):.3f}"
        size = (
            f"{gone.mean():.4f} $a_0$"
            if "volume" in name
            else rf"{gone.std() / heights.std():.1%} of $h_\mathrm{{rms}}$"
        )
        maps[f"{name}\n{size}, {kept}"] = gone
    figure, axes = plot.new_axes(plot.PAGE, 4.9, 2, 3)
    extent = (0, grid.lengths[1], 0, grid.lengths[0])
    for axis, (name, values) in zip(axes.flat, maps.items(), strict=False):
        most = np.abs(values).max()
        colours, least = ("Greys", 0) if "volume" in name else ("RdBu_r", -most)
        image = axis.imshow(values, colours, vmin=least, vmax=most, extent=extent, origin="lower")
        axis.contour(whole.state.contact_map == 2, [0.5], colors="black", linewidths=0.4, extent=extent)
        axis.set_title(name, fontsize=7)
        axis.set(xticks=[], yticks=[])
        figure.colorbar(image, ax=axis, shrink=0.8, aspect=30, pad=0.02)
    last = axes.flat[-1]
    works = whole.work * np.array([0.7, 1.0, 1.3])
    drawn = {"as it is": heights, **surfaces}
    for (name, changed), style in zip(drawn.items(), ("k-", "C0-", "C0--", "C1-", "C1--"), strict=True):
        states = [pressed(changed, work) for work in works]
        label = f"{name.split(' at')[0]}: {threshold(changed).work / whole.work:.2f} w"
        last.plot(works / whole.work, [one.load / one.load_rep for one in states], style, label=label)
    last.axhline(0, color="0.7", linewidth=0.6, zorder=0)
    last.set(xlabel="work of adhesion over w", ylabel="load over repulsive load", ylim=(-0.5, 1.1))
    last.set_title("thresholds found by search", fontsize=7)
    last.legend(fontsize=6, loc="upper left")
    figure.savefig(Path(__file__).parents[1] / "gradients.png", dpi=150)


if __name__ == "__main__":
    main()
