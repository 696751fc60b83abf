"""Discharge of angular particles from 2D silos: spheropolygons with the multi-contact law."""

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from silo2d.case.case import SiloCase
    from silo2d.run.protocol import run
    from silo2d.run.result import Result

__all__ = ["Result", "SiloCase", "run"]


def __getattr__(name: str):
    # Imported when first asked for: --help must answer without numba.
    homes = {"Result": "run.result", "SiloCase": "case.case", "run": "run.protocol"}
    if name not in homes:
        raise AttributeError(f"module 'silo2d' has no attribute {name!r}")
    return getattr(importlib.import_module(f"silo2d.{homes[name]}"), name)
