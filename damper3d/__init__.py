"""Granular dampers: particles in a shaken enclosure, and the energy that they dissipate."""

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from damper3d.case.case import DamperCase
    from damper3d.run.protocol import run
    from damper3d.run.result import Result

__all__ = ["DamperCase", "Result", "run"]


def __getattr__(name: str):
    # Imported when first asked for: --help must answer without numba.
    homes = {"DamperCase": "case.case", "Result": "run.result", "run": "run.protocol"}
    if name not in homes:
        raise AttributeError(f"module 'damper3d' has no attribute {name!r}")
    return getattr(importlib.import_module(f"damper3d.{homes[name]}"), name)
