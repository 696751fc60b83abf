"""Tangential force of steel particles on a flat wall against their smooth bodies (Figs 5.6b, 5.8b).

Particle and smooth body bear the same normal force, and are shifted without turning. The smooth
contact is an ellipse whose slip grows from its rim: T(s) is that of spheres (eq. 5.13, summed in
contact.mindlin_deresiewicz) with the ellipse's own stiffness (Deresiewicz 1957, J. Appl. Mech. 24,
623). The ring of contact of a lying toroid (Fig. 5.10b) is sheared along its line at some places
and across it at others, for which there is no such form: ring_shear has it by finite elements.
"""

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from damper3d.engine.multisphere.particles import TREATMENTS
from damper3d.shapes.multisphere import MultiSphere
from damper3d.studies.single_contact import Found
from damper3d.studies.single_contact.particles.held import combined, pressed, sheared, turn
from damper3d.studies.single_contact.particles.shape_force import COLOURS, WIDTHS
from damper3d.studies.single_contact.particles.smooth_body import Elastic, tangential_stiffness
from damper3d.studies.single_contact.particles.steel_shapes import (
    Setting,
    contact_of,
    settings,
    steel,
)
from granulab.campaign.output.figure import BLUE, GREY, INK, headline
from granulab.contact.hertz import HertzLaw
from granulab.contact.mindlin_deresiewicz import loading_force

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_STEPS = 80


class Way(NamedTuple):
    """A setting, and the way in which it is shifted: along x."""

    name: str
    figure: str  # of the thesis
    along: bool  # the long axis of the ellipse of contact
    setting: Setting
    orientation: np.ndarray


class Smooth(NamedTuple):
    """The smooth body's contact."""

    force: float  # normal [N]
    stiffness: float  # tangential, before any of it slides [N/m]
    limit: float  # mu N [N]
    slip: tuple[np.ndarray, np.ndarray] | None = None  # shifts [m] and forces [N]; None: an ellipse

    def exact(self, across: np.ndarray) -> np.ndarray:
        """Forces [N] at shifts (n,) [m], with partial slip."""
        if self.slip is not None:
            return np.interp(across, *self.slip)
        return loading_force(self.stiffness, self.limit, across)

    @property
    def furthest(self) -> float:
        """A third beyond where it slides [m]."""
        return 2.0 * self.limit / self.stiffness


def ways() -> list[Way]:
    """Ways to shear, in the thesis's order, which does not name the axis of the prolate's shift."""
    named = {setting.key: setting for setting in settings()}
    oblate, prolate, toroid = (
        named[key] for key in ("oblate on its minor axis", "prolate lying", "toroid standing")
    )
    across = combined(turn((0.0, 0.0, 1.0), 0.5 * math.pi), prolate.orientation)
    return [
        Way(oblate.key, "5.6b", True, oblate, oblate.orientation),
        Way("prolate lying, along its axis", "5.8b", True, prolate, prolate.orientation),
        Way("prolate lying, across its axis", "5.8b", False, prolate, across),
        Way("toroid standing, along its axis", "", False, toroid, toroid.orientation),
    ]


def compute() -> Found:
    """Curves of every particle, number of sub-spheres and multi-contact model."""
    material, law = steel()
    rows: list[dict[str, Any]] = []
    numbers: dict[str, Any] = {"friction": law.mu}
    for way in ways():
        contact = contact_of(way.setting.key, material)
        force = float(contact.hertz * way.setting.overlaps[-1] ** 1.5)
        stiffness = tangential_stiffness(material, contact, force, way.along)
        smooth = Smooth(force, stiffness, law.mu * force)
        found, mine = of_sub_spheres(way, material, law, smooth)
        own = {"normal_force_n": force, "smooth_stiffness_n_m": stiffness}
        numbers |= {name: own | departures for name, departures in found.items()}
        rows += mine
    remarks = (
        "most above, most below: the sub-spheres' less the smooth body's exact force over mu N",
        "forces are divided by 10^3 G pi r s_max (eq. 5.17) in the figure",
    )
    return Found(numbers, rows, remarks)


def of_sub_spheres(
    way: Way, material: Elastic, law: HertzLaw, smooth: Smooth
) -> tuple[dict[str, dict[str, float]], list[dict[str, Any]]]:
    """Departures from the smooth body, by particle and number of sub-spheres, and all curves.

    Of every number of sub-spheres and multi-contact model.
    """
    unit = 1e3 * material.shear * math.pi * way.setting.unit * smooth.furthest
    numbers: dict[str, dict[str, float]] = {}
    rows: list[dict[str, Any]] = []
    for particle in way.setting.clusters():
        own = numbers.setdefault(f"{way.name}, {len(particle.radii)}", {})
        head = {"particle": way.name, "sub_spheres": len(particle.radii)}
        for treatment in TREATMENTS:
            mine = _curve(particle, way, law, treatment, smooth)
            own |= _departures(mine, treatment, smooth)
            rows += [
                {**head, "treatment": treatment, **row, "tangential_unit_n": unit} for row in mine
            ]
    return numbers, rows


def shifts(smooth: Smooth) -> np.ndarray:
    """Shifts of a curve (n,) [m]: the middles of equal steps."""
    return smooth.furthest / _STEPS * (np.arange(_STEPS) + 0.5)


def _curve(
    particle: MultiSphere, way: Way, law: HertzLaw, treatment: str, smooth: Smooth
) -> list[dict[str, float]]:
    """Forces of sub-spheres and smooth body, under the same normal force."""
    overlap = overlap_under(particle, way.orientation, law, treatment, smooth.force)
    across, forces = sheared(particle, way.orientation, overlap, smooth.furthest, _STEPS, law,
                             treatment)  # fmt: skip
    exact = smooth.exact(across)
    simplified = np.minimum(smooth.stiffness * across, smooth.limit)
    keys = ("displacement_m", "force_n", "exact_n", "simplified_n")
    return [
        dict(zip(keys, map(float, values), strict=True))
        for values in zip(across, forces, exact, simplified, strict=True)
    ]


def _departures(rows: list[dict[str, float]], treatment: str, smooth: Smooth) -> dict[str, float]:
    """Stiffness over the smooth body's, and largest departures from it over mu N [-]."""
    off = [(row["force_n"] - row["exact_n"]) / smooth.limit for row in rows]
    first = rows[0]["force_n"] / rows[0]["displacement_m"]
    return {
        f"{treatment}_stiffness_over_smooth": first / smooth.stiffness,
        f"{treatment}_most_above_exact": max(off),
        f"{treatment}_most_below_exact": min(off),
    }


def overlap_under(
    particle: MultiSphere, orientation: np.ndarray, law: HertzLaw, treatment: str, force: float
) -> float:
    """The overlap [m] at which sub-spheres bear a normal force [N], to 1e-6 of it.

    One contact needs the most; between that and nothing F^(2/3) is read as straight, twice.
    """
    most = (force / (law.hertz * math.sqrt(particle.smallest_radius))) ** (2 / 3)
    low, high = 0.0, 1.001 * most
    for _ in range(3):
        overlaps = np.linspace(low, high, 41)
        forces = pressed(particle, orientation, overlaps, law, treatment)
        n = int(np.searchsorted(forces, force))
        low, high = float(overlaps[n - 1]), float(overlaps[n])
    bent = forces[n - 1 : n + 1] ** (2 / 3)
    return low + (high - low) * float((force ** (2 / 3) - bent[0]) / (bent[1] - bent[0]))


def draw(found: Found) -> "Figure":
    """A panel for each particle and way."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.5, 7.6), layout="constrained")
    for axes, way in zip(figure.subplots(2, 2).flat, ways(), strict=True):
        panel(axes, way, [row for row in found.rows if row["particle"] == way.name])
    legend(figure, axes, "fewer sub-spheres, sum", "smooth body, exact")
    headline(figure, "Steel particles shifted on a flat wall under the same normal force")
    return figure


def legend(figure: "Figure", axes: "Axes", others: str, exact: str) -> None:
    """Legend below the panels: the multi-contact models, the thin lines, and the smooth body."""
    for name, colour in COLOURS.items():
        axes.plot([], [], color=colour, lw=WIDTHS[name], label=f"sub-spheres, {name}")
    axes.plot([], [], color=BLUE, lw=0.7, label=others)
    axes.plot([], [], color=INK, ls="--", label=exact)
    axes.plot([], [], color=GREY, ls=":", label="smooth body, simplified")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3)


def panel(axes: "Axes", way: Way, rows: list[dict[str, Any]]) -> None:
    """Tangential force against shift of a particle with each of its numbers of sub-spheres."""
    numbers = list(dict.fromkeys(row["sub_spheres"] for row in rows))
    for number in numbers:
        main = number == numbers[-1]
        for name in reversed(TREATMENTS) if main else TREATMENTS[:1]:
            mine = [r for r in rows if (r["sub_spheres"], r["treatment"]) == (number, name)]
            x = 1e3 * np.array([row["displacement_m"] for row in mine]) / (2 * way.setting.unit)
            unit = mine[0]["tangential_unit_n"]
            axes.plot(x, [row["force_n"] / unit for row in mine], color=COLOURS[name],
                      lw=WIDTHS[name] if main else 0.7,
                      zorder=1.5 if name == "deepest" else 2)  # fmt: skip
    axes.plot(x, [row["exact_n"] / unit for row in mine], color=INK, ls="--")
    axes.plot(x, [row["simplified_n"] / unit for row in mine], color=GREY, ls=":")
    axes.set(xlabel="displacement / diameter [10\u207b\u00b3]",
             ylabel="force / (10\u00b3 G \u03c0 r s_max) [-]")  # fmt: skip
    axes.set_xlim(left=0)
    axes.set_ylim(bottom=0)
    axes.ticklabel_format(axis="y", style="sci", scilimits=(0, 0))
    words = f"{way.name}, {numbers[-1]}" + (f" (Fig. {way.figure})" if way.figure else "")
    axes.set_title(words, fontsize=9, loc="left")
