"""The picture of loads: pressures by height, what bears the weight, and the flow chart."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from granulab.campaign.output.figure import BLUE, GREEN, GREY, INK, VERMILION, headline
from silo2d.loads.jenike import MARGIN, mass_flow_limit
from silo2d.measures import loads
from silo2d.view.loads.sheet import title
from silo2d.view.loads.tables import no_sign

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PRESETS = {"A": 30, "B": 45, "C": 60, "D": 90}  # half angles of the wood silos [deg]


def draw(found: Mapping[str, Any], head: bool = True) -> "Figure":
    """Pressures on the walls and the chart of Jenike; for runs also friction and the balance.

    head: whether it says what it shows.
    """
    from matplotlib.figure import Figure

    runs = "dem" in found
    figure = Figure(figsize=(12.5, 4.3), layout="constrained")
    if head:
        headline(figure, title(found))
    panels = figure.subplots(1, 4 if runs else 3)
    _pressures(panels[0], found)
    if runs:
        _friction(panels[1], found)
        loads.draw_balance(panels[2], found["dem"]["stages"])
    else:
        _bottom(panels[1], found["closed_forms"])
    _chart(panels[-1], found)
    return figure


def _pressures(axes: "Axes", found: Mapping[str, Any]) -> None:
    """Horizontal pressure on the walls by height (runs) or depth."""
    walls, runs = found["closed_forms"]["walls"], "dem" in found
    unit = 1.0 if runs else 1e-3
    place = found["fill_m"] - np.array(walls["depth_m"]) if runs else np.array(walls["depth_m"])
    for key, colour, style, words in (
        ("janssen_horizontal_pa", GREY, "-", "Janssen, means"),
        ("filling_horizontal_pa", INK, "--", "EN 1991-4, filling"),
        ("discharge_horizontal_pa", INK, "-", "EN 1991-4, discharge"),
    ):
        axes.plot(unit * np.array(walls[key]), place, style, color=colour, label=words)
    for name, stage in found["dem"]["stages"].items() if runs else ():
        height, value, rms = loads.profile(stage, "normal_pa")
        axes.errorbar(value, height, xerr=rms, fmt="o", ms=3, color=loads.COLOURS[name],
                      elinewidth=0.5, label=name.replace("_", " "))  # fmt: skip
    if runs:
        axes.axhline(found["foot_m"], color=GREY, lw=0.6, ls=":")
        axes.set(xlabel=f"pressure on the walls [Pa], bars: rms over {1e3 * loads.AVERAGED:g} ms",
                 ylabel="height over the outlet [m]")  # fmt: skip
        axes.set_xlim(left=-100)
    else:
        axes.invert_yaxis()
        axes.set(xlabel="horizontal pressure [kPa]", ylabel="depth below the surface [m]")
    axes.legend(fontsize=7)


def _friction(axes: "Axes", found: Mapping[str, Any]) -> None:
    """Friction on the walls by height."""
    walls = found["closed_forms"]["walls"]
    place = found["fill_m"] - np.array(walls["depth_m"])
    axes.plot(walls["filling_friction_pa"], place, "--", color=INK, label="EN 1991-4, filling")
    axes.plot(walls["discharge_friction_pa"], place, color=INK, label="EN 1991-4, discharge")
    for name, stage in found["dem"]["stages"].items():
        height, value, _ = loads.profile(stage, "shear_pa")
        axes.plot(value, height, "o-", ms=3, lw=0.7, color=loads.COLOURS[name])
    axes.set(xlabel="friction down the walls [Pa]", ylabel="height over the outlet [m]")
    axes.legend(fontsize=7, loc="upper right")  # where the walls are bare


def _bottom(axes: "Axes", forms: Mapping[str, Any]) -> None:
    """Vertical pressure and wall friction by depth; in a hopper the pressures on its walls."""
    own = forms["bottom"]
    if own["kind"] == "flat":
        walls = forms["walls"]
        axes.plot(1e-3 * np.array(walls["filling_vertical_pa"]), walls["depth_m"], color=BLUE,
                  label="vertical")  # fmt: skip
        axes.plot(1e-3 * np.array(walls["discharge_friction_pa"]), walls["depth_m"],
                  color=VERMILION, label="friction on discharge")  # fmt: skip
        axes.invert_yaxis()
        axes.set(xlabel="[kPa]", ylabel="depth below the surface [m]")
    else:
        for state, style in (("filling", "--"), ("discharge", "-")):
            for key, colour in (("normal_pa", BLUE), ("friction_pa", VERMILION)):
                axes.plot(1e-3 * np.array(own[state][key]), own[state]["height_m"], style,
                          color=colour, label=f"{key.removesuffix('_pa')}, {state}")  # fmt: skip
        axes.set(xlabel="pressure on the hopper [kPa]", ylabel="height over its apex [m]")
    axes.legend(fontsize=7)


def _chart(axes: "Axes", found: Mapping[str, Any]) -> None:
    """Limit of mass flow: half angle against wall friction, with this silo."""
    own = found["closed_forms"]["jenike"]
    delta = own["effective_friction_deg"]
    ends = {delta: "-"}
    if "dem" in found:
        limits = (found["dem"][f"effective_friction_{end}_deg"] for end in ("low", "high"))
        ends |= {angle: ":" for angle in limits if angle is not None}
    for angle, style in ends.items():
        walls = np.linspace(0, max(angle - 3, 1), 60)
        limit = np.array([
            mass_flow_limit(math.radians(angle), math.radians(w), own["plane"]) for w in walls
        ])  # fmt: skip
        axes.plot(
            np.degrees(limit), walls, style, color=GREEN, label=f"limit, delta {angle:.3g} deg"
        )
        if style == "-":
            axes.fill_betweenx(walls, 0, np.degrees(limit - MARGIN), color=GREEN, alpha=0.12, lw=0)
    friction = own["wall_friction_deg"]
    if "dem" in found and found["silo"][:1] in _PRESETS:
        for letter, half in _PRESETS.items():
            axes.plot(half, friction, "o", mfc="none", color=GREY, ms=6)
            axes.annotate(letter, (half, friction), (3, 4), textcoords="offset points", color=GREY)
    words = own["flow"]
    if "dem" in found and found["flow"]["mass_flow_index"] is not None:
        words += f"\nmass flow index {no_sign(found['flow']['mass_flow_index'], 2):.2f}"
    axes.plot(own["half_angle_deg"], friction, "o", color=VERMILION, label=words)
    axes.set(xlabel="half angle from the vertical [deg]", ylabel="angle of wall friction [deg]",
             xlim=(0, 95), ylim=(0, max(45, delta)))  # fmt: skip
    axes.set_title("shaded: mass flow after Jenike", loc="left", fontsize=8)
    axes.legend(fontsize=7, loc="upper right")
