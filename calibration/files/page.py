"""A page to print on how each value of a parameter file was measured, as one HTML file.

For each value: its command, date and files, what a reviewer would ask (how many trials, how they
scatter, which stand apart, whether one number describes them), the figure and the raw data. The
page holds everything itself and needs no network.
"""

import base64
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from calibration.files.provenance import shown
from calibration.files.record import Record
from granulab.contact.material import PROPERTIES, Measured

_APART = 3.5  # robust deviations from the median: Iglewicz and Hoaglin (1993)
_MAD = 1.4826  # standard deviation of a normal distribution over its median absolute deviation
_MOST_RAW = 60  # lines of a file that are shown
_STYLE = """
body { font: 11pt/1.45 "DejaVu Sans", Arial, sans-serif; max-width: 46rem; margin: 2rem auto;
       padding: 0 1rem; color: #2b2b2b; background: #fff; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.1rem; border-top: 1px solid #999; padding-top: 1rem; }
table { border-collapse: collapse; margin: .6rem 0; } th, td { text-align: left; padding: .15rem
       .9rem .15rem 0; vertical-align: top; } th { font-weight: 600; }
pre { background: #f4f2ee; padding: .6rem; overflow-x: auto; font-size: 8.5pt; }
img { max-width: 100%; } code { background: #f4f2ee; }
@media print { h2 { break-before: page; } pre { white-space: pre-wrap; } }
"""


def page(
    path: Path, values: Mapping[tuple[str, str], Measured],
    records: Mapping[tuple[str, str], Record],
) -> str:  # fmt: skip
    """The page of a parameter file: a table of all values, then each in a section of its own."""
    title = f"{path.name}: how each value was measured"
    rows = [
        (section, key, shown(value, PROPERTIES[key].unit_in_files), value.method or "",
         "on record" if (section, key) in records else "not on record")
        for (section, key), value in values.items()
    ]  # fmt: skip
    parts = [
        f"<h1>{escape(title)}</h1>",
        _table(("section", "key", "value", "method", "record"), rows),
    ]
    for (section, key), value in values.items():
        parts += _value(section, key, value, records.get((section, key)))
    return (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{escape(title)}</title>'
        f"<style>{_STYLE}</style><body>{chr(10).join(parts)}</body></html>\n"
    )


def questions(value: Measured, record: Record | None) -> list[tuple[str, str]]:
    """Questions that a reviewer would ask of a value, each with its answer."""
    trials = [] if record is None else trials_of(record)
    asked = [("how many trials", str(value.trials or len(trials) or "not said"))]
    relative = "" if value.sigma is None or not value.value else (
        f" ({100 * value.sigma / abs(value.value):.2g} %)"
    )  # fmt: skip
    known = "no sigma" if value.sigma is None else f"sigma given{relative}"
    asked.append(("how well known", known))
    if trials:
        x = np.array([one for _, one in trials])
        low, middle, high = np.quantile(x, [0.25, 0.5, 0.75])
        asked.append(
            ("distribution", f"{x.min():.4g} to {x.max():.4g}, median {middle:.4g}, quartiles "
                             f"{low:.4g} and {high:.4g}")
        )  # fmt: skip
        apart = outliers(trials)
        asked.append(("outliers", ", ".join(f"{name}: {one:.4g}" for name, one in apart) or "none"))
    one = None if record is None else _one_number(record)
    if one is not None:
        said = "yes" if one else "no: its groups differ by more than chance; see the groups"
        asked.append(("one number describes them", said))
    if value.history:
        before = ", ".join(f"{old.value:.4g}" for old in value.history)
        asked.append(("it replaced", before))
    return asked


def trials_of(record: Record) -> list[tuple[str, float]]:
    """Single values that a value was pooled from, by name, wherever its JSON has them."""
    for value in _pooled(record):
        rows = value.get("per_trial")
        if rows:
            return [(str(row["trial"]), float(row["value"])) for row in rows]
        for name in ("per_pair", "per_collision"):
            if value.get(name):
                return [(f"{k}", float(one)) for k, one in enumerate(value[name], start=1)]
    bounces = record.answers.get("bounces") or []
    keys = ("from_velocities", "from_times")
    return [
        (f"bounce {k}", float(next(b[key] for key in keys if b.get(key) is not None)))
        for k, b in enumerate(bounces, start=1)
        if isinstance(b, dict) and any(b.get(key) is not None for key in keys)
    ]


def outliers(trials: Sequence[tuple[str, float]]) -> list[tuple[str, float]]:
    """Trials that stand apart: more than 3.5 robust standard deviations from the median."""
    x = np.array([one for _, one in trials])
    if len(x) < 4:
        return []
    away = np.abs(x - np.median(x))
    width = _MAD * float(np.median(away))
    far = away > _APART * width
    return [one for one, apart in zip(trials, far, strict=True) if apart] if width else []


def _one_number(record: Record) -> bool | None:
    for value in _pooled(record):
        for name in ("constant_within_noise", "groups_alike"):
            if value.get(name) is not None:
                return bool(value[name])
    return None


def _pooled(record: Record) -> list[dict[str, Any]]:
    """Answers of the quantity that the value is, or all where none says it."""
    found = [one for one in record.answers.values() if isinstance(one, dict)]
    return [one for one in found if one.get("value") == record.value] or found


def _value(section: str, key: str, value: Measured, record: Record | None) -> Iterator[str]:
    said = shown(value, PROPERTIES[key].unit_in_files)
    yield f"<h2>[{escape(section)}] {escape(key)} = {escape(said)}</h2>"
    known = [
        ("method", value.method), ("of", value.source), ("date", value.date and str(value.date)),
        ("SHA-256 of what was measured", value.digest),
    ]  # fmt: skip
    yield _table((), [(name, str(words)) for name, words in known if words])
    yield _table((), questions(value, record))
    if record is None:
        yield "<p>There is no record of the measurement next to the file: it was written by hand, "
        yield "shipped, or measured with a version that kept none.</p>"
        return
    command = " ".join(record.provenance.get("command", []))
    yield f"<pre>{escape(command)}</pre>"
    if record.figure is not None:
        data = base64.b64encode(record.figure).decode()
        yield f'<img alt="diagnostic figure" src="data:image/png;base64,{data}">'
    for warning in record.answers.get("warnings") or []:
        yield f"<p>warning: {escape(str(warning))}</p>"
    for name, text in record.raw.items():
        yield f"<h3>{escape(name)}</h3>"
        if text is None:
            yield "<p>No short text: known by its SHA-256 above.</p>"
            continue
        lines = text.splitlines()
        more = f"\n... {len(lines) - _MOST_RAW} lines more" if len(lines) > _MOST_RAW else ""
        yield f"<pre>{escape(chr(10).join(lines[:_MOST_RAW]) + more)}</pre>"


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    top = "".join(f"<th>{escape(name)}</th>" for name in head)
    body = "".join(
        "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows
    )
    return f"<table>{f'<tr>{top}</tr>' if top else ''}{body}</table>"
