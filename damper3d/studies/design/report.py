"""Results of a design: as JSON, in words, as a picture, and as one page to hand on."""

import math
from collections.abc import Mapping, Sequence
from statistics import geometric_mean
from typing import TYPE_CHECKING, Any

import numpy as np

from damper3d.case.case import DamperCase
from damper3d.case.closed_forms import excitation_amplitude
from damper3d.studies.design.search import Design, judge
from damper3d.studies.design.spec import Task
from damper3d.studies.design.verification import Verified, interval, of_field
from damper3d.view.sketch import sketch
from granulab.campaign.output.figure import BLUE, GREY, VERMILION, headline
from granulab.campaign.output.page.document import document, picture
from granulab.campaign.output.page.study import SCRIPTS
from granulab.campaign.sweeps.sketch import draw_sketch

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLOURS = (BLUE, VERMILION, GREY)  # of the first three
_LISTED = 10  # designs in words
_SHOWN = 10  # columns of the page's table, before all are asked for
_OFF = {"level_off": "level a fifth off", "frequency_low": "frequency a fifth lower",
        "frequency_high": "frequency a fifth higher"}  # fmt: skip
_IMPACTS = ("particle_particle", "particle_wall")


def ranked(designs: Sequence[Design], verified: Sequence[Verified]) -> list[Design]:
    """Designs in their order: verified ones by simulations, then the others by their fields."""
    known = {id(one.design): one.mean for one in verified if one.reductions}
    return sorted(designs, key=lambda d: (id(d) not in known, known.get(id(d), d.reduction)))


def as_dict(
    task: Task, design: Design, rank: int, verified: Sequence[Verified],
    robustness: dict[str, float | None] | None = None, again: Verified | None = None,
) -> dict[str, Any]:  # fmt: skip
    """A design for --json; what is not known is None.

    again: the design on packings that nothing was chosen by, whose response goes before.
    """
    candidate, own = design.candidate, next((v for v in verified if v.design is design), None)
    simulated = own is not None and bool(own.reductions)
    shown = again if again is not None and again.reductions else own
    between = interval(shown, verified) if shown and simulated else of_field(design, verified)
    mean = shown.mean if shown and simulated else design.reduction
    return {
        "rank": rank,
        "enclosure": {"shape": "cylinder", "diameter_m": candidate.bed.width,
                      "height_m": candidate.height},
        "clearance_m": candidate.clearance,
        "particles": candidate.bed.ball.name,
        "walls": candidate.bed.ball.walls,
        "count": candidate.bed.count,
        "added_mass_kg": candidate.bed.mass,
        "added_mass_ratio": candidate.bed.mass / task.spec.structure.mass,
        "fill_ratio": 4.0 * candidate.bed.count * candidate.bed.ball.volume
        / (math.pi * candidate.bed.width**2 * candidate.height),
        "reduction": mean,
        "reduction_interval": None if between is None else list(between),
        "reduction_from_field": design.reduction,
        "levels": [
            {"level": level, "reduction": value, "peak_frequency_hz": peak[0]}
            for level, value, peak in zip(
                task.spec.level.range, design.reductions, design.peaks, strict=True
            )
        ],
        "robustness": robustness,
        "peak_wall_force_n": _largest(own, design, "peak_wall_force_n"),
        "impact_over_yield_velocity": _of_pairs(own, design, "max_impact_over_yield_velocity"),
        "impacts_beyond_yield": _of_pairs(own, design, "impacts_beyond_yield"),
        "dissipated_power_w": _largest(own, design, "dissipated_power_w"),
        "verified_by_simulation": None if own is None or not simulated else {
            "levels": [
                {"level": task.spec.level.range[level], "reductions": list(seen.values()),
                 "largest_at_end_of_hz": own.at_end.get(level)}
                for level, seen in sorted(own.levels.items())
            ],
            "reduction": mean,
            "interval": None if between is None else list(between),
            "reductions": own.reductions,
            "unseen": again.reductions if again is not None else [],
            "not_steady": sum(row.get("steady") is False for row in own.rows),
        },
    }  # fmt: skip


def _largest(own: Verified | None, design: Design, name: str) -> float | None:
    """Largest value of a column: of the simulations, or of the field up to the response."""
    if own is not None and own.reductions:
        return own.largest(name)
    near = _at_response(design)
    return None if near is None else near.get(name)


def _at_response(design: Design) -> dict[str, Any] | None:
    """The field's run whose amplitude is nearest to the response at the worst level."""
    if design.field is None or not design.peaks:
        return None
    amplitude = design.peaks[design.worst][1]
    sizes = [excitation_amplitude(row["frequency_hz"], row["gamma"]) for row in design.rows]
    return design.rows[int(np.argmin(np.abs(np.log(np.array(sizes) / amplitude))))]


def _of_pairs(own: Verified | None, design: Design, name: str) -> float | None:
    """Likewise of a column for particles, and for particles and walls."""
    names = [f"{name}.{pair}" for pair in _IMPACTS]
    found = [value for name in names if (value := _largest(own, design, name)) is not None]
    return max(found, default=None)


def in_words(results: dict[str, Any]) -> str:
    """Report of a design: a line for each of the best."""
    task = results["task"]
    lines = [
        f"{results['name']}: {task['mass_kg']:g} kg at {task['frequency_hz']:g} Hz, damping ratio "
        f"{task['damping_ratio']:g}, bare {task['bare_gamma']:.3g} g ({task['orientation']}), "
        f"levels {', '.join(f'{level:g}' for level in task['levels'])}",
        f"closed form of one body without rebound: amplitude {1e3 * task['closed_form_m']:.3g} mm, "
        f"clearance {1e3 * math.pi * task['closed_form_m']:.3g} mm",
        f"{'rank':>4} {'response':>9} {'interval':>16}  {'particles':24}{'enclosure':22}"
        f"{'added':>8}",
    ]
    for one in results["designs"][:_LISTED]:
        between = one["reduction_interval"]
        words = "" if between is None else f"{between[0]:.3f} to {between[1]:.3f}"
        mark = "*" if one["verified_by_simulation"] else " "
        size = one["enclosure"]
        lines.append(
            f"{one['rank']:4} {one['reduction']:8.3f}{mark} {words:>16}  "
            f"{str(one['count']) + ' of ' + one['particles']:24}"
            f"{1e3 * size['diameter_m']:.4g} x {1e3 * size['height_m']:.4g} mm".ljust(79)
            + f"{100 * one['added_mass_ratio']:6.2f} %"
        )
    lines.append(
        "response over that of the bare structure at the worst level; * simulated with it, which "
        "stand before the others: the first at all levels, on packings that it was not chosen by, "
        "the next at the worst of their fields"
    )
    best = results["designs"][0]
    lines.append(f"the first, walls of {best['walls']}{_as_dashpot(task, best)}")
    if best["robustness"]:
        shown = [f"{_OFF[k]} {v:.3f}" for k, v in best["robustness"].items() if v is not None]
        lines.append(f"the first, {', '.join(shown)}")
    force, impact = best["peak_wall_force_n"], best["impact_over_yield_velocity"]
    if force is not None:
        yields = "" if impact is None else f", impacts up to {impact:.2g} of the yield velocity"
        if beyond := best["impacts_beyond_yield"]:
            yields += f", {100 * beyond:.2g} % of them beyond it"
        lines.append(f"the first, {force:.3g} N on its walls at most, mean over a sample{yields}, "
                     f"{best['dissipated_power_w']:.3g} W")  # fmt: skip
    lines += [
        f"{one['what']:12} {one['reduction']:.3f}, {one['words']}{one['simulated']}"
        for one in results["compared"]
    ]
    return "\n".join([*lines, *remarks(results)])


def _as_dashpot(task: Mapping[str, Any], best: Mapping[str, Any]) -> str:
    """Words on the dashpot that lowers the peak as much, and where the peak is by its field.

    The peak of an oscillator goes as one over its damping ratio.
    """
    worst = max(best["levels"], key=lambda one: float(one["reduction"]), default=None)
    if worst is None or not 0.0 < best["reduction"] < 1.0:
        return ""
    added = task["damping_ratio"] * (1.0 / best["reduction"] - 1.0)
    return (
        f"; its peak, at {worst['peak_frequency_hz']:.4g} Hz, is as low as with a damping ratio of "
        f"{added:.2g} added at level {worst['level']:g}"
    )


def remarks(results: dict[str, Any]) -> list[str]:
    """Remarks on a design: a better one, a peak that was not reached, runs unsteady or failed."""
    best, found = results["designs"][0], []
    means = [(geometric_mean(one["reductions"]), one["what"], one["words"])
             for one in results["compared"] if one["reductions"]]  # fmt: skip
    least, _, words = min(means, default=(math.inf, "", ""))
    own = next((mean for mean, what, _ in means if what == "first"), least)
    if least < own:
        found.append(f"better than the first on packings that nothing was chosen by: {words}, "
                     f"{least:.3f} against {own:.3f}")  # fmt: skip
    if number := (best["verified_by_simulation"] or {}).get("not_steady"):
        found.append(f"{number} of its runs with the structure ended before they were steady")
    for one in (best["verified_by_simulation"] or {}).get("levels", ()):
        if one["largest_at_end_of_hz"]:
            low, high = one["largest_at_end_of_hz"]
            found.append(
                f"its largest response at level {one['level']:g} is at an end of the simulated "
                f"{low:g} to {high:g} Hz, and may be larger beyond: simulate it there (damper3d "
                "response HOST --simulate --frequencies)"
            )
    if results["failed"]:
        found.append(f"{results['failed']} candidates are left out, whose runs failed")
    return found


def draw(task: Task, designs: Sequence[Design], verified: Sequence[Verified]) -> "Figure":
    """Response of the best against level, and of all candidates against their clearance."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import LogLocator, NullFormatter, ScalarFormatter

    figure = Figure(figsize=(9.6, 4.2), layout="constrained")
    best = designs[0]
    headline(figure, f"{task.spec.name}: {best.candidate.words}")
    left, right = figure.subplots(1, 2)
    ends = task.spec.level.range[0] * 0.8, task.spec.level.range[-1] * 1.2
    levels = np.linspace(*ends, 21)
    for k, design in enumerate(designs[:3]):
        if design.field is not None:
            found = judge(task, design.field, levels.tolist())[0]
            label = f"{k + 1}: {design.candidate.words}"
            left.plot(levels, found, color=_COLOURS[k], label=label)
    for k, design in enumerate(designs[:3]):
        for one in (v for v in verified if v.design is design):
            for level, seen in one.levels.items():
                there = [task.spec.level.range[level]] * len(seen)
                left.plot(there, list(seen.values()), "o", color=_COLOURS[k])
    left.axvspan(task.spec.level.range[0], task.spec.level.range[-1], color=GREY, alpha=0.12, lw=0)
    left.plot([], [], "o", color=GREY, label="simulated with the structure")
    left.set(xlabel="level", ylabel="response over bare response", ylim=(0, None))
    left.legend(fontsize=7)
    for kind, marker in zip(dict.fromkeys(d.candidate.bed.ball.kind for d in designs), "os^vDP",
                            strict=False):  # fmt: skip
        own = [d for d in designs if d.candidate.bed.ball.kind == kind]
        right.semilogx([1e3 * d.candidate.clearance for d in own], [d.reduction for d in own],
                       marker, label=kind, ms=5)  # fmt: skip
    right.set(xlabel="clearance over the close bed [mm]", ylabel="by their fields")
    right.set_ylim(0, 1.05 * max(design.reduction for design in designs))
    right.xaxis.set_minor_formatter(NullFormatter())
    right.xaxis.set_major_formatter(ScalarFormatter())
    right.xaxis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
    right.legend(fontsize=7)
    return figure


def draw_first(task: Task, design: Design) -> "Figure":
    """The first design to scale: its enclosure with the level of the bed, and a particle."""
    changes = design.candidate.changes(task.spec.level.orientation, task.spec.search.seed)
    return draw_sketch(design.candidate.words, sketch(DamperCase.load("thesis", changes)))


def as_page(results: dict[str, Any], pictures: Mapping[str, bytes]) -> str:
    """One page of HTML with pictures (PNG, by name) and tables in it, to hand to a colleague."""
    title, task = f"A damper for {results['name']}", results["task"]
    data = {
        "title": title,
        "outcome": f"{task['mass_kg']:g} kg at {task['frequency_hz']:g} Hz, damping ratio "
        f"{task['damping_ratio']:g}, {task['bare_gamma']:.3g} g without a damper "
        f"({task['orientation']}); {'; '.join([results['made_by'], *remarks(results)])}",
        "figures": [{"name": name, "source": picture(png)} for name, png in pictures.items()],
        "tables": [*_of_the_first(results), _table(results["designs"])],
    }
    return document("study.html", SCRIPTS, title, data)


def _of_the_first(results: dict[str, Any]) -> list[dict[str, Any]]:
    """Tables of the first design alone: its levels, its robustness, what it was compared with."""
    first = results["designs"][0]
    seen = (first["verified_by_simulation"] or {}).get("levels", [])
    simulated = {one["level"]: one["reductions"] for one in seen}
    levels = [
        [one["level"], one["peak_frequency_hz"], one["reduction"],
         " ".join(f"{value:.3f}" for value in simulated.get(one["level"], []))]
        for one in first["levels"]
    ]  # fmt: skip
    off = [[_OFF[name], value] for name, value in (first["robustness"] or {}).items()]
    other = [[one["what"], one["words"], one["reduction"],
              " ".join(f"{value:.3f}" for value in one["reductions"])]
             for one in results["compared"]]  # fmt: skip
    made = [
        ("The first: response over that of the bare structure, by level", "",
         ["level", "peak [Hz]", "by its field", "simulated"], levels),
        ("The first where the structure is other than it was said to be", "By its field.",
         ["what is off", "response"], off),
        ("Compared with", "On packings that nothing was chosen by.",
         ["design", "in words", "by its field", "simulated"], other),
    ]  # fmt: skip
    return [
        {"title": title, "note": note, "columns": columns, "rows": rows, "links": None,
         "key": list(range(len(columns))), "plot": {}}
        for title, note, columns, rows in made if rows
    ]  # fmt: skip


def _table(designs: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """All designs, the best first, as the page sorts and plots them."""
    rows = [_row(one) for one in designs]
    names = list(rows[0])
    return {
        "title": "Designs, those that were simulated with the structure first",
        "note": "Response over that of the bare structure at the worst level, with its interval "
        "of 95 %; simulated at these levels, the first on packings that it was not chosen by; the "
        "others by their fields.",
        "columns": names,
        "rows": [list(row.values()) for row in rows],
        "links": None,
        "key": list(range(_SHOWN)),
        "plot": {"x": names.index("clearance [mm]"), "y": names.index("response"),
                 "group": names.index("particles")},
    }  # fmt: skip


def _row(one: dict[str, Any]) -> dict[str, Any]:
    between, own = one["reduction_interval"], one["verified_by_simulation"]
    return {
        "rank": one["rank"],
        "particles": one["particles"],
        "number": one["count"],
        "walls": one["walls"],
        "width [mm]": 1e3 * one["enclosure"]["diameter_m"],
        "height [mm]": 1e3 * one["enclosure"]["height_m"],
        "added mass [%]": 100 * one["added_mass_ratio"],
        "response": one["reduction"],
        "interval": None if between is None else f"{between[0]:.3f} to {between[1]:.3f}",
        "simulated at": " ".join(f"{level['level']:g}" for level in own["levels"]) if own else None,
        "clearance [mm]": 1e3 * one["clearance_m"],
        "fill ratio": one["fill_ratio"],
        "force on the walls [N]": one["peak_wall_force_n"],
        "impact over yield velocity": one["impact_over_yield_velocity"],
        "impacts beyond yield": one["impacts_beyond_yield"],
        "power [W]": one["dissipated_power_w"],
    }
