"""Several dampers on one host: the document of each, and what they must have in common."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from damper3d.case.host.modes import given
from damper3d.case.settings import Damper, Settings
from granulab.contact.files.casefile import Section
from granulab.errors import InputError

if TYPE_CHECKING:
    from damper3d.case.case import DamperCase

_OWN = ("enclosure", "particles", "law")  # sections of which a damper may have keys of its own
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
    found = []
    for k, own in enumerate(dampers):
        here = f"{where}: [[damper]] {k + 1}"
        if host.at is not None:
            raise InputError(f"{here}: [host] at is of a single damper; give at in each [[damper]]")
        copied = {name: value for name, value in document.items() if name != "damper"}
        for name in _OWN:
            table = getattr(own, name) or {}
            if "materials" in table:
                raise InputError(
                    f"{here}: particles.materials: all dampers have one file; give it in "
                    "[particles], and the material here"
                )
            copied[name] = {**copied.get(name, {}), **table}
        run = copied.get("run", {})
        seed = settings.run.seed + k * SEEDS_APART if own.seed is None else own.seed
        at = {} if own.at is None else {"at": own.at}
        copied["run"] = {**run, "seed": seed}
        copied["host"] = {**copied["host"], **at}
        found.append((copied, here))
    return found


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
