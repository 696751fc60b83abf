"""Diagnostic figure of two blocks in contact: mesh, fields, interface, curves."""

from typing import TYPE_CHECKING, Any

import numpy as np

from calibration.statistics.quantity import plus_minus
from calibration.stiffness_fe.measure import Contact, Found
from calibration.stiffness_fe.protocol import Outcome
from calibration.stiffness_fe.result import known_sigma
from granulab.campaign.output.figure import BLUE, INK, VERMILION, headline

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SHOWN = 0.3  # of the width, where the mesh is drawn
_COLOURS = {"flat": BLUE, "rough": VERMILION}


def _contacts(found: Found) -> dict[str, Contact]:
    both = {"flat": found.flat, "rough": found.rough}
    return {name: one for name, one in both.items() if one is not None}


def draw(found: Found) -> "Figure":
    """Mesh, fields, interface and curves; of several profiles the first one is shown."""
    from matplotlib.figure import Figure

    contacts = _contacts(found)
    figure = Figure(figsize=(11.5, 8.2), layout="constrained")
    halves: Any = figure.subfigures(2, 1, height_ratios=[1.25, 1.0])
    upper, lower = halves
    widths = [1.5, *(1.0 for _ in contacts)]
    fields: Any = upper.subplots(1, len(widths), width_ratios=widths)
    _mesh(fields[0], list(contacts.values())[-1].outcomes[0])
    worst = max(_pressing(one.outcomes[0]) for one in contacts.values())
    for axes, (name, one) in zip(fields[1:], contacts.items(), strict=True):
        drawn = _field(axes, one.outcomes[0], worst)
        axes.set_title(f"{name}, friction {one.load.friction:g}")
    upper.colorbar(drawn, ax=fields[1:], label="normal stress [MPa]", extend="both")
    plots: Any = lower.subplots(1, 3)
    for name, one in contacts.items():
        _interface(plots[0], one.outcomes[0], name)
        _curves(plots[1:], one, name)
    plots[0].set(xlabel="along the interface [mm]", ylabel="pressure [MPa]")
    plots[1].set(xlabel="travel across [mm]", ylabel="mean normal stress [MPa]")
    plots[2].set(xlabel="travel along [mm]", ylabel="mean shear stress [MPa]")
    plots[0].legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)  # peaks are anywhere
    for axes in plots[1:]:
        axes.legend(loc="upper left")
    words = ", ".join(
        f"{name} {plus_minus(one.ratio.whole.value, known_sigma(one.ratio))}"
        for name, one in contacts.items()
    )
    headline(figure, f"kt/kn by eq. 3.3: {words}".replace("+-", "±"))
    return figure


def _mesh(axes: "Axes", outcome: Outcome) -> None:
    """The elements about a part of the interface, before the load."""
    from matplotlib.collections import LineCollection

    for block in (outcome.stack.upper, outcome.stack.lower):
        mesh = block.basis.mesh
        lines = 1e3 * mesh.p[:, mesh.facets].transpose(2, 1, 0)
        axes.add_collection(LineCollection(list(lines), colors=INK, linewidths=0.3))
    x, z = 1e3 * outcome.stack.lower.points.T
    half = _SHOWN * np.ptp(x) / 2
    axes.set_xlim(x[0], x[0] + 2 * half)
    axes.set_ylim(z.mean() - half, z.mean() + half)
    axes.set_aspect("equal")
    axes.set(title="mesh by the interface", xlabel="x [mm]", ylabel="y [mm]")


def _pressing(outcome: Outcome) -> float:
    """Three times the mean normal stress [MPa]: what the fields' colours reach to."""
    return 3e-6 * float(outcome.force[-1, 1] / np.ptp(outcome.stack.lower.points[:, 0]))


def _field(axes: "Axes", outcome: Outcome, reach: float) -> Any:
    """sigma_yy where the blocks are at the end, displacements as they are."""
    stack, state = outcome.stack, outcome.state
    draw: Any = axes.tripcolor
    for block, forces, shift in (
        (stack.upper, state.upper, state.platen), (stack.lower, state.lower, np.zeros(2)),
    ):  # fmt: skip
        moved = block.displacements(forces)
        mesh = block.basis.mesh
        x, y = 1e3 * (mesh.p + block.by_point(moved) + shift[:, None])
        corners = np.concatenate([mesh.t[[0, 1, 2]], mesh.t[[0, 2, 3]]], axis=1).T
        drawn = draw(
            x, y, corners, 1e-6 * block.stress(moved)[1], shading="gouraud", cmap="RdBu",
            vmin=-reach, vmax=reach, rasterized=True,
        )  # fmt: skip
    axes.set_aspect("equal")
    axes.set_xlabel("x [mm]")
    return drawn


def _interface(axes: "Axes", outcome: Outcome, name: str) -> None:
    """Pressure, and friction below zero, on the upper surface's points."""
    x = outcome.stack.upper.points[:, 0]
    per = np.diff(x).mean()
    pressure, friction = 1e-6 * outcome.state.contact / per
    free = outcome.stack.upper.sides == "free"
    ends = np.ones(len(x))
    ends[[0, -1]] = 2.0 if free else 1.0  # an end carries half a column
    axes.plot(1e3 * x, ends * pressure, color=_COLOURS[name], lw=1, label=f"{name}, pressure")
    axes.plot(
        1e3 * x, ends * friction, color=_COLOURS[name], lw=0.8, ls=(0, (3, 2)),
        label=f"{name}, friction",
    )  # fmt: skip


def _curves(axes: Any, contact: Contact, name: str) -> None:
    """Mean stresses against the platens' travel; thin lines for further profiles."""
    for k, one in enumerate(contact.outcomes):
        width = np.ptp(one.stack.lower.points[:, 0])
        look: dict[str, Any] = {
            "color": _COLOURS[name], "lw": 1.5 if k == 0 else 0.5,
            "label": name if k == 0 else None,
        }  # fmt: skip
        across, along = slice(0, one.pressed + 1), slice(one.pressed, None)
        if one.pressed == len(one.platen) - 1:  # sheared while pressed
            along = slice(0, None)
        axes[0].plot(1e3 * one.platen[across, 1], 1e-6 * one.force[across, 1] / width, **look)
        axes[1].plot(1e3 * one.platen[along, 0], 1e-6 * one.force[along, 0] / width, **look)
