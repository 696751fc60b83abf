"""The simulators that the inverse fit knows, by name; each is imported when it is asked for."""

from calibration.inverse.kind import Simulated

NAMES = ("silo2d", "damper3d")


def simulator(name: str) -> Simulated:
    """The simulator of a name, "silo2d" or "damper3d"."""
    if name == "silo2d":
        from calibration.inverse.silo import SIMULATED
    else:
        from calibration.inverse.damper import SIMULATED
    return SIMULATED
