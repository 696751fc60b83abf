"""A ball that hits a flat block, by the damped law, for both ends of a contact; Figs 5.20, 5.21."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from campaign.figure import BLUE, GREEN, ORANGE, VERMILION, headline
from contact.reduced import reduced_mass, reduced_radius
from contact.sphere_law import yield_velocity
from damper3d.collision import NORMAL_FORCE, OVERLAP, TIME
from damper3d.impact import Impact, Outcome, run
from damper3d.single_contact import Found

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLOURS = [BLUE, VERMILION, GREEN, ORANGE]


def hit(impacts: list[Impact], printed: dict[str, Any], remarks: tuple[str, ...]) -> Found:
    """Each impact with both ends; `printed` is what the thesis has of it."""
    numbers: dict[str, Any] = {
        "kinetic_energy_j": [0.5 * i.mass * i.speed**2 for i in impacts],
        "yield_velocity_m_s": _yields_at(impacts[0]),
        "speed_over_yield_velocity": [i.speed / _yields_at(i) for i in impacts],
    }
    rows: list[dict[str, Any]] = []
    for impact in impacts:
        for end in ("overlap", "force"):
            outcome = run(replace(impact, end=end))
            numbers[f"{impact.speed:g} m/s, to zero {end}"] = _told(outcome)
            for row in outcome.history:
                rows.append(
                    {
                        "speed_m_s": impact.speed, "contact_end": end, "time_s": float(row[TIME]),
                        "overlap_m": float(row[OVERLAP]), "force_n": float(row[NORMAL_FORCE]),
                    }
                )  # fmt: skip
    numbers["printed"] = printed
    return Found(numbers, rows, remarks)


def _yields_at(impact: Impact) -> float:
    radius = reduced_radius(1.0 / impact.radius, 0.0)
    mass = reduced_mass(1.0 / impact.mass, 0.0)
    return yield_velocity(impact.first, impact.second, radius=radius, mass=mass)


def _told(outcome: Outcome) -> dict[str, float]:
    keys = ("normal_restitution", "dissipated_j", "contact_time_s", "max_overlap_m", "max_force_n")
    return {key: getattr(outcome, key) for key in keys}


def draw_hits(found: Found, words: str) -> "Figure":
    """Force against time and against overlap."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 4.4), layout="constrained")
    over_time, over_depth = figure.subplots(1, 2)
    cases = dict.fromkeys((row["speed_m_s"], row["contact_end"]) for row in found.rows)
    largest = max(row["force_n"] for row in found.rows)
    unit, name = (1e3, "kN") if largest > 2e3 else (1.0, "N")
    for colour, (speed, end) in zip(_COLOURS, cases, strict=False):
        rows = [r for r in found.rows if (r["speed_m_s"], r["contact_end"]) == (speed, end)]
        force = [row["force_n"] / unit for row in rows]
        style = {"color": colour, "ls": "-" if end == "overlap" else (0, (4, 2))}
        label = f"{speed:g} m/s, ends at zero {end}"
        over_time.plot([1e6 * row["time_s"] for row in rows], force, label=label, **style)
        over_depth.plot([1e6 * row["overlap_m"] for row in rows], force, label=label, **style)
    over_time.set(xlabel="time [us]", ylabel=f"normal force [{name}]")
    over_depth.set(xlabel="overlap [um]", ylabel=f"normal force [{name}]")
    for axes in (over_time, over_depth):
        axes.axhline(0, color="#8a8a8a", lw=0.6)
        axes.set_xlim(left=0)
    over_depth.legend(loc="upper left")
    headline(figure, words)
    return figure
