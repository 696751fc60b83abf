"""Discharge of angular particles from 2D silos: spheropolygons with the multi-contact law."""

from typing import TYPE_CHECKING

from granulab.lazy import public

if TYPE_CHECKING:
    from silo2d.case.case import SiloCase
    from silo2d.engine.pair_law import register_law
    from silo2d.measures import draw, observe
    from silo2d.measures import register as register_measure
    from silo2d.run.protocol import run
    from silo2d.run.result import Result
    from silo2d.run.sweep import sweep

__all__ = [
    "Result",
    "SiloCase",
    "draw",
    "observe",
    "register_law",
    "register_measure",
    "run",
    "sweep",
]

__getattr__, __dir__ = public(__name__, {
    "Result": "run.result",
    "SiloCase": "case.case",
    "draw": "measures",
    "observe": "measures",
    "register_law": "engine.pair_law",
    "register_measure": "measures:register",
    "run": "run.protocol",
    "sweep": "run.sweep",
})  # fmt: skip
