"""The packing fractions of a case's particles, computed: in a periodic cell, in its own bed."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from damper3d.case.case import DamperCase
from damper3d.case.random_packing import Fraction
from damper3d.studies.pack import tasks
from damper3d.studies.pack.compact import least_bodies
from granulab.campaign.output.layout import done, not_done, with_sd
from granulab.campaign.output.statistics import mean_sd
from granulab.errors import InputError

Row = dict[str, Any]
BODIES, PACKINGS = 100, 3


def pack(
    name: str,
    changes: dict[str, Any],
    *,
    out: Path,
    bodies: int = BODIES,
    packings: int = PACKINGS,
    beds: bool = True,
    **engine: Any,
) -> list[Row]:
    """A row for each packing of the particles of a case; `place` is cell or enclosure.

    `name` and `changes` are what DamperCase.load takes; `engine` is what tasks.run takes. Raises
    InputError where there is no such case, or too few particles for the cell.
    """
    case = DamperCase.load(name, changes)
    if case.bed is not None:
        raise InputError(f"{case.name}: packings are computed of particles that are all alike")
    particle = case.particle
    least_bodies(particle, bodies)
    seeds = range(1, packings + 1)
    wanted = [("cell", tasks.Task(out, s, particle=particle, bodies=bodies)) for s in seeds]
    if beds:
        own = tuple(changes.items())
        wanted += [("enclosure", tasks.Task(out, s, name=name, changes=own)) for s in seeds]
    rows = tasks.run([task for _, task in wanted], **engine)
    return [{"place": place, **row} for (place, _), row in zip(wanted, rows, strict=True)]


def close_fraction(rows: Sequence[Row], bodies: int) -> Fraction | None:
    """The close packing of rows in the cell; None where none is done."""
    sample = mean_sd([row["fraction"] for row in done(rows) if row["place"] == "cell"])
    if sample.mean is None:
        return None
    words = f"computed: {sample.n} packings of {bodies} in a periodic cell"
    return Fraction(sample.mean, sample.sd or 0.0, words)


def summary(particles: str, bodies: int, rows: Sequence[Row]) -> dict[str, Any]:
    """For --json; what was not computed is None."""
    found = done(rows)

    def of(place: str, key: str) -> dict[str, Any] | None:
        sample = mean_sd([row[key] for row in found if row["place"] == place])
        return {"value": sample.mean, "sd": sample.sd, "packings": sample.n} if sample.n else None

    return {
        "particles": particles,
        "bodies": bodies,
        "close": of("cell", "fraction"),
        "coordination": of("cell", "coordination"),
        "rattlers": of("cell", "rattlers"),
        "loose_in_enclosure": of("enclosure", "loose"),
        "shaken_down_in_enclosure": of("enclosure", "close"),
        "rows": list(rows),
    }


def as_text(particles: str, bodies: int, rows: Sequence[Row]) -> str:
    """Report: a line for each fraction, and for each packing that failed."""
    found = done(rows)
    lines = [f"{particles}: volume of the particles over that of the space"]
    for words, place, key in (
        (f"close, frictionless in a periodic cell of {bodies}", "cell", "fraction"),
        ("  neighbours of those that are held", "cell", "coordination"),
        ("  rattlers", "cell", "rattlers"),
        ("loose, poured into the enclosure", "enclosure", "loose"),
        ("close, shaken down in the enclosure", "enclosure", "close"),
    ):
        sample = mean_sd([row[key] for row in found if row["place"] == place])
        if sample.n:
            lines.append(f"  {words:48}{with_sd(sample)}")
    return "\n".join([*lines, *not_done(rows, ["place", "seed"])])
