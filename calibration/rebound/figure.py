"""The diagnostic figure of a rebound: motion, residuals, energies, the particle at its contacts."""

from typing import TYPE_CHECKING

import numpy as np

from calibration.rebound.contact import Contact
from calibration.rebound.result import Rebound
from calibration.statistics.quantity import plus_minus
from calibration.tracking.film.reader import Picture, open_film
from granulab.campaign.output.figure import (
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    VERMILION,
    headline,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SHOWN = 3  # contacts of which the film is shown
_AROUND = 1.8  # largest radii of the particle that a picture shows to either side
_SIDES = (("x", BLUE), ("y", GREEN), ("angle", VERMILION))


def draw_figure(found: Rebound) -> "Figure":
    """Position and angle with their fits, residuals, energies, and pictures of the contacts."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 10.5), layout="constrained")
    grid = figure.add_gridspec(3, 6, height_ratios=[1.7, 1, 2.2])
    axes = figure.add_subplot(grid[0, :3])
    _positions(axes, found)
    _angles(figure.add_subplot(grid[0, 3:], sharex=axes), found)
    for c in range(3):
        _residuals(figure.add_subplot(grid[1, 2 * c : 2 * c + 2], sharex=axes), found, c)
    shown = found.contacts[:_SHOWN]
    pictures = _pictures(found, shown)
    row = grid[2, :].subgridspec(1, len(shown) + 1)
    for k, one in enumerate(shown):
        _contact(figure.add_subplot(row[0, k]), found, one, pictures.get(k))
    _energies(figure.add_subplot(row[0, len(shown)]), found)
    e = found.pooled
    words = f"{found.path.stem}: restitution at the point of contact {plus_minus(e.value, e.sigma)}"
    first = found.contacts[0].values["restitution_centroid"]
    words += f"; ratio of the centroid's velocities {plus_minus(first.value, first.sigma)}"
    headline(figure, words)
    return figure


def _of_flights(found: Rebound, c: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Times and fitted values of channel c on each flight, from contact to contact."""
    fitted = found.known.fitted
    times = fitted.layout.times(fitted.parameters)
    ends = [found.clock[fitted.rows[0][0]], *times, found.clock[fitted.rows[-1][-1]]]
    lines = []
    for k in range(fitted.layout.m):
        t = np.linspace(ends[k], ends[k + 1], 60)
        lines.append((t, fitted.layout.at(fitted.parameters, c, k, t)))
    return lines


def _positions(axes: "Axes", found: Rebound) -> None:
    t = found.clock
    for values, colour, c in ((found.track.x, BLUE, 0), (-found.track.y, GREEN, 1)):
        axes.plot(t, values, ".", color=colour, ms=3, label=("x", "y, upwards")[c])
        for line in _of_flights(found, c):
            axes.plot(*line, color=INK, lw=0.8)
    _marks(axes, found)
    axes.set_ylabel("centroid [px]")
    axes.set_xlabel("time [frames]")
    axes.legend(loc="best")


def _angles(axes: "Axes", found: Rebound) -> None:
    t, angle = found.clock, np.degrees(-found.seen.angle)
    axes.errorbar(t, angle, np.degrees(found.seen.sigma), fmt=".", color=VERMILION, ms=3, lw=0.6)
    for line in _of_flights(found, 2):
        axes.plot(line[0], np.degrees(line[1]), color=INK, lw=0.8)
    _marks(axes, found)
    seen = angle[np.isfinite(angle)]
    axes.set_ylim(seen.min() - 0.05 * np.ptp(seen) - 1, seen.max() + 0.05 * np.ptp(seen) + 1)
    axes.set_ylabel("angle, counter-clockwise [degrees]")
    axes.set_xlabel("time [frames]")


def _marks(axes: "Axes", found: Rebound) -> None:
    for one in found.contacts:
        axes.axvline(one.frame, color=GREY, lw=0.6, ls=(0, (3, 3)))


def _residuals(axes: "Axes", found: Rebound, c: int) -> None:
    name, colour = _SIDES[c]
    values = found.known.fitted.residuals[c]
    unit = "px"
    if c == 2:
        values, unit = np.degrees(values), "degrees"
    axes.axhline(0, color=GREY, lw=0.6)
    axes.plot(found.clock, values, ".", color=colour, ms=3)
    _marks(axes, found)
    axes.set_ylabel(f"residual of {name} [{unit}]")
    axes.set_xlabel("time [frames]")


def _pictures(found: Rebound, shown: list[Contact]) -> dict[int, Picture]:
    """Frame of the film nearest to each contact."""
    film = open_film(found.path)
    number = {round(found.frame(one)): k for k, one in enumerate(shown)}
    return {number[one.number]: one.picture for one in film.some(number)}


def _contact(axes: "Axes", found: Rebound, one: Contact, picture: Picture | None) -> None:
    """The film, the outline found in it, plate, centroid and point of contact."""
    fitted, plane = found.known.fitted, found.known.plane.value
    j = found.contacts.index(one)
    at = fitted.layout.times(fitted.parameters)[j : j + 1]
    x, y = (float(fitted.layout.at(fitted.parameters, c, j, at)[0]) for c in (0, 1))
    c, s = np.cos(one.angle), np.sin(one.angle)
    points = found.known.outline @ np.array([[c, s], [-s, c]])
    reach = _AROUND * float(np.hypot(*points.T).max())
    if picture is not None:
        axes.imshow(picture[:, :, ::-1])
    closed = np.concatenate([points, points[:1]])
    axes.plot(x + closed[:, 0], -(y + closed[:, 1]), color=VERMILION, lw=1)
    t, n = one.values["arm_t"].value, one.values["arm_n"].value
    tangent, normal = (
        np.array([np.cos(plane), np.sin(plane)]),
        np.array([-np.sin(plane), np.cos(plane)]),
    )
    point = np.array([x, y]) + t * tangent + n * normal
    ends = np.stack([point - reach * tangent, point + reach * tangent])
    axes.plot(ends[:, 0], -ends[:, 1], color=ORANGE, lw=1)
    axes.plot([x, point[0]], [-y, -point[1]], "-", color=INK, lw=1)
    axes.plot([x], [-y], "+", color=INK)
    axes.plot([point[0]], [-point[1]], "o", color=ORANGE, ms=4)
    axes.set_xlim(x - reach, x + reach)
    axes.set_ylim(-y + reach, -y - reach)
    axes.set_aspect("equal")
    e = one.values["restitution"]
    axes.set_title(
        f"contact at frame {found.frame(one):.1f}: {plus_minus(e.value, e.sigma)}", fontsize=9
    )
    axes.set_xlabel("x [px]")
    axes.set_ylabel("y [px]")


def _energies(axes: "Axes", found: Rebound) -> None:
    """Shares of the energy before each contact, before and after it."""
    labels = []
    for k, one in enumerate(found.contacts):
        for i, when in enumerate(("before", "after")):
            low = 0.0
            for part, colour in (
                ("normal", GREEN),
                ("tangential", BLUE),
                ("rotational", VERMILION),
            ):
                share = one.values[f"{part}_{when}"].value
                name = f"{part} motion" if part != "rotational" else "rotation"
                label = name if k == i == 0 else None
                axes.bar(2 * k + i, share, 0.7, bottom=low, color=colour, label=label)
                low += share
            labels.append(f"{when}\n{found.frame(one):.0f}")
    axes.set_xticks(range(len(labels)), labels)
    axes.set_ylabel("share of the kinetic energy before")
    axes.legend(loc="upper right")
