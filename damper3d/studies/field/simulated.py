"""Responses from simulations of structure and bed together: a run a level and frequency.

The runs are those of a case with a [host] at other amplitudes and frequencies of what moves it, in
the folders of a sweep: finished ones are not done again.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from damper3d.case.case import DamperCase
from damper3d.case.host.host import FORGOTTEN, cycles_until
from damper3d.studies.field.structure import DRIVES, Structure, structure_of
from granulab.campaign.sweeps.sweep import Labelled

_UNITS = dict(zip(DRIVES, ("N", "m", "m/s2"), strict=True))
Rows = list[dict[str, Any]]


def response_cases(
    host: str, levels: Sequence[float], frequencies: Sequence[float]
) -> list[Labelled]:
    """The case at each level and frequency [Hz], with the labels level and frequency_hz.

    host: a name or path of a case with a [host]. A run is steady unless the case gives its cycles,
    and not judged before its start is forgotten, whatever the case discards: off the resonance it
    beats, and at the top of a beat ten cycles are like the ten before.
    Raises InputError where the case has no steady response.
    """
    structure = structure_of(DamperCase.load(host))
    drive = next(name for name in DRIVES if getattr(structure, name))
    cases: list[Labelled] = []
    for level in levels:
        size = f"{level * getattr(structure, drive)!r} {_UNITS[drive]}"
        for frequency in frequencies:
            changes = {f"host.{drive}": size, "motion.frequency": frequency,
                       "output.keep": "summary"}  # fmt: skip
            labels = {"level": level, "frequency_hz": frequency}
            case = DamperCase.load(host, changes)
            if case.settings.run.steady:
                assert case.modes is not None
                waits = cycles_until(FORGOTTEN, case.modes.slowest, frequency) or 0
                discard = max(case.settings.run.discard, waits)
                case = DamperCase.load(host, {**changes, "run.discard": discard})
            cases.append((labels, case))
    return cases


def points(structures: Mapping[str, Structure], rows: Rows, shown: int = 0) -> Rows:
    """A row for each run: amplitudes with the bed and bare [m]; None where it is not done.

    structures: at each damper, by the name of its place; of several each has amplitudes of its own
    under `dampers`, besides those of the shown one.
    """
    found = []
    for row in rows:
        each = row.get("dampers") or [{"amplitude_m": row.get("host.amplitude_m")}]
        own = [
            _amplitudes(row, structure, each[d]["amplitude_m"] if d < len(each) else None)
            for d, structure in enumerate(structures.values())
        ]
        places = [{"at": name, **one} for name, one in zip(structures, own, strict=True)]
        found.append(
            {
                "level": row["level"],
                "frequency_hz": row["frequency_hz"],
                **own[shown],
                **({"dampers": places} if len(places) > 1 else {}),
                "steady": row.get("steady"),
                "efficiency": row.get("efficiency"),
                "state": row["state"],
                "reused": row.get("reused"),
                "run_folder": row["run_folder"],
            }
        )
    return found


def _amplitudes(
    row: dict[str, Any], structure: Structure, amplitude: float | None
) -> dict[str, float | None]:
    bare = row["level"] * abs(complex(structure.bare([row["frequency_hz"]])[0]))
    reduction = None if amplitude is None else amplitude / bare
    return {"bare_amplitude_m": bare, "amplitude_m": amplitude, "reduction": reduction}


def in_columns(found: Rows) -> Rows:
    """The points as rows of a table: of several dampers, columns by the names of their places."""
    return [
        {key: value for key, value in one.items() if key != "dampers"}
        | {
            f"{key}_{damper['at']}": damper[key]
            for key in ("bare_amplitude_m", "amplitude_m")
            for damper in one.get("dampers", ())
        }
        for one in found
    ]


def in_words(found: Rows) -> str:
    """Report of points: a line each; of several dampers for each of them."""
    if not found or "dampers" not in found[0]:
        return _table(found)
    tables = []
    for d, first in enumerate(found[0]["dampers"]):
        tables += [f"at {first['at']}", _table([{**one, **one["dampers"][d]} for one in found])]
    return "\n".join(tables)


def _table(found: Rows) -> str:
    lines = [f"{'level':>8}{'frequency':>13}{'bare':>13}{'simulated':>13}{'reduction':>11}"]
    for one in found:
        start = (
            f"{one['level']:8g}{one['frequency_hz']:10.4g} Hz{1e3 * one['bare_amplitude_m']:10.4g} "
            "mm"
        )
        if one["amplitude_m"] is None:
            lines.append(f"{start}  {one['state']}")
            continue
        settled = "" if one["steady"] in (True, None) else "  not steady: give more --max-cycles"
        lines.append(f"{start}{1e3 * one['amplitude_m']:10.4g} mm{one['reduction']:11.3f}{settled}")
    return "\n".join(lines)
