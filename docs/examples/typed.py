"""A silo and a damper from Python, typed: `mypy --strict docs/examples/typed.py`."""

from damper3d import DamperCase
from damper3d import run as shake
from silo2d import SiloCase, run


def discharge_time(outlet: str) -> float | None:
    """Time [s] in which silo A4 empties through another outlet; None where it does not."""
    result = run(SiloCase.load("A4", {"silo.outlet": outlet}))
    return result.discharge_time_s


def efficiency(gamma: float) -> float | None:
    """Efficiency of the thesis's damper at 40 Hz; None where nothing is counted."""
    found = shake(DamperCase.load("thesis", {"motion.gamma": gamma}))
    return found.efficiency


if __name__ == "__main__":
    print(discharge_time("120 mm"), efficiency(20.0))
