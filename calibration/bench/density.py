"""Density by weighing: mass over volume (paper sec. 3.5)."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from calibration.bench.measure import Quantity, measure
from calibration.bench.sections import Columns, Input, Request, need, rows
from calibration.statistics.uncertainty import Estimate
from granulab.errors import InputError

INPUTS = (
    Input("mass", "kg", "of one particle"),
    Input("volume", "m3", "its volume,"),
    Input("area", "m2", "or the area of its cross section"),
    Input("length", "m", "and its length,"),
    Input("width", "m", "or length, width"),
    Input("height", "m", "and height,"),
    Input("diameter", "m", "or the diameter of a sphere; with a length, of a cylinder"),
)
_DENSEST = 22.6e3  # [kg/m3] osmium
# Sets of columns that give a volume, and how.
_VOLUMES = {
    ("volume",): lambda c: c["volume"],
    ("area", "length"): lambda c: c["area"] * c["length"],
    ("length", "width", "height"): lambda c: c["length"] * c["width"] * c["height"],
    ("diameter", "length"): lambda c: np.pi / 4 * c["diameter"] ** 2 * c["length"],
    ("diameter",): lambda c: np.pi / 6 * c["diameter"] ** 3,
}


def density(files: Sequence[str | Path], what: Request) -> list[Quantity]:
    """Mass over volume, one row a particle."""
    choices = [("mass", *names) for names in _VOLUMES]
    sections, remarks = rows(files, INPUTS, what, choices)
    volumes = list(_VOLUMES.values())
    chosen = {need(section, choices, INPUTS) for section in sections}
    if len(chosen) > 1:
        raise InputError("the files give volumes in several ways; measure them one by one")
    (k,) = chosen
    remarks.append(f"volume from {', '.join(choices[k][1:])}")

    def evaluate(columns: Columns) -> Estimate:
        mass, volume = float(columns["mass"][0]), float(volumes[k](columns)[0])
        if mass <= 0 or volume <= 0:
            raise InputError(
                f"mass = {1e3 * mass:g} g, volume = {1e6 * volume:g} cm3: both are above 0"
            )
        if mass > _DENSEST * volume:
            raise InputError(
                f"mass = {1e3 * mass:g} g, volume = {1e6 * volume:g} cm3: denser than any solid; "
                "check the units in the head"
            )
        return Estimate(mass / volume, None, 1)

    return [
        measure(
            sections, evaluate, what,
            key="density_kg_m3", name="density", si="kg/m3", unit="g/cm3", remarks=remarks,
        )
    ]  # fmt: skip
