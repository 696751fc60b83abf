"""Force against displacement of a 3 mm steel sphere: the law as it is coded, and theory (Fig. 5.4).

The thesis names sphere, steel and friction (Table 5.1) but not the displacements of its figure:
here 3 um of overlap, a thousandth of the diameter, and 1.8 um across.
"""

import math
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from damper3d.studies.single_contact import Found
from granulab.campaign.output.figure import BLUE, GREY, INK, VERMILION, headline
from granulab.contact.files.table import load_table
from granulab.contact.hertz import HertzLaw, hertz_force, mindlin_force
from granulab.contact.mindlin_deresiewicz import (
    N_SPRINGS,
    loading_force,
    partial_slip_force,
    turned_force,
)
from granulab.contact.reduced import shear_modulus
from granulab.contact.sphere_law import sphere_law

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

RADIUS, OVERLAP, ACROSS = 1.5e-3, 3e-6, 1.8e-6  # [m]
_POINTS = 121
_NORMAL = 0.0, 0.0, 1.0
_REDUCED = {"particle-surface": RADIUS, "particle-particle": RADIUS / 2}  # [m]


def compute() -> Found:
    """Loading in both directions, and a loop of the tangential displacement."""
    table = load_table("steel")
    steel = table.material("steel")
    friction = table.pair("steel", "steel").friction.value
    law = sphere_law(steel, steel, friction=friction, restitution=1.0)
    rows: list[dict[str, Any]] = []
    numbers: dict[str, Any] = {"radius_m": RADIUS, "overlap_m": OVERLAP, "friction": law.mu}
    for kind, radius in _REDUCED.items():
        rows += [
            {
                "contact": kind, "direction": "normal", "displacement_m": float(overlap),
                "law_n": _held(law, radius, overlap)[2],
                "theory_n": law.hertz * math.sqrt(radius) * float(overlap) ** 1.5,
            }
            for overlap in np.linspace(0, OVERLAP, _POINTS)
        ]  # fmt: skip
        rows += _tangential(law, radius, kind, "tangential", np.linspace(0, ACROSS, _POINTS))
        top, bottom = 0.75 * slides_at(law, radius), -0.4 * slides_at(law, radius)
        extremes = [0.0, top, bottom, top]
        path = np.concatenate([np.linspace(a, b, 81)[1:] for a, b in pairwise(extremes)])
        rows += _tangential(law, radius, kind, "loop", np.concatenate([[0.0], path]))
        numbers[kind] = _numbers(law, radius, rows, kind)
    modulus = steel.youngs_modulus.value if steel.youngs_modulus else 0.0
    poisson = steel.poisson.value if steel.poisson else 0.0
    numbers["normal_unit_n"] = 1e3 * modulus * math.pi * RADIUS * OVERLAP
    numbers["tangential_unit_n"] = 1e3 * shear_modulus(modulus, poisson) * math.pi * RADIUS * ACROSS
    return Found(
        numbers, rows, ("forces are divided by 10^3 E pi r d_max (eq. 5.17) in the figure",)
    )


def slides_at(law: HertzLaw, radius: float) -> float:
    """Displacement [m] at which the exact law slides: 3 mu N/(2 kt)."""
    stiffness, _, force = _held(law, radius, OVERLAP)
    return 1.5 * law.mu * force / (law.tangential * stiffness)


def _held(law: HertzLaw, radius: float, overlap: float) -> tuple[float, float, float]:
    """(secant stiffness [N/m], dashpot [kg/s], force [N]) of a contact whose overlap rests."""
    return hertz_force(law, law.hertz * math.sqrt(radius), 1.0, law.damping, float(overlap), 0.0)[
        :3
    ]


def _tangential(
    law: HertzLaw, radius: float, kind: str, direction: str, path: np.ndarray
) -> list[dict[str, Any]]:
    """Both laws along a path of displacements, and the closed curves of the exact one."""
    stiffness, dashpot, force = _held(law, radius, OVERLAP)
    area = math.sqrt(radius * OVERLAP)
    springs, held = np.zeros((N_SPRINGS, 3)), (0.0, 0.0, 0.0)
    rest, last = (0.0, 0.0, 0.0), 0.0
    theory = _closed_curve(law.tangential * stiffness, law.mu * force, path)
    rows = []
    for displacement, closed in zip(path, theory, strict=True):
        step = (float(displacement - last), 0.0, 0.0)
        trial = (held[0] + step[0], 0.0, 0.0)
        simple, held, *_ = mindlin_force(law, stiffness, dashpot, force, trial, rest)
        exact, *_ = partial_slip_force(
            law, stiffness, dashpot, force, _NORMAL, OVERLAP, area, springs, area, step, rest
        )
        springs[:, 0] -= step[0]  # it adds the first half of a next step, which is not the same
        last = displacement
        rows.append(
            {
                "contact": kind, "direction": direction, "displacement_m": float(displacement),
                "law_n": -simple[0], "exact_n": -exact[0], "theory_n": float(closed),
            }
        )  # fmt: skip
    return rows


def _closed_curve(kt: float, limit: float, path: np.ndarray) -> np.ndarray:
    """Mindlin and Deresiewicz's curves along a path that reverses at its extremes."""
    ways = np.sign(np.diff(path))
    extremes = [0, *(np.flatnonzero(ways[1:] != ways[:-1]) + 1), len(path) - 1]
    forces = np.zeros(len(path))
    for n, (begin, end) in enumerate(pairwise(extremes)):
        leg = path[begin : end + 1]
        if n == 0:
            forces[begin : end + 1] = loading_force(kt, limit, leg)
        else:
            forces[begin : end + 1] = turned_force(kt, limit, leg, leg[0], forces[begin])
    return forces


def _numbers(law: HertzLaw, radius: float, rows: list[dict[str, Any]], kind: str) -> dict[str, Any]:
    stiffness, _, force = _held(law, radius, OVERLAP)
    kt, limit = law.tangential * stiffness, law.mu * force
    mine = [row for row in rows if row["contact"] == kind and row["direction"] == "tangential"]
    over = max(row["law_n"] - row["exact_n"] for row in mine)
    return {
        "normal_force_n": force,
        "coulomb_limit_n": limit,
        "tangential_over_normal_stiffness": kt / (1.5 * stiffness),
        "simplified_slides_at_m": limit / kt,
        "exact_slides_at_m": slides_at(law, radius),
        "largest_overestimate_of_limit": over / limit,
    }


def draw(found: Found) -> "Figure":
    """Normal, tangential, and the tangential loop."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12.5, 4.4), layout="constrained")
    normal, tangential, loop = figure.subplots(1, 3)
    for kind, colour in (("particle-surface", BLUE), ("particle-particle", VERMILION)):
        for axes, direction in ((normal, "normal"), (tangential, "tangential")):
            _curves(axes, found, kind, direction, colour)
    _curves(loop, found, "particle-surface", "loop", BLUE)
    normal.set(
        xlabel="overlap / diameter [-]", ylabel="normal force / (10\u00b3 E \u03c0 r d_max) [-]"
    )
    for axes in (tangential, loop):
        axes.set(
            xlabel="tangential displacement / diameter [-]",
            ylabel="tangential force / (10\u00b3 G \u03c0 r s_max) [-]",
        )
    normal.set_title("loading, normal", fontsize=9, loc="left")
    tangential.set_title(
        f"loading, tangential, overlap {1e6 * OVERLAP:g} um", fontsize=9, loc="left"
    )
    loop.set_title("forth, back and forth again, particle-surface", fontsize=9, loc="left")
    normal.plot([], [], color=GREY, label="theory: Hertz; exact Mindlin-Deresiewicz")
    normal.plot([], [], "o", ms=4, mfc="none", color=GREY, label="the engine's law")
    normal.plot([], [], "+", color=GREY, label="the exact law as coded")
    for axes in (normal, tangential, loop):
        axes.ticklabel_format(axis="x", style="sci", scilimits=(0, 0))
    figure.legend(*normal.get_legend_handles_labels(), loc="outside lower center", ncols=5)
    loop.axhline(0, color=INK, lw=0.5)
    headline(figure, "Steel sphere of 3 mm: force against displacement")
    return figure


def _curves(axes: "Axes", found: Found, kind: str, direction: str, colour: str) -> None:
    rows = [r for r in found.rows if r["contact"] == kind and r["direction"] == direction]
    unit = found.numbers["normal_unit_n" if direction == "normal" else "tangential_unit_n"]
    x = np.array([row["displacement_m"] for row in rows]) / (2 * RADIUS)
    every = slice(None, None, 6)
    axes.plot(x, [row["theory_n"] / unit for row in rows], color=colour,
              label=kind if direction != "loop" else None)  # fmt: skip
    axes.plot(x[every], [row["law_n"] / unit for row in rows][every], "o", ms=4, mfc="none",
              color=colour)  # fmt: skip
    if direction != "normal":
        axes.plot(x[every], [row["exact_n"] / unit for row in rows][every], "+", color=colour)
