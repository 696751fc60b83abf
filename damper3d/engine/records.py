"""The columns of a damper's samples: their names, units and meaning; and cutting cycles from them.

A run keeps its samples as the frames of its trajectory, so many a cycle and one before the first
cycle: row k per_cycle is the end of cycle k. Energies of mechanisms and the wall work are summed
since the motion began, what the bed holds is that of the moment, forces are means over the time
since the row before, impact speeds the largest and impacts the number since then.
"""

from collections.abc import Mapping
from itertools import chain

import numpy as np

CLASSES = ("particle_particle", "particle_wall")
MECHANISMS = ("normal_damping", "tangential_damping", "friction")
HELD = ("kinetic", "potential", "elastic_normal", "elastic_tangential")

Samples = Mapping[str, np.ndarray]

# Columns of one number, or of the shape in brackets, by the SI unit.
UNITS = {
    "time": "s",
    "displacement": "m",  # of the enclosure along its direction
    "velocity": "m/s",  # likewise
    "wall_work": "J",  # by the enclosure on the bed
    **dict.fromkeys(HELD, "J"),
    **{f"{name}_{pair}": "J" for pair in CLASSES for name in MECHANISMS},
    **{f"law_term_{pair}": "J" for pair in CLASSES},  # gain of springs that stiffen under load
    **{f"slip_count_{pair}": "J" for pair in CLASSES},  # mu Fn times the whole sliding velocity
    **{f"impact_speed_{pair}": "m/s" for pair in CLASSES},
    **{f"contacts_{pair}": "1" for pair in CLASSES},
    "wall_force": "N",  # (walls, 3) on the enclosure
    "mean_position": "m",  # (3,) of the bed's mass, relative to the enclosure
    "mean_velocity": "m/s",  # (3,) likewise, in the laboratory
}
# Columns that not all runs have. Of an enclosure on a host: its energy from static equilibrium; the
# work of force and base on it, and what its own dampers took. Of all but those that an earlier
# version began: impacts since the row before, and those of them beyond the yield velocity.
HOST_UNITS = dict.fromkeys(("host_energy", "host_work", "host_damping"), "J")
IMPACTS = {pair: (f"impacts_{pair}", f"impacts_beyond_yield_{pair}") for pair in CLASSES}
OWN_UNITS = {**HOST_UNITS, **dict.fromkeys(chain(*IMPACTS.values()), "1")}


def cut(samples: Samples, per_cycle: int, first: int, last: int | None = None) -> Samples:
    """The samples of cycles first+1 ... last (None: all), with the row before them.

    Raises ValueError where there are not so many whole cycles.
    """
    n_cycles = (len(samples["time"]) - 1) // per_cycle
    last = n_cycles if last is None else last
    if not 0 <= first < last <= n_cycles:
        raise ValueError(f"cycles {first + 1} to {last} of {n_cycles}")
    rows = slice(first * per_cycle, last * per_cycle + 1)
    return {name: column[rows] for name, column in samples.items()}


def per_cycle_change(column: np.ndarray, per_cycle: int) -> np.ndarray:
    """Return how much a column, as cut, grows in each of its cycles (n_cycles,)."""
    return np.diff(column[::per_cycle])
