"""The properties that the sensitivity table changes, and to what.

The thesis draws its curves (Fig. 6.13) and says that sec. 8.5.1.3 makes the same changes; it prints
no value. All but the standard (Table 6.2; restitution 0.86, friction 0.52) are our choice.
"""

import math
from typing import Any

FREQUENCY = 20.0  # [Hz]
# Of Table 6.1 up to 40, with more about the optimum, which Table 6.3 puts at 5.2.
GAMMAS = (1.0, 1.5, 2.0, 3.0, 4.0, 4.5, 5.0, 5.5, 6.0, 6.5, 7.0, 8.0, 10.0, 12.0, 15.0, 20.0, 30.0,
          40.0)  # fmt: skip
STANDARD = {"density": 1190.0, "modulus": 3.3e9, "restitution": 0.86, "friction": 0.52}
VALUES = {
    "density": (595.0, 2380.0, 4760.0),  # [kg/m3]
    "modulus": (0.33e9, 1.1e9, 10e9, 33e9),  # [Pa] of particles and walls
    "restitution": (0.6, 0.75, 0.95),  # of all contacts
    "friction": (0.1, 0.3, 0.8),  # of all contacts
}
_KEYS = {
    "density": "law.density",
    "modulus": "law.youngs_modulus",
    "restitution": "law.restitution",
    "friction": "law.friction",
}


def points() -> list[dict[str, Any]]:
    """The labels of each point; the standard has no property, and its value is 1."""
    return [
        {"property": name, "value": value, "gamma": gamma}
        for name, values in {"standard": (1.0,), **VALUES}.items()
        for value in values
        for gamma in GAMMAS
    ]


def in_words(name: str, value: float) -> str:
    """A value with its unit."""
    if name == "density":
        return f"{value:g} kg/m3"
    return f"{value / 1e9:g} GPa" if name == "modulus" else f"{value:g}"


def span(name: str, value: float) -> float:
    """A value on the scale on which its trend is taken."""
    return math.log(value) if name in ("density", "modulus") else value


def change(name: str, value: float) -> dict[str, Any]:
    """Return what DamperCase.load takes for a value; nothing for the standard."""
    if name not in _KEYS:
        return {}
    with_unit = name in ("density", "modulus")
    return {_KEYS[name]: in_words(name, value) if with_unit else value}
