"""Damping ratio from restitution in three ways (eqs 5.29-5.31, Fig. 5.19), and what comes out."""

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from damper3d.studies.single_contact import Found
from damper3d.studies.single_contact.spheres.impact import DampingFrom, Impact, run
from granulab.campaign.output.figure import BLUE, GREEN, GREY, VERMILION, headline
from granulab.contact.files.table import load_table
from granulab.contact.restitution import ContactEnd, ratio_of_restitution, restitution_of_ratio

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TABULATED = (0.2, 0.5, 0.7, 0.86, 0.9)  # restitutions requested
_ENDS: tuple[ContactEnd, ContactEnd] = ("overlap", "force")


def compute() -> Found:
    """The three ratios over restitution, and impacts of a Hertz contact by both ends."""
    rows: list[dict[str, Any]] = []
    for e in np.linspace(0.02, 1.0, 99):
        to_overlap, to_force = (ratio_of_restitution(float(e), end) for end in _ENDS)
        tsuji = math.sqrt(5) / 2 * to_overlap
        rows.append(
            {
                "restitution": float(e),
                "eq_5_29": to_overlap, "eq_5_30": to_force, "eq_5_31": tsuji,
                "out_5_31_to_overlap": restitution_of_ratio(to_overlap, "overlap"),
                "out_5_31_to_force": restitution_of_ratio(to_overlap, "force"),
                "out_solved_to_force": restitution_of_ratio(to_force, "force"),
            }
        )  # fmt: skip
    numbers = {f"{e:g}": _impacts(e) for e in TABULATED}
    remark = (
        "columns of each restitution requested: what an impact gives with eq. 5.31 to zero overlap "
        "and to zero force, and with the damping solved for zero force"
    )
    return Found(numbers, rows, (remark,))


def _impacts(e: float) -> dict[str, float]:
    acrylic = load_table("acrylic").material("acrylic")

    def out(end: ContactEnd, damping: DampingFrom) -> float:
        impact = Impact(acrylic, acrylic, restitution=e, end=end, damping=damping)
        return run(impact).normal_restitution

    return {
        "published_to_overlap": out("overlap", "published"),
        "published_to_force": out("force", "published"),
        "solved_to_force": out("force", "restitution"),
        "ratio_eq_5_29": ratio_of_restitution(e, "overlap"),
        "ratio_eq_5_30": ratio_of_restitution(e, "force"),
        "ratio_eq_5_31": math.sqrt(5) / 2 * ratio_of_restitution(e, "overlap"),
    }


def draw(found: Found) -> "Figure":
    """Damping ratio, and restitution out against in."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 4.4), layout="constrained")
    ratio, out = figure.subplots(1, 2)
    requested = [row["restitution"] for row in found.rows]
    for key, label, colour in (
        ("eq_5_29", "linear, to zero overlap (5.29)", BLUE),
        ("eq_5_30", "linear, to zero force (5.30)", VERMILION),
        ("eq_5_31", "Tsuji, to zero overlap (5.31)", GREEN),
    ):
        ratio.plot(requested, [row[key] for row in found.rows], color=colour, label=label)
    ratio.set(xlabel="restitution [-]", ylabel="damping ratio [-]", xlim=(0, 1), ylim=(0, 1.6))
    ratio.legend()
    for key, label, colour in (
        ("out_5_31_to_overlap", "5.29 or 5.31, to zero overlap", BLUE),
        ("out_5_31_to_force", "5.29 or 5.31, to zero force", VERMILION),
    ):
        out.plot(requested, [row[key] for row in found.rows], color=colour, label=label)
    points = [float(e) for e in found.numbers]
    for key, colour, marker, size in (
        ("published_to_overlap", BLUE, "o", 6), ("published_to_force", VERMILION, "o", 6),
        ("solved_to_force", GREEN, "+", 9),
    ):  # fmt: skip
        label = "solved for zero force" if key == "solved_to_force" else ""
        out.plot(points, [n[key] for n in found.numbers.values()], marker, color=colour, ms=size,
                 mfc="none", ls="none", label=label or "_")  # fmt: skip
    out.plot([], [], "o", mfc="none", color=GREY, label="integrated impacts (Hertz, Tsuji)")
    out.set(xlabel="restitution requested [-]", ylabel="restitution of the impact [-]",
            xlim=(0, 1), ylim=(0, 1))  # fmt: skip
    out.legend(loc="lower right")
    headline(figure, "Three dashpots and two ends of a contact")
    return figure
