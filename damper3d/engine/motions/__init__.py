"""Motions of the enclosure along its direction, one file each, and their registry.

A new motion is a file like sines.py, and one call of `register`: below for one of this package, or
in any file that is imported before the case is read. A case then names its kind in [motion].
"""

from damper3d.engine.motions import crossed, host, sines, table, turning
from damper3d.engine.motions.crossed import Crossed
from damper3d.engine.motions.registry import (
    MOTIONS,
    Motion,
    compile_for,
    displacement,
    register,
    velocity,
)
from damper3d.engine.motions.sines import Sines, at_rest, sine
from damper3d.engine.motions.table import Table
from damper3d.engine.motions.turning import Turning

__all__ = [
    "MOTIONS",
    "Crossed",
    "Motion",
    "Sines",
    "Table",
    "Turning",
    "at_rest",
    "displacement",
    "register",
    "sine",
    "velocity",
]

register("sines", Sines, sines.displacement, sines.velocity, sine)
compile_for(table.Table, table.displacement, table.velocity)
compile_for(turning.Turning, turning.displacement, turning.velocity)
compile_for(crossed.Crossed, crossed.displacement, crossed.velocity)
compile_for(host.Host, host.displacement, host.velocity)
