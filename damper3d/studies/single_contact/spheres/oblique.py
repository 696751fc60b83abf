"""Oblique impacts of an alumina sphere by each tangential law, against gross sliding.

Chung and Ooi 2011, Granular Matter 13, 643: 3.9 m/s on a wall, restitution 0.98, friction 0.092.
Beyond tan(angle) = 3.5 mu (1 + e) the sphere slides throughout and all laws agree with the closed
form; nearer to the normal the result depends on what the spring carries on.
"""

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from damper3d.studies.single_contact import Found
from damper3d.studies.single_contact.spheres.impact import Impact, Tangential, run
from granulab.campaign.output.figure import BLUE, GREEN, GREY, VERMILION, headline
from granulab.contact.files.table import load_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LAWS: dict[Tangential, tuple[str, str]] = {
    "displacement": (BLUE, "stored displacement (thesis)"),
    "force": (VERMILION, "stored force"),
    "mindlin-deresiewicz": (GREEN, "exact Mindlin-Deresiewicz"),
}
_STEPS = 4000  # a contact
_PARTS = (
    ("tangential_restitution", "tangential restitution [-]"),
    ("spin_rad_s", "angular velocity after impact [rad/s]"),
    ("contact_point_rebound_deg", "contact point leaves at [deg]"),
)


def compute() -> Found:
    """All laws from 2 to 86 degrees, and the closed form where it holds."""
    table = load_table("alumina")
    solid, pair = table.material("alumina"), table.pair("alumina", "alumina")
    mu, e = pair.friction.value, pair.restitution.value if pair.restitution else 1.0
    slides = math.degrees(math.atan(3.5 * mu * (1 + e)))
    rows: list[dict[str, Any]] = []
    for degrees in range(2, 88, 4):
        angle = math.radians(degrees)
        for law in LAWS:
            impact = Impact(solid, solid, angle=angle, friction=mu, restitution=e, tangential=law)
            outcome = run(impact, _STEPS)
            energy = 0.5 * impact.mass * impact.speed**2
            parts = {key: getattr(outcome, key) for key, _ in _PARTS}
            lost = {"dissipated_of_kinetic": outcome.dissipated_j / energy}
            rows.append({"angle_deg": degrees, "law": law, **parts, **lost})
        if degrees > slides:
            rows.append({"angle_deg": degrees, "law": "gross sliding"} | _closed(angle, mu, e))
    numbers: dict[str, Any] = {"slides_throughout_from_deg": slides}
    for row in rows:
        if row["angle_deg"] in (2, 10, 18, 26, 50):
            numbers[f"{row['angle_deg']} deg, {row['law']}"] = {k: row[k] for k, _ in _PARTS}
    return Found(numbers, rows)


def _closed(angle: float, mu: float, e: float, speed: float = 3.9, radius: float = 2.5e-3) -> dict:
    """Gross sliding: the friction impulse is mu m (1 + e) v_n."""
    v_n, v_t = speed * math.cos(angle), speed * math.sin(angle)
    lost = mu * (1 + e) * v_n
    values = (
        1 - lost / v_t,
        2.5 * lost / radius,
        math.degrees(math.atan2(v_t - 3.5 * lost, e * v_n)),
    )
    return {key: value for (key, _), value in zip(_PARTS, values, strict=True)}


def draw(found: Found) -> "Figure":
    """Tangential restitution, angular velocity and rebound angle over the angle of impact."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12.5, 4.4), layout="constrained")
    for axes, (key, label) in zip(figure.subplots(1, 3), _PARTS, strict=True):
        for law, (colour, name) in LAWS.items():
            rows = [row for row in found.rows if row["law"] == law]
            axes.plot([r["angle_deg"] for r in rows], [r[key] for r in rows], "o-", ms=3,
                      color=colour, lw=1.0, label=name)  # fmt: skip
        rows = [row for row in found.rows if row["law"] == "gross sliding"]
        axes.plot([r["angle_deg"] for r in rows], [r[key] for r in rows], color=GREY, lw=4,
                  alpha=0.4, zorder=0, label="gross sliding, closed form")  # fmt: skip
        axes.axvline(found.numbers["slides_throughout_from_deg"], color=GREY, lw=0.8, ls=":")
        axes.set(xlabel="angle of impact from the normal [deg]", ylabel=label,
                 xlim=(0, 90), xticks=np.arange(0, 91, 15))  # fmt: skip
        if key == "tangential_restitution":
            axes.set_ylim(0, 1.05)
            axes.legend(loc="lower right")
    headline(figure, "Alumina sphere of 5 mm on an alumina wall, 3.9 m/s")
    return figure
