"""Laws of a case beside the linear one: with cohesion, or with a measured curve kn(overlap)."""

from pathlib import Path

import numpy as np

from granulab.contact.files.datafile import below_header, is_file
from granulab.contact.files.units import to_si
from granulab.contact.laws import LinearLaw
from granulab.errors import InputError
from silo2d.case.settings import Settings
from silo2d.engine.beds.laws import CohesiveLaw, CurveLaw
from silo2d.engine.pair_law import Law

# Points of even distance that stand for a curve: as many as keep its own within a hundredth.
_POINTS, _MOST_POINTS, _WITHIN = 1024, 2**16, 0.01
Laws = tuple[LinearLaw, LinearLaw]


def curve_file(settings: Settings, folder: Path) -> dict[str, Path]:
    """The file of the curve, by its name in a run folder; none where the case has no curve."""
    name = settings.law.kn_curve
    return {} if name is None else {"kn_curve.csv": folder / name}


def with_curve(laws: Laws, settings: Settings, folder: Path, where: str) -> tuple[Law, Law] | None:
    """The laws with the measured curve of the case, None where it has none.

    kn of the laws is the steepest part of the curve. Raises InputError for a curve that cannot be
    read or does not rise from nothing, and for keys that do not go with it.
    """
    law = settings.law
    if law.kn_curve is None:
        return None
    for key, given in (
        ("kn", law.kn is not None), ("cohesion", law.cohesion is not None),
        ("damping", law.damping == "restitution"), ("keep_ratios", law.keep_ratios),
    ):  # fmt: skip
        if given:
            raise InputError(
                f"{where}: [law] kn_curve does not go with {key}; leave one of them out"
            )
    path = folder / law.kn_curve
    overlap, force = read_curve(path, f"{where}: [law] kn_curve")
    spacing, even = _even(overlap, force, path)
    energy = np.append(0.0, np.cumsum(0.5 * spacing * (even[1:] + even[:-1])))
    kn = float((np.diff(force) / np.diff(overlap)).max())
    first, second = (CurveLaw(*one._replace(kn=kn), spacing, even, energy) for one in laws)
    return first, second


def _even(overlap: np.ndarray, force: np.ndarray, path: Path) -> tuple[float, np.ndarray]:
    """Distance [m] and forces (n,) [N] of even points that stand for a curve from 0 on."""
    n = _POINTS
    while True:
        spacing = float(overlap[-1]) / (n - 1)
        at = spacing * np.arange(n)
        even = np.interp(at, overlap, force)
        off = np.abs(np.interp(overlap[1:], at, even) / force[1:] - 1)
        if off.max() <= _WITHIN:
            return spacing, even
        if n == _MOST_POINTS:
            k = int(off.argmax()) + 1
            raise InputError(
                f"{path}: overlap = {1e3 * overlap[k]:g} mm: the curve bends too sharply there for "
                f"the {n} even points up to {1e3 * overlap[-1]:g} mm that stand for it; leave this "
                "point out, or end the curve before"
            )
        n *= 2


def with_cohesion(laws: Laws, settings: Settings, length: float) -> tuple[Law, Law]:
    """The laws with the cohesion of the case over a length of contact [m]; as they are without."""
    if settings.law.cohesion is None:
        return laws
    pull = settings.law.cohesion * length
    return CohesiveLaw(*laws[0], pull), CohesiveLaw(*laws[1], pull)


def check_laws(settings: Settings, where: str) -> None:
    """Raise InputError where laws that are not linear meet what needs the linear one."""
    law = settings.law
    for key, given in (("cohesion", law.cohesion), ("kn_curve", law.kn_curve)):
        if given is not None and settings.disorder.per != "none":
            raise InputError(
                f"{where}: [disorder] draws constants of the linear law; leave it out, or "
                f"[law] {key}"
            )
        if given is not None and settings.run.engine == "pymunk":
            raise InputError(f"{where}: [law] {key} needs engine = 'dem'; leave one of them out")


def read_curve(path: Path, field: str) -> tuple[np.ndarray, np.ndarray]:
    """Overlaps (n,) [m] and forces (n,) [N] of one contact, from 0 on, of a CSV file.

    A header line, then an overlap and a force with their units in each row, such as "0.01 mm,95 N".
    """
    if not is_file(path):
        raise InputError(f"{field} = {path.name!r}: no such file next to the case")
    rows = below_header(path, "the curve", "overlap,force")
    if len(rows) < 2 or any(len(row) != 2 for row in rows):
        raise InputError(
            f"{path}: expected a line 'overlap,force' and rows such as '0.01 mm,95 N', two at least"
        )
    overlap = np.array([to_si(row[0], "m", f"{path}: overlap") for row in rows])
    force = np.array([to_si(row[1], "N", f"{path}: force") for row in rows])
    if overlap[0] > 0.0:
        overlap, force = np.append(0.0, overlap), np.append(0.0, force)
    if overlap[0] or force[0] or (np.diff(overlap) <= 0).any() or (np.diff(force) <= 0).any():
        raise InputError(f"{path}: overlap and force must rise from 0 to the last row")
    return overlap, force
