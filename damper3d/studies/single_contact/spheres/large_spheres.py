"""Large spheres on a flat block by the damped law, to both ends of a contact (Figs 5.20, 5.21)."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from damper3d.engine.spheres.collision import NORMAL_FORCE, OVERLAP, TIME
from damper3d.studies.single_contact import Found
from damper3d.studies.single_contact.spheres.impact import Impact, Outcome, run
from granulab.campaign.output.figure import BLUE, GREY, VERMILION, headline
from granulab.contact.files.table import load_table
from granulab.contact.reduced import reduced_mass, reduced_radius
from granulab.contact.sphere_law import yield_velocity

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RESTITUTIONS = {0.02: 0.81, 0.2: 0.56}  # of aluminium at speeds [m/s]; Table 5.2


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
            numbers[f"{impact.speed:g} m/s, to zero {end}"] = _results(outcome)
            rows += [
                {
                    "speed_m_s": impact.speed, "contact_end": end, "time_s": float(row[TIME]),
                    "overlap_m": float(row[OVERLAP]), "force_n": float(row[NORMAL_FORCE]),
                }
                for row in outcome.history
            ]  # fmt: skip
    numbers["printed"] = printed
    return Found(numbers, rows, remarks)


def _yields_at(impact: Impact) -> float:
    radius = reduced_radius(1.0 / impact.radius, 0.0)
    mass = reduced_mass(1.0 / impact.mass, 0.0)
    return yield_velocity(impact.first, impact.second, radius=radius, mass=mass)


def _results(outcome: Outcome) -> dict[str, float]:
    keys = ("normal_restitution", "dissipated_j", "contact_time_s", "max_overlap_m", "max_force_n")
    return {key: getattr(outcome, key) for key in keys}


def draw_hits(found: Found, words: str) -> "Figure":
    """Force against time and overlap; of several speeds, against overlap in a panel each."""
    from matplotlib.figure import Figure

    speeds = list(dict.fromkeys(row["speed_m_s"] for row in found.rows))
    both = [(speeds[0], "time_s", "time [us]"), (speeds[0], "overlap_m", "overlap [um]")]
    several = [(speed, "overlap_m", "overlap [um]") for speed in speeds]
    figure = Figure(figsize=(10, 4.4), layout="constrained")
    panels = both if len(speeds) == 1 else several
    for axes, (speed, key, label) in zip(figure.subplots(1, len(panels)), panels, strict=True):
        rows = [row for row in found.rows if row["speed_m_s"] == speed]
        unit, name = (1e3, "kN") if max(row["force_n"] for row in rows) > 2e3 else (1.0, "N")
        for end, colour, style in (("overlap", BLUE, "-"), ("force", VERMILION, (0, (4, 2)))):
            mine = [row for row in rows if row["contact_end"] == end]
            axes.plot([1e6 * row[key] for row in mine], [row["force_n"] / unit for row in mine],
                      color=colour, ls=style, label=f"ends at zero {end}")  # fmt: skip
        axes.set(xlabel=label, ylabel=f"normal force [{name}]")
        axes.set_title(f"{speed:g} m/s", fontsize=9, loc="left")
        axes.axhline(0, color=GREY, lw=0.6)
        axes.set_xlim(left=0)
    axes.legend(loc="upper left")
    headline(figure, words)
    return figure


def aluminium() -> Found:
    """Impacts of 200 mm of aluminium at both speeds of Table 5.2, with the restitution found there.

    Compared with finite elements of the thesis's [205] on a rigid wall (Fig. 5.21).
    """
    solid = load_table("aluminium").material("aluminium")
    impacts = [
        Impact(solid, None, radius=0.1, speed=speed, restitution=e)
        for speed, e in RESTITUTIONS.items()
    ]
    printed = {"yield_velocity_m_s": 0.0016, "speed_over_yield_velocity": [12.2, 122]}
    remark = (
        "the damped law has no plastic part: it stays at its overlap only where a sphere that "
        "yields keeps a dent, so overlaps differ at 122 times the yield velocity (sec. 5.5.4)"
    )
    return hit(impacts, printed, (remark,))


def draw_aluminium(found: Found) -> "Figure":
    """Force against time and overlap."""
    return draw_hits(found, "Aluminium sphere of 200 mm on a rigid wall")


def steel() -> Found:
    """Impact of 40 mm of steel at 2.4 m/s (Fig. 5.20).

    Measured by Mishra et al., the thesis's [168]. Restitution 0.57 ("typical", sec. 5.5.4).
    The block is of steel: only that gives 8.1.
    """
    solid = load_table("steel").material("steel")
    impact = Impact(solid, solid, radius=20e-3, speed=2.4, restitution=0.57)
    printed = {
        "dissipated_measured_j": 0.47,
        "dissipated_by_the_law_j": 0.50,
        "speed_over_yield_velocity": 8.1,
    }
    remark = (
        "printed: 0.47 J measured, 0.50 J by the law, between ours to zero force and to zero "
        "overlap; the thesis does not say where its contact ended"
    )
    return hit([impact], printed, (remark,))


def draw_steel(found: Found) -> "Figure":
    """Force against time and overlap."""
    return draw_hits(found, "Steel sphere of 40 mm on a steel block")
