"""Granular dampers: particles in a shaken enclosure, and the energy that they dissipate."""

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from damper3d.case.case import DamperCase
    from damper3d.measures import register as register_measure
    from damper3d.run.protocol import run
    from damper3d.run.result import Result
    from damper3d.shapes import register as register_shape

__all__ = ["DamperCase", "Result", "register_measure", "register_shape", "run"]


def __getattr__(name: str):
    # Imported when first asked for: --help must answer without numba.
    homes = {
        "DamperCase": ("case.case", "DamperCase"),
        "Result": ("run.result", "Result"),
        "register_measure": ("measures", "register"),
        "register_shape": ("shapes", "register"),
        "run": ("run.protocol", "run"),
    }
    if name not in homes:
        raise AttributeError(f"module 'damper3d' has no attribute {name!r}")
    module, inside = homes[name]
    return getattr(importlib.import_module(f"damper3d.{module}"), inside)
