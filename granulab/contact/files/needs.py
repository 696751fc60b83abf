"""Keys of a materials file that the simulators need, and all that a file lacks at once."""

from collections.abc import Callable, Iterable
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

from granulab.contact.files.datafile import content_of, read_toml
from granulab.contact.files.schema import (
    SCHEMA,
    LinearTable,
    MaterialTable,
    PairTable,
    missing_keys,
    missing_words,
    section,
)
from granulab.contact.files.table import ContactTable, load_table, refuse_turned, two_names
from granulab.contact.files.units import located, nearest
from granulab.errors import InputError

Keys = list[tuple[str, str]]  # section, as in "pair.wood-wood.linear", and key


class Needs(NamedTuple):
    """Keys that a simulator takes of a file."""

    program: str
    particle: tuple[str, ...]  # of the material of the particles
    wall: tuple[str, ...]  # of that of the walls
    pair: tuple[str, ...]  # of the pairs of two particles, and of a particle and a wall
    besides: tuple[str, ...]  # not needed, and of use; a file that `init` writes has them


SILO = Needs(
    "silo2d",
    ("density", "length"),
    ("density",),
    ("friction", "kn", "kt", "gamma_n", "gamma_t"),
    ("restitution",),
)
_ELASTIC = ("density", "youngs_modulus", "poisson")
DAMPER = Needs("damper3d", _ELASTIC, _ELASTIC, ("friction", "restitution"), ("yield_strength",))


def keys_needed(needs: Needs, particle: str, wall: str) -> Keys:
    """Sections and keys of the two materials and their two pairs."""
    pairs = dict.fromkeys([f"{particle}-{particle}", f"{particle}-{wall}"])
    materials = dict.fromkeys((particle, key) for key in needs.particle)
    materials |= dict.fromkeys((wall, key) for key in needs.wall)
    return [
        *((f"material.{name}", key) for name, key in materials),
        *((_section(f"pair.{names}", key), key) for names in pairs for key in needs.pair),
    ]


def with_besides(needs: Needs, needed: Keys) -> Keys:
    """The keys, section by section, with those of use that are not needed."""
    found: Keys = []
    for where in dict.fromkeys(where for where, _ in needed):
        kind = "pair" if where.startswith("pair.") else "material"
        fields = _FIELDS[kind] if where.count(".") == 1 else ()
        found += [one for one in needed if one[0] == where]
        found += [(where, key) for key in needs.besides if key in fields]
    return found


_FIELDS = {"material": tuple(MaterialTable.model_fields), "pair": tuple(PairTable.model_fields)}


def _section(where: str, key: str) -> str:
    return f"{where}.linear" if key in LinearTable.model_fields else where


def tables_in(path: Path) -> dict[str, Any]:
    """The tables of a materials file; none of one that is wrong, which table_with refuses."""
    try:
        tables = read_toml(path, "materials", SCHEMA)
        missing_keys(path, tables)
    except InputError:
        return {}
    return tables


def materials_of(
    tables: dict[str, Any], given: tuple[str | None, str | None], usual: tuple[str, str]
) -> tuple[str, str]:
    """Names of the materials of particles and walls that a case takes of a file's tables.

    given: names, None where left out; usual: those and what stands for the others. Where the file
    does not hold the usual ones, it is its only pairing, if that has the given ones.
    """
    if all(name in _materials(tables) for name in usual):
        return usual
    found = [
        pairing
        for pairing in _pairings(tables)
        if all(name in (None, own) for name, own in zip(given, pairing, strict=True))
    ]
    return found[0] if len(found) == 1 else usual


def refuse_lacking(path: Path, needed: Keys, cure: Callable[[Keys], str]) -> None:
    """Raise InputError, one line with all that a file lacks of what is needed.

    cure: its end, of what is absent. A file that is wrong otherwise is refused as by load_table.
    """

    def words(tables: dict[str, Any]) -> str:
        absent = _all(missing_keys(path, tables), _absent(tables, needed))
        if not absent:
            return ""
        return "; ".join([missing_words(absent), *_hints(tables, absent), cure(absent)])

    if line := words(read_toml(path, "materials", SCHEMA, words)):
        raise InputError(f"{path}: {line}")


def table_with(file: str | Path, needed: Keys, cure: Callable[[Keys], str]) -> ContactTable:
    """The table of a materials file that has all keys needed; the same object for the same text.

    Raises InputError, see refuse_lacking and load_table.
    """
    content = content_of(file)
    _complete(file, content, tuple(needed), cure)
    return _loaded(file, content)


@lru_cache(maxsize=64)
def _complete(
    file: str | Path,
    _content: bytes,
    needed: tuple[tuple[str, str], ...],
    cure: Callable[[Keys], str],
) -> None:
    refuse_lacking(Path(file), list(needed), cure)


@lru_cache(maxsize=8)
def _loaded(file: str | Path, _content: bytes) -> ContactTable:
    return load_table(file)


def lacking(path: Path, tables: dict[str, Any]) -> list[str]:
    """Keys that simulators need and the tables of an unfinished file do not have yet.

    As in "[pair.wood-steel] friction", followed by the simulator where only one needs it. A file
    with what only a silo takes is for a silo; one that is enough for a simulator lacks nothing.
    Raises InputError for a wrong key or structure, and for pairs named wrongly or twice.
    """
    missing = missing_keys(path, tables)
    _refuse_names(path, tables)
    must = _all(missing, _unnamed(tables))
    must = [(where, key) for where, key in must if key]
    silo, damper = (
        _all(must, *(_absent(tables, keys_needed(one, *pair)) for pair in _pairings(tables)))
        for one in (SILO, DAMPER)
    )
    silo = [
        (where, key)
        for where, key in silo
        if not (_follows(tables, where, key) or follows_from_modulus(tables, where, key))
    ]
    damper = [(where, key) for where, key in damper if not follows_from_loss(tables, where, key)]
    if not must and not (silo and damper):
        return []
    if _is_of_a_silo(tables):
        return [f"[{where}] {key}" for where, key in sorted(silo, key=lambda one: one[0])]
    by_program = {SILO.program: silo, DAMPER.program: damper}
    found = []
    for where, key in sorted(_all(silo, damper), key=lambda one: one[0]):
        takers = [name for name, keys in by_program.items() if (where, key) in keys]
        only = f" ({takers[0]})" if len(takers) == 1 else ""
        found.append(f"[{where}] {key}{only}")
    return found


def _refuse_names(path: Path, tables: dict[str, Any]) -> None:
    """Raise InputError for a pair that is not named by two materials, or is given both ways."""
    pairs = tables.get("pair", {})
    both = {tuple(names.split("-")) for names in pairs}
    for names in pairs:
        with located(f"{path}: {section('pair', names)}"):
            refuse_turned(*two_names(names), both)


def lacking_words(keys: Iterable[str]) -> str:
    """Words on what `lacking` gives, each section named once."""
    by_section: dict[str, list[str]] = {}
    for one in keys:
        where, _, key = one.partition("] ")
        by_section.setdefault(f"{where}]", []).append(key)
    return "; ".join(f"{where} {', '.join(names)}" for where, names in by_section.items())


def _all(*parts: Keys) -> Keys:
    return list(dict.fromkeys(key for part in parts for key in part))


def _absent(tables: dict[str, Any], needed: Keys) -> Keys:
    """Sections and keys, of those needed, that the tables do not have."""
    return [(where, key) for where, key in needed if key not in _table(tables, where)]


def _table(tables: dict[str, Any], where: str) -> dict[str, Any]:
    """The table of a section; of a pair in either order; empty where there is none."""
    kind, names, *linear = where.split(".")
    known = tables.get(kind, {})
    first, _, second = names.partition("-")
    found = known.get(names, known.get(f"{second}-{first}" if kind == "pair" else names, {}))
    return found.get("linear", {}) if linear else found


def _unnamed(tables: dict[str, Any]) -> Keys:
    """Density of the materials that pairs name and the file does not have."""
    named = dict.fromkeys(name for pair in tables.get("pair", {}) for name in pair.split("-"))
    return [(f"material.{name}", "density") for name in named if name not in _materials(tables)]


def _materials(tables: dict[str, Any]) -> dict[str, Any]:
    return tables.get("material", {})


def _pairings(tables: dict[str, Any]) -> list[tuple[str, str]]:
    """Particles and walls that a file is about: a pair of a material with itself is of particles.

    Without one, a pair's first name is that of the particles. A material without a pair with
    another stands for walls too.
    """
    pairs = [tuple(names.split("-")) for names in tables.get("pair", {}) if names.count("-") == 1]
    own = [first for first, second in pairs if first == second]
    particles = own or [first for first, _ in pairs] or list(_materials(tables))[:1]
    found = []
    for particle in dict.fromkeys(particles):
        walls = [b if a == particle else a for a, b in pairs if particle in (a, b) and a != b]
        found += [(particle, wall) for wall in walls or [particle]]
    return found


def _follows(tables: dict[str, Any], where: str, key: str) -> bool:
    """True for a damping where the pair's restitution is known: [law] damping takes that."""
    restitution = "restitution" in _table(tables, where.removesuffix(".linear"))
    return key in ("gamma_n", "gamma_t") and restitution


def follows_from_loss(tables: dict[str, Any], where: str, key: str) -> bool:
    """True for the restitution of a pair whose materials both have a loss factor."""
    kind, _, names = where.partition(".")
    if (kind, key) != ("pair", "restitution") or not isinstance(_materials(tables), dict):
        return False
    found = [_materials(tables).get(name) for name in names.split("-")]
    return all(isinstance(table, dict) and "loss_factor" in table for table in found)


def follows_from_modulus(tables: dict[str, Any], where: str, key: str) -> bool:
    """True for kn, kt and gamma_t of a pair that has neither kn nor kt, but E and nu of both.

    See silo2d.case.beds.elastic.
    """
    kind, _, names = where.partition(".")
    if kind != "pair" or key not in ("kn", "kt", "gamma_t") or not where.endswith(".linear"):
        return False
    linear = _table(tables, where)
    found = [_materials(tables).get(name, {}) for name in names.removesuffix(".linear").split("-")]
    elastic = all("youngs_modulus" in one and "poisson" in one for one in found)
    return elastic and not ("kn" in linear or "kt" in linear)


def damping_is_left_out(tables: dict[str, Any], where: str) -> bool:
    """True where a pair's kn follows from E and nu, and its table has no gamma_n either."""
    return follows_from_modulus(tables, where, "kn") and "gamma_n" not in _table(tables, where)


def _is_of_a_silo(tables: dict[str, Any]) -> bool:
    """True where a file has what only a silo takes."""
    return any("length" in table for table in _materials(tables).values()) or any(
        "linear" in table for table in tables.get("pair", {}).values()
    )


def _hints(tables: dict[str, Any], absent: Keys) -> list[str]:
    """Words on what the file holds instead, where a whole material or pair is not there."""
    for where in dict.fromkeys(where for where, key in absent if key):
        kind, name, *linear = where.split(".")
        if not linear and not _table(tables, where):
            return [f"no {kind} {name!r} there; {nearest(name, tables.get(kind, {}))}"]
    return []
