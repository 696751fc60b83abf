"""Motions of the enclosure along its direction, one file each, and their registry.

A new motion is a file like sines.py, and one call of `register`: below for one of this package, or
in any file that is imported before the case is read. A case then names its kind in [motion].
"""

from damper3d.engine.motions import host, sines
from damper3d.engine.motions.registry import (
    MOTIONS,
    Motion,
    compile_for,
    displacement,
    register,
    velocity,
)
from damper3d.engine.motions.sines import Sines, at_rest, sine

__all__ = ["MOTIONS", "Motion", "Sines", "at_rest", "displacement", "register", "sine", "velocity"]

register("sines", Sines, sines.displacement, sines.velocity, sine)
compile_for(host.Host, host.displacement, host.velocity)
