"""Random packing in a damper's own enclosure, with its walls: poured, and then shaken down.

Loose is the bed as it settles under gravity from its random start, with the case's friction: what
run.fill gives. Close is the same bed after sustained vertical vibration whose strength falls
from stage to stage, as beds are annealed: at each the particles can just still pass each other.
Both are measured from the bottom to where 80 % of the centres are (damper3d.run.packing).

The fraction of a bed at rest does not hang on how stiff its particles are while overlaps are small,
so that they are taken softer by SOFTER, and the steps longer by its root. Overlaps under the bed's
own weight are then (rho g h/E)^(2/3), 6e-4 of a radius, for acrylic and 40 mm: less than 2e-3 of
the fraction.
"""

import math
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from damper3d.case.case import GRAVITY, DamperCase
from damper3d.case.parameters import materials_of
from damper3d.engine.motions import at_rest, sine
from damper3d.run.fill import fill, packed, resting
from granulab.campaign.runs.protocol import Stop
from granulab.contact.files.datafile import data_file, find
from granulab.contact.files.table import load_table
from granulab.errors import Stopped

SOFTER = 100.0  # times than the case's particles and walls
FREQUENCY = 40.0  # [Hz] of the thesis's damper
STAGES = (4.0, 3.0, 2.0, 1.5)  # Gamma, one after the other
CYCLES = 10  # of each stage
_REST = 0.2  # [s] to settle at last
_SHARE = 0.2  # of the Rayleigh step (thesis, eq. 3.31): its range is 0.1 to 0.4


@dataclass(frozen=True)
class Bed:
    """A bed before and after it was shaken down."""

    loose: float  # fraction as it was poured [-]
    close: float  # after the last stage [-]
    loose_height: float  # of the highest particle's top [m]
    close_height: float
    rms_speed: float  # that is left at the end [m/s]
    cpu_s: float


def shake_down(case: DamperCase, stop: Stop = lambda: False) -> Bed:
    """Pour the particles of a case as softened gives it, shake them down and let them rest.

    Raises InputError where they do not fit, SimulationError, and Stopped where `stop` says so.
    """

    def stop_if_requested(*_progress: object) -> None:
        if stop():
            raise Stopped("the same command pours them again, from their seed")

    poured = fill(case, stop_if_requested)
    begun = time.process_time()
    sim = resting(case, poured.state["position"][:, :3])
    sim.restore(poured.state)
    down = np.append(case.settling_gravity, 0.0)
    per_cycle = math.ceil(1.0 / (FREQUENCY * case.steps.free))
    for gamma in STAGES:
        sim.begin_phase(
            shaker=sine(gamma, FREQUENCY, GRAVITY),
            gravity=down,
            time_step=1.0 / (FREQUENCY * per_cycle),
        )
        for _ in range(CYCLES):
            sim.step(per_cycle)
            stop_if_requested()
    still = at_rest()
    sim.begin_phase(shaker=still, gravity=down, time_step=case.steps.free)
    sim.step(math.ceil(_REST / case.steps.free))
    close = packed(case, sim, 0.0)
    cpu_s = poured.cpu_s + time.process_time() - begun
    return Bed(poured.fraction, close.fraction, poured.height, close.height, close.rms_speed, cpu_s)


def protocol() -> dict[str, Any]:
    """The numbers that say how it is done, other than the case."""
    return {"frequency": FREQUENCY, "stages": STAGES, "cycles": CYCLES, "rest": _REST}


def softened(name: str, changes: dict[str, Any]) -> DamperCase:
    """A case with vertical motion whose particles and walls are SOFTER, and its longer steps."""
    hard = DamperCase.load(name, {**changes, "motion.orientation": "vertical"})
    folder = (data_file("cases", name) or Path(name)).parent  # as DamperCase.load has it
    table = load_table(find(hard.settings.particles.materials, "materials", folder))
    modulus = materials_of(table, hard.settings)[0][0].youngs_modulus
    assert modulus is not None  # the case has refused that
    soft = {
        **changes,
        "motion.orientation": "vertical",
        "law.youngs_modulus": f"{modulus.value / SOFTER:.6g} Pa",
        "run.time_step": f"{_SHARE * hard.steps.rayleigh * math.sqrt(SOFTER):.3g} s",
    }
    return DamperCase.load(name, soft)
