"""Discharge of angular particles from 2D silos: spheropolygons with the multi-contact law."""

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from silo2d.case.case import SiloCase
    from silo2d.engine.pair_law import register_law
    from silo2d.measures import register as register_measure
    from silo2d.run.protocol import run
    from silo2d.run.result import Result

__all__ = ["Result", "SiloCase", "register_law", "register_measure", "run"]


def __getattr__(name: str):
    # Imported on first use: --help must print without numba.
    homes = {
        "Result": ("run.result", "Result"),
        "SiloCase": ("case.case", "SiloCase"),
        "register_law": ("engine.pair_law", "register_law"),
        "register_measure": ("measures", "register"),
        "run": ("run.protocol", "run"),
    }
    if name not in homes:
        raise AttributeError(f"module 'silo2d' has no attribute {name!r}")
    module, inside = homes[name]
    return getattr(importlib.import_module(f"silo2d.{module}"), inside)
