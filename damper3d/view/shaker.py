"""A run as a measured record: force and acceleration of its enclosure on a shaker (thesis, ch. 7).

    F = m a - F_bed        of the shaker on the enclosure, along the motion

with m the enclosure's mass, a its acceleration and F_bed the force of the particles on all walls.
The enclosure's own weight, which no piezoelectric transducer holds, is left out. A run keeps the
mean force and the velocity from sample to sample: both signals are means over a sample's time,
which takes the same off both. Forces are those at the beginnings of the steps, so that their mean
is that of half a step earlier, and so is the acceleration here: at 1 kHz and 1 us that half step
would be a phase error of 3 mrad.
"""

import numpy as np
from numpy.typing import NDArray

from damper3d.measures.counted import Cycles
from damper3d.measures.response import along
from granulab.campaign.output.table import numbers_as_csv

# [kg] of an enclosure unless it is given: some seven times the bed of the thesis, which prints no
# mass. The power and the efficiency do not depend on it.
ENCLOSURE_MASS = 0.2
_HEAD = ["time [s]", "force [N]", "acceleration [m/s2]"]


def record_csv(cycles: Cycles, enclosure_mass: float, *, empty: bool = False) -> bytes:
    """A table of the counted cycles; of the enclosure without particles where `empty`.

    Its first line, a comment, gives the masses. enclosure_mass [kg].
    """
    time, acceleration, bed = signals(cycles)
    force = enclosure_mass * acceleration - (0.0 if empty else bed)
    rows = np.column_stack([time, force, acceleration])
    inside = 0.0 if empty else cycles.case.mass
    masses = f"# enclosure {enclosure_mass:.6g} kg, particles {inside:.6g} kg\n"
    return masses.encode() + numbers_as_csv(_HEAD, ["%.12g", "%.9g", "%.9g"], [rows])


def signals(cycles: Cycles) -> tuple[NDArray[np.float64], ...]:
    """Time [s], acceleration [m/s2], force of the bed on the enclosure [N], along the motion (n,).

    Of the counted cycles; times are the middles of the mean forces.
    """
    case, counted = cycles.case, cycles.counted
    end, early = counted["time"], 0.5 * case.time_step
    step = np.diff(end)
    acceleration = np.diff(counted["velocity"]) / step
    acceleration -= early * np.gradient(acceleration, step.mean())
    return end[1:] - 0.5 * step - early, acceleration, along(counted, case.direction)[1:]
