"""Granular dampers: particles in a shaken enclosure, and the energy that they dissipate."""

from typing import TYPE_CHECKING

from granulab.lazy import public

if TYPE_CHECKING:
    from damper3d.case.case import DamperCase
    from damper3d.engine.enclosures import Enclosure
    from damper3d.engine.enclosures import register as register_enclosure
    from damper3d.engine.motions import register as register_motion
    from damper3d.measures import draw, observe
    from damper3d.measures import register as register_measure
    from damper3d.run.protocol import run
    from damper3d.run.result import Result
    from damper3d.run.sweep import sweep
    from damper3d.shapes import register as register_shape
    from damper3d.studies.map.grid import Grid, MapResult, efficiency_map
    from damper3d.studies.predict.prediction import predict

__all__ = [
    "DamperCase",
    "Enclosure",
    "Grid",
    "MapResult",
    "Result",
    "draw",
    "efficiency_map",
    "observe",
    "predict",
    "register_enclosure",
    "register_measure",
    "register_motion",
    "register_shape",
    "run",
    "sweep",
]

__getattr__, __dir__ = public(__name__, {
    "DamperCase": "case.case",
    "Enclosure": "engine.enclosures",
    "Grid": "studies.map.grid",
    "MapResult": "studies.map.grid",
    "Result": "run.result",
    "draw": "measures",
    "efficiency_map": "studies.map.grid",
    "observe": "measures",
    "predict": "studies.predict.prediction",
    "register_enclosure": "engine.enclosures:register",
    "register_measure": "measures:register",
    "register_motion": "engine.motions:register",
    "register_shape": "shapes:register",
    "run": "run.protocol",
    "sweep": "run.sweep",
})  # fmt: skip
