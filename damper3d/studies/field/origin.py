"""Origin of a field, and whether a case that it is taken for is of the same bed."""

import math
import re
import sys
from importlib.metadata import version

from damper3d.case.case import DamperCase
from damper3d.case.settings import Particles
from granulab.errors import InputError

_FIRST = re.compile(
    r"effective mass of .*: (?P<count>\d+) particles (?P<particle>.+), (?P<mass>\S+) kg, "
    r"fill ratio \S+, with a lid, (?P<height>\S+) mm high, (?P<orientation>\w+)$"
)
# Keys of sections that say what a field is of; other ones may be left to it.
_KEYS = {
    "motion": {"orientation", "gravity", "direction"},
    "particles": set(Particles.model_fields) - {"materials"},
    "enclosure": {"height"},
}
_OF_LAW = {"particles": {"material", "materials"}, "enclosure": {"material", "materials"}}
_ENCLOSURE, _MOTION, _CONTACTS = "enclosure: ", "motion: ", "contacts: "  # as lines of a head begin
# Keys of [law] whose numbers stand in the words on each pair of materials, or are of the bed.
_OF_PAIRS = {
    "friction", "friction_wall", "restitution", "restitution_wall", "youngs_modulus", "density"
}  # fmt: skip
_MASS = 0.05  # of a bed's, by which drawn sizes may differ, and materials do not so little


def head(case: DamperCase) -> tuple[str, ...]:
    """Lines on where a field comes from: case, version and command."""
    size = f"{case.count} particles {case.particle.name}, {case.mass:.6g} kg"
    return (
        f"effective mass of {case.name}: {size}, fill ratio {case.fill_ratio:.3f}, {lid(case)}",
        _ENCLOSURE + case.enclosure.words,
        _MOTION + _motion(case),
        _CONTACTS + contacts(case),
        f"granulab {version('granulab')}, {' '.join(['damper3d', *sys.argv[1:]])}",
        "m' - i m'' with F = omega^2 (m' - i m'') X of x = Re(X exp(i omega t)); half widths of "
        "95 % intervals over the packings",
    )


def lid(case: DamperCase) -> str:
    """The closed ends, in words, and the direction of the motion to gravity."""
    return f"with a lid, {1e3 * case.enclosure.height:g} mm high, {case.orientation}"


def _motion(case: DamperCase) -> str:
    along, down = (" ".join(f"{x + 0.0:.4g}" for x in v) for v in (case.direction, case.gravity))
    return f"along {along}, gravity {down} m/s2"


def contacts(case: DamperCase) -> str:
    """Laws of the contacts of a case, in words that two cases share where their laws are one.

    Keys of [law] that have their defaults are left out, as is what spheres do not depend on.
    """
    own, parts = case.settings.law, []
    for one in case.pairings:
        law, where = one.law, "walls" if one.of_wall else "particles"
        parts.append(
            f"{where} 4/3 E {law.hertz:.4g} Pa, kt/kn {law.tangential:.4g}, mu {law.mu:g}, "
            f"restitution {one.restitution:g}"
        )
    without = _OF_PAIRS | ({"contact_treatment"} if case.of_spheres else set())
    more = own.model_dump(exclude=without, exclude_defaults=True)
    return "; ".join([*parts, *(f"{name} {str(value).lower()}" for name, value in more.items())])


def check_origin(table: str, lines: tuple[str, ...], case: DamperCase) -> None:
    """Raise InputError where a case gives a bed or an orientation that its field is not of.

    table: file of the field, whose head has these lines; one without them is of any bed. Keys that
    the case leaves out are the field's.
    """
    own = _FIRST.match(lines[0]) if lines else None
    if own is None:
        return
    of_motion, of_bed, of_height = (
        getattr(case.settings, section).model_fields_set & keys for section, keys in _KEYS.items()
    )
    bed, mass = f"{case.count} particles {case.particle.name}", f"{case.mass:.6g} kg"
    alike = math.isclose(float(own["mass"]), case.mass, rel_tol=_MASS)
    height = f"{1e3 * case.enclosure.height:g}"
    own_bed = f"{own['count']} particles {own['particle']}"
    _refuse_unless(table, case, "motion", not of_motion or own["orientation"] == case.orientation,
                   own["orientation"], case.orientation)  # fmt: skip
    _refuse_unless(table, case, "particles", not of_bed or (own_bed == bed and alike),
                   f"{own_bed}, {own['mass']} kg", f"{bed}, {mass}")  # fmt: skip
    _refuse_unless(table, case, "enclosure", not of_height or own["height"] == height,
                   f"a height of {own['height']} mm", f"{height} mm")  # fmt: skip
    of_law = case.settings.law.model_fields_set or any(
        getattr(case.settings, section).model_fields_set & keys for section, keys in _OF_LAW.items()
    )
    for section, given, begins, here in (
        ("motion", of_motion, _MOTION, _motion(case)),
        ("enclosure", case.settings.enclosure.model_fields_set, _ENCLOSURE, case.enclosure.words),
        ("law", of_law, _CONTACTS, contacts(case)),
    ):
        there = next((line.removeprefix(begins) for line in lines if line.startswith(begins)), here)
        _refuse_unless(table, case, section, not given or there == here, there, here)


def _refuse_unless(
    table: str, case: DamperCase, section: str, is_same: bool, there: str, here: str
) -> None:
    if not is_same:
        raise InputError(
            f"{table}: a field of {there}, and {case.name} gives {here}: compute its own (damper3d "
            f"field), or leave [{section}] out of the case"
        )
