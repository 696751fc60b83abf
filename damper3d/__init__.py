"""Granular dampers: particles in a shaken enclosure, and the energy that they dissipate."""

from typing import TYPE_CHECKING

from granulab.lazy import public

if TYPE_CHECKING:
    from damper3d.case.case import DamperCase
    from damper3d.engine.enclosures import Enclosure
    from damper3d.engine.enclosures import register as register_enclosure
    from damper3d.engine.motions import register as register_motion
    from damper3d.measures import register as register_measure
    from damper3d.run.protocol import run
    from damper3d.run.result import Result
    from damper3d.shapes import register as register_shape

__all__ = [
    "DamperCase",
    "Enclosure",
    "Result",
    "register_enclosure",
    "register_measure",
    "register_motion",
    "register_shape",
    "run",
]

__getattr__, __dir__ = public(__name__, {
    "DamperCase": "case.case",
    "Enclosure": "engine.enclosures",
    "Result": "run.result",
    "register_enclosure": "engine.enclosures:register",
    "register_measure": "measures:register",
    "register_motion": "engine.motions:register",
    "register_shape": "shapes:register",
    "run": "run.protocol",
})  # fmt: skip
