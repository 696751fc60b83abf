"""Several dampers on one host: the document of each, and what they must have in common."""

import copy
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from damper3d.case.host.modes import given
from damper3d.case.settings import Damper, Settings, check_settings
from granulab.contact.files.casefile import Section
from granulab.errors import InputError

if TYPE_CHECKING:
    from damper3d.case.case import DamperCase

OWN = ("enclosure", "particles", "law")  # sections of which a damper may have keys of its own
# From one damper's seed to the next one's, beyond the seeds 1 to n of a study: where these share a
# packing, the runs of a study are no sample of independent ones.
SEEDS_APART = 10_000


def documents(
    document: dict[str, Any], settings: Settings, where: str
) -> list[tuple[dict[str, Any], str]]:
    """The document of each damper by itself, and what to call it in a refusal.

    InputError where host or dampers are none of which there can be several.
    """
    host, dampers = settings.host, settings.damper or []
    if not given(host):
        raise InputError(f"{where}: [[damper]] is one of several on a host; give [host] too")
    if host.inertia is not None:
        raise InputError(
            f"{where}: [[damper]] and [host] inertia: a host that twists has one damper"
        )
    if (host.shown or 1) > len(dampers):
        raise InputError(f"{where}: [host] shown = {host.shown}: there are {len(dampers)} dampers")
    found, seeds = [], seeds_of(dampers, settings.run.seed)
    for k, own in enumerate(dampers):
        here = f"{where}: [[damper]] {k + 1}"
        if host.at is not None:
            raise InputError(f"{here}: [host] at is of a single damper; give at in each [[damper]]")
        copied = {name: value for name, value in document.items() if name != "damper"}
        for name in OWN:
            table = getattr(own, name) or {}
            if "materials" in table:
                raise InputError(
                    f"{here}: particles.materials: all dampers have one file; give it in "
                    "[particles], and the material here"
                )
            copied[name] = {**copied.get(name, {}), **table}
        at = {} if own.at is None else {"at": own.at}
        copied["run"] = {**copied.get("run", {}), "seed": seeds[k]}
        copied["host"] = {**copied["host"], **at}
        found.append((copied, here))
    return found


def seeds_of(dampers: Sequence[Damper], seed: int) -> list[int]:
    """The seed of each damper of a run with this one."""
    return [
        seed + k * SEEDS_APART if own.seed is None else own.seed for k, own in enumerate(dampers)
    ]


def number_of(dampers: Sequence[Any], which: str, where: str) -> int:
    """Number (from 0) of the damper of a name or number (from 1); InputError where there is none.

    dampers: tables [[damper]] of a document.
    """
    tables = [one if isinstance(one, dict) else {} for one in dampers]
    names = [str(one.get("at", k)) for k, one in enumerate(tables, 1)]
    if names.count(which) == 1:
        return names.index(which)
    if which.isdigit() and 0 < int(which) <= len(names):
        return int(which) - 1
    if not names:
        raise InputError(f"{where}: the case has no [[damper]], but one bed; leave the name out")
    why = "several dampers are" if which in names else "no damper is"
    raise InputError(
        f"{where}: {why} called {which!r}; they are {', '.join(names)}, or numbers from 1"
    )


def with_changes(
    document: dict[str, Any], changes: dict[str, Any], where: str
) -> tuple[dict[str, Any], dict[str, Any]]:
    """The document with the changes of its dampers, and those that are left.

    "damper.<name or number>.<section>.<key>", or .<key>: a key of one damper; "damper": of one the
    name or number, whose bed alone is the case, without the host and what moves it.
    """
    left, document = dict(changes), copy.deepcopy(document)
    for path in [path for path in changes if path.startswith("damper.")]:
        _, which, *keys = path.split(".")
        k = number_of(document.get("damper", []), which, f"{where}: {path}")
        table = document["damper"][k]
        for section in keys[:-1]:
            table = table.setdefault(section, {})
        table[keys[-1]] = left.pop(path)
    which = left.pop("damper", None)
    if which is not None:
        k = number_of(document.get("damper", []), which, where)
        settings = check_settings(document, where)
        document, _ = documents(document, settings, where)[k]
        name = f"{document['name']}-{name_of((settings.damper or [])[k], k)}"
        document = {**document, "name": name}
        for table in ("host", "excitation"):
            document.pop(table, None)
    return document, left


def check_alike(cases: Sequence["DamperCase"], where: str) -> None:
    """Raise InputError for dampers that the kernels cannot take through a step together."""
    kinds = [_kind(case) for case in cases]
    for k, kind in enumerate(kinds):
        for name, value in kind.items():
            if value != kinds[0][name]:
                raise InputError(
                    f"{where}: [[damper]] {k + 1}: {name} {value}, of the first {kinds[0][name]}; "
                    "dampers on one host are alike in this, and may have other sizes, particles "
                    "and materials"
                )
        own = cases[k].files.keys() - cases[0].files.keys()
        meshes = [name for name in cases[k].files if name.endswith(".obj")]
        if own or meshes:
            raise InputError(
                f"{where}: [[damper]] {k + 1}: {next(iter(own or meshes))}: several dampers on a "
                "host have neither triangulated cavities nor particles from a mesh"
            )


def _kind(case: "DamperCase") -> dict[str, str]:
    """Words for what has kernels of its own."""
    law = case.settings.law
    return {
        "enclosure": case.settings.enclosure.shape,
        "particles": _particles(case),
        "laws": "of one kind" if case.is_plain else "of several kinds, or with more than Hertz's",
        "rolling resistance": "none" if law.rolling_friction is None else "some",
    }


def _particles(case: "DamperCase") -> str:
    if case.of_spheres:
        return "spheres"
    return "multi-sphere particles" + ("" if case.bed is None else " of several shapes or sizes")


def as_given(settings: Settings) -> Settings:
    """The settings with those keys alone that were given: what follows is not written."""
    tables = {
        name: table.model_copy(
            update=dict.fromkeys(type(table).model_fields.keys() - table.model_fields_set)
        )
        for name in type(settings).model_fields
        if isinstance(table := getattr(settings, name), Section)
    }
    return settings.model_copy(update=tables)


def name_of(damper: Damper, k: int) -> str:
    """Name of the damper number k (from 0): its place, or its number."""
    return damper.at or str(k + 1)
