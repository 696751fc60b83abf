"""Drop tests of many films, each one trial: pooled by particle and height, as in Table 2."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from calibration.bench.heights import by_label, nested
from calibration.bench.measure import Measurement, measure
from calibration.bench.sections import Columns, Request, Section
from calibration.drop.measure import measure_drop
from calibration.drop.result import Drop
from calibration.statistics.uncertainty import Estimate
from calibration.tracking.film.reader import FILMS, PICTURES, Progress
from granulab.errors import InputError

_TABLES = (".csv", ".txt", ".tsv", ".xlsx", ".xls", ".ods")
_ENDINGS = (*FILMS, *_TABLES)


def is_folder_of_films(path: Path) -> bool:
    """True for a folder that holds films or tracks, itself or in its folders.

    Tables next to pictures are notes on the film that these are.
    """
    if not path.is_dir():
        return False
    there = {one.suffix.lower() for one in path.rglob("*")}
    return not there.isdisjoint(FILMS) or (
        not there.isdisjoint(_TABLES) and there.isdisjoint(PICTURES)
    )


def films_of(sources: Sequence[Path]) -> list[tuple[Path, tuple[str, ...]]]:
    """All films and tracks, each with the folders in which it lies below what was named."""
    found: list[tuple[Path, tuple[str, ...]]] = []
    for source in sources:
        if not is_folder_of_films(source):
            found.append((source, ()))
            continue
        inside = sorted(one for one in source.rglob("*") if one.suffix.lower() in _ENDINGS)
        found += [(one, one.relative_to(source).parts[:-1]) for one in inside]
    return found


@dataclass(frozen=True)
class _Trial:
    """A film that was measured, its particle and height, and its name."""

    name: str
    particle: str
    height: str | None
    drop: Drop


def measure_drops(
    sources: Sequence[str | Path], *, progress: Progress | None = None, out: Path | None = None,
    **how: Any,
) -> tuple[Measurement, list[Path]]:  # fmt: skip
    """Restitution over the trials of several films, as a method of the bench.

    sources   films, tracks, and folders of them: PARTICLE/film, or PARTICLE/HEIGHT/film
    how       of measure_drop

    Returns the files that were measured, too. A film that cannot be is left out, with its reason
    among the remarks. Raises InputError where none can be.
    """
    films = films_of([Path(source) for source in sources])
    trials, measured, left_out, done = [], [], [], 0.0
    for k, (path, folders) in enumerate(films):

        def part(share: float, words: str, k: int = k, name: str = path.name) -> None:
            nonlocal done  # a film is read for its positions first, then for its pictures
            done = max(done, (k + share) / len(films))
            if progress is not None:
                progress(done, f"{name}, {words}")

        where = None if out is None else out.joinpath(*folders)
        try:
            drop = measure_drop(path, progress=part, out=where, **how)
        except InputError as error:
            left_out.append(f"left out: {error}")
            continue
        particle, height = (*folders[:2], None, None)[:2]
        trials.append(_Trial("/".join((*folders, path.name)), particle or "all", height, drop))
        measured.append(path)
    if not trials:
        raise InputError(f"none of {len(films)} films can be measured; {left_out[0][10:]}")
    return _pooled(trials, left_out), measured


def _pooled(trials: Sequence[_Trial], left_out: Sequence[str]) -> Measurement:
    sections = [Section(one.particle, one.name, _columns(one.drop)) for one in trials]
    labelled = [
        section if one.height is None else by_label(section, one.height)
        for section, one in zip(sections, trials, strict=True)
    ]
    found = measure(
        labelled, _restitution, Request(), key="restitution", name="restitution",
        remarks=[f"{len(trials)} films, each one trial", *left_out],
    )  # fmt: skip
    groups = {one.group: section.group for one, section in zip(labelled, sections, strict=True)}
    found = nested(found, groups)
    details: dict[str, Any] = {**found.details, "trials": [_row(one) for one in trials]}
    details |= {"films_left_out": list(left_out)}
    whole = found.to_dict()["restitution"] | {"constant_within_noise": found.pooled.alike}
    found = replace(found, details=details | {"restitution": whole})
    return Measurement((found,), "drop test", {"restitution": "restitution"})


def _columns(drop: Drop) -> dict[str, Any]:
    one = drop.restitution
    return {"e": np.array([one.value]), "sigma": np.array([one.sigma or 0.0])}


def _restitution(columns: Columns) -> Estimate:
    return Estimate(float(columns["e"][0]), float(columns["sigma"][0]) or None, 1)


def _row(one: _Trial) -> Mapping[str, Any]:
    """H0, H1, restitution and rotation of a film."""
    first = one.drop.to_dict()["first_contact"]
    return {"film": one.name, "particle": one.particle, "height": one.height} | dict(_flat(first))


def _flat(answers: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    for name, value in answers.items():
        if isinstance(value, Mapping):
            yield name, value["value"]
            yield f"{name}_sigma", value["sigma"]
        else:
            yield name, value
