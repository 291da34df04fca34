"""
A sphere on a flat: Hertz
=========================

Without adhesion the pressure under a sphere is Hertz's half-ellipse, and the area is proportional to the load to
the power 2/3. The solver's largest pressure is 0.3 % above Hertz's, on finer grids too, because the sphere has periodic
images. The verification corrects for them: 0.009 % remain.
"""

import numpy as np
from matplotlib import pyplot as plt

import continuum as c

radius, grid = 200.0, c.Grid.square(128)
contact = c.Contact(c.sphere(grid, radius), wall=c.HardWall())
state = contact.press(area=0.06).require()

a = (3 * radius * state.load * 128**2 / 4) ** (1 / 3)  # in a0, with E* = 1
r = np.linspace(0, a, 200)
figure, axis = plt.subplots()
axis.plot(np.arange(128) - 64, state.traction[:, 64], ".", label="solver")
axis.plot(r, 2 * a / (np.pi * radius) * np.sqrt(1 - (r / a) ** 2), label="Hertz, of the same load")
axis.set(xlim=(0, 1.5 * a), xlabel="distance from the axis ($a_0$)", ylabel="pressure ($E^*$)")
axis.legend()
peak, area = 2 * a / (np.pi * radius), np.pi * a**2
axis.set_title(
    f"largest pressure {state.traction.max():.4f} $E^*$, Hertz {peak:.4f} $E^*$;\n"
    f"area {state.area_rep * 128**2:.0f} $a_0^2$, Hertz {area:.0f} $a_0^2$"
)
