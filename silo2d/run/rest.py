"""Forces at the walls while a packing comes to rest behind the door: the last looks at it.

A stiff bed still breathes when it counts as settled: in a single moment the walls bear some per
cent more or less than its weight. So the loads at rest are means over the last looks, with the
vertical momentum at each, by which forces and weight balance.
"""

from dataclasses import dataclass, field

import numpy as np

from silo2d.engine import state
from silo2d.engine.simulation import Simulation

LOOKS = 20  # that are kept


@dataclass
class Rest:
    """Forces and momentum at the looks before the opening.

    time        of each look [s], of the phase's clock
    momentum    vertical momentum of the particles then [kg m/s]
    force       mean force on each wall (w, 2) [N] since the look before; of the first look since
                the beginning of the phase
    """

    time: list[float] = field(default_factory=list)
    momentum: list[float] = field(default_factory=list)
    force: list[np.ndarray] = field(default_factory=list)

    def look(self, sim: Simulation) -> None:
        """Keep momentum and a sample of the walls; the forces until now come with the next call."""
        rows = sim.rows[sim.live]
        self.time.append(sim.time)
        self.momentum.append(float((rows[:, state.UY] / rows[:, state.INV_MASS]).sum()))
        sim.sample_walls(most=LOOKS)

    def tables(self, sim: Simulation, force: np.ndarray) -> dict[str, dict[str, np.ndarray]]:
        """Tables of the last looks for the first frame; force: mean since the last look but one.

        "settling" has a row a look, "walls" the samples, times before the opening negative.
        """
        forces = [*self.force, force][-len(self.time) :]
        looks = slice(-LOOKS, None)
        samples = sim.wall_samples()
        return {
            "settling": {
                "time": np.array(self.time[looks]) - sim.time,
                "momentum": np.array(self.momentum[looks]),
                "force": np.array(forces[looks]),
            },
            "walls": {**samples, "time": samples["time"] - sim.time},
        }
