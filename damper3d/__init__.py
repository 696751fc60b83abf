"""Granular dampers: particles in a shaken enclosure, and the energy that they dissipate."""

import importlib
from typing import TYPE_CHECKING

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

_HOMES = {
    "DamperCase": ("case.case", "DamperCase"),
    "Enclosure": ("engine.enclosures", "Enclosure"),
    "Result": ("run.result", "Result"),
    "register_enclosure": ("engine.enclosures", "register"),
    "register_measure": ("measures", "register"),
    "register_motion": ("engine.motions", "register"),
    "register_shape": ("shapes", "register"),
    "run": ("run.protocol", "run"),
}


def __getattr__(name: str):
    # Imported on first use: --help must print without numba.
    if name not in _HOMES:
        raise AttributeError(f"module 'damper3d' has no attribute {name!r}")
    module, inside = _HOMES[name]
    return getattr(importlib.import_module(f"damper3d.{module}"), inside)
