"""Random packing fractions by shape: in a periodic cell, and in the thesis's enclosure.

Spheroids and toroids of Tables 8.1 and 8.2. Close: frictionless particles jammed in a periodic cell
(studies.pack.compact), of some shapes other numbers too. Walled: 90 spheroids, 110 toroids in the
cylinder of 40 mm x 40 mm, poured, and then shaken down (studies.pack.shaken); so also the 358
spheres of 5 mm of Table 6.3, to say which of the two close packings predicts its onsets better.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from damper3d.reproduce.panels import completeness
from damper3d.reproduce.quantities.packing import (
    BODIES,
    PACKINGS,
    SPHERES,
    Readings,
    Shape,
    Values,
    text_of,
    values,
)
from damper3d.shapes.particle import parse_particle
from damper3d.studies.pack import tasks
from granulab.campaign.claims.claim import claims_of
from granulab.campaign.claims.judge import report_claims
from granulab.campaign.output.figure import BLUE, GREEN, INK, ORANGE, headline
from granulab.campaign.output.layout import columns, done, paragraphs, with_sd
from granulab.campaign.output.statistics import Sample

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Row = dict[str, Any]

SEEDS = 3
COLUMNS = (
    "shape", "ratio", "place", "bodies", "fraction", "coordination", "rattlers", "overlap", "loose",
    "close",
)  # fmt: skip
SPHEROIDS = (0.7, 0.85, 1.0, 1.1, 1.25, 1.5, 2.0, 3.0)
TOROIDS = (0.05, 0.11, 0.2, 0.33)
# Also in the cell; 200 of many sub-spheres would take longer than all the rest.
SIZED = {("spheroid", 1.0): (50, 200), ("spheroid", 1.5): (50,), ("toroid", 0.2): (50,)}
# In the enclosure, with the thesis's numbers (secs 6.2, 8.3).
BEDS = {("spheroid", 0.7): 90, ("spheroid", 1.0): 90, ("spheroid", 1.5): 90, ("toroid", 0.2): 110,
        SPHERES: 358}  # fmt: skip
# Near the sphere fewer sub-spheres than 51 keep the surface within 5e-4 of the radius too.
_FEWER = {1.1: 21, 1.25: 31, 1.5: 41}


def shapes() -> tuple[Shape, ...]:
    """All shapes of the table."""
    spheroids = [("spheroid", ratio) for ratio in SPHEROIDS]
    return (*spheroids, *(("toroid", ratio) for ratio in TOROIDS))


def points() -> list[Row]:
    """The labels of each point, without the seed."""
    cells = [(shape, BODIES) for shape in shapes()]
    cells += [(shape, bodies) for shape, sizes in SIZED.items() for bodies in sizes]
    labelled = [(shape, "cell", bodies) for shape, bodies in cells]
    labelled += [(shape, "enclosure", count) for shape, count in BEDS.items()]
    return [
        {"shape": shape[0], "ratio": shape[1], "place": place, "bodies": bodies}
        for shape, place, bodies in labelled
    ]


def run(*, out: Path, seeds: Sequence[int], workers: int | None, quiet: bool) -> list[Row]:
    """All packings of the table."""
    labelled = [(point, seed) for seed in seeds for point in points()]
    made = [_task(point, seed, out) for point, seed in labelled]
    rows = tasks.run(made, workers=workers, quiet=quiet)
    return [{**point, **row} for (point, _), row in zip(labelled, rows, strict=True)]


def _task(point: Row, seed: int, out: Path) -> tasks.Task:
    shape = point["shape"], point["ratio"]
    if point["place"] == "enclosure":
        changes = (("particles.shape", text_of(shape)), ("particles.count", point["bodies"]))
        return tasks.Task(out, seed, changes=changes)
    fewer = _FEWER.get(shape[1]) if shape[0] == "spheroid" else None
    particle = parse_particle(text_of(shape), sub_spheres=fewer)
    return tasks.Task(out, seed, particle=particle, bodies=point["bodies"])


_CRITERION = """\
close: frictionless, jammed in a periodic cell of 100; +- standard deviation over the packings
  (number); held: neighbours of those that are no rattlers, 3e-4 above jamming; loose, shaken down:
  in the cylinder of 40 mm x 40 mm with its walls; onset: Gamma of eqs 6.11 and 6.13 with the close
  packing over that of spheres in the same number, at the thesis's fill ratio."""


def report(rows: list[Row]) -> str:
    """Return what lacks, a line a shape, the sizes, the claims."""
    found = values(done(rows))
    table = [_line(shape, own, found) for shape, own in found.items()]
    heads = ["shape", "ratio", "close", "held", "rattlers", "loose", "shaken down", "onset"]
    return paragraphs(
        completeness(rows, points(), SEEDS),
        columns(heads, table),
        _sizes_table(found),
        report_claims(PACKINGS.judge(claims_of("damper_packing"), Readings(rows, found))),
        _CRITERION,
    )


def _line(shape: Shape, own: Values, found: dict[Shape, Values]) -> list[str]:
    held = own.held.get(BODIES)
    close, loose, shaken = own.close.get(BODIES), own.loose, own.shaken
    cells = [with_sd(sample) if sample else "-" for sample in (close, loose, shaken)]
    onset = own.onset_over(found.get(("spheroid", 1.0)), BODIES)
    rattlers = own.rattlers.get(BODIES)
    return [
        shape[0], f"{shape[1]:g}", cells[0], "-" if held is None else f"{held:.2f}",
        "-" if rattlers is None else f"{100 * rattlers:.1f} %", *cells[1:],
        "-" if onset is None else f"{onset:.2f}",
    ]  # fmt: skip


def _sizes_table(found: dict[Shape, Values]) -> str:
    lines = []
    for shape in SIZED:
        own = found.get(shape)
        if own is not None:
            cells = [with_sd(own.close[n]) if n in own.close else "-" for n in (50, 100, 200)]
            lines.append([text_of(shape), *cells])
    return columns(["close, by number in the cell", "50", "100", "200"], lines) if lines else ""


# Published close packings: family, ratio, fraction, whose.
_PUBLISHED = (
    ("spheroid", 1.0, 0.64, "thesis, below eq. 6.13"),
    ("spheroid", 1.5, 0.71, "Donev et al. 2004 (thesis [219])"),
)
_TITLES = {"spheroid": "spheroids", "toroid": "toroids"}
_RATIOS = {"spheroid": "aspect ratio a/b [-]", "toroid": "hole ratio (a - b)/(a + b) [-]"}


def draw(rows: list[Row]) -> "Figure":
    """Fractions against aspect ratio and hole ratio, with published ones."""
    from matplotlib.figure import Figure

    found = values(done(rows))
    figure = Figure(figsize=(9.6, 4.0), layout="constrained")
    headline(figure, "How densely particles pack at random")
    panels = figure.subplots(1, 2, sharey=True, width_ratios=(1.4, 1))
    for axes, family in zip(panels, _TITLES, strict=True):
        own = {shape[1]: one for shape, one in found.items() if shape[0] == family}
        close = {r: one.close[BODIES] for r, one in own.items() if BODIES in one.close}
        _curve(axes, close, BLUE, "o", f"close: jammed, periodic cell of {BODIES}")
        shaken = {ratio: one.shaken for ratio, one in own.items() if one.shaken}
        _curve(axes, shaken, GREEN, "s", "shaken down in 40 mm x 40 mm")
        loose = {ratio: one.loose for ratio, one in own.items() if one.loose}
        _curve(axes, loose, ORANGE, "^", "loose: poured into 40 mm x 40 mm")
        for (kind, ratio, value, whose), marker in zip(_PUBLISHED, "x+", strict=True):
            if kind == family:
                axes.plot(ratio, value, marker, color=INK, ms=9, mew=1.6, ls="none", label=whose)
        axes.set_xlabel(_RATIOS[family])
        axes.set_title(_TITLES[family], loc="left", fontsize=9)
        axes.grid(axis="y")
    panels[0].set_ylabel("packing fraction [-]")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside right upper")
    return figure


def _curve(
    axes: "Axes", points: Mapping[float, Sample], colour: str, marker: str, label: str
) -> None:
    ratios = sorted(points)
    means = [points[ratio].mean or 0.0 for ratio in ratios]
    spread = [points[ratio].sd or 0.0 for ratio in ratios]
    axes.errorbar(
        ratios, means, spread, color=colour, marker=marker, ms=4, lw=1.2, elinewidth=0.8,
        capsize=2, label=label,
    )  # fmt: skip
