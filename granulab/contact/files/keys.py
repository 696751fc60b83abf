"""Keys of a case file as a study takes them: read to SI, written back, named with units."""

from dataclasses import dataclass
from typing import Any

from granulab.contact.files.casefile import (
    Section,
    Unit,
    known_keys,
    marks_of,
    takes_truth,
    unit_of,
)
from granulab.contact.files.units import nearest, to_si, unit_in
from granulab.errors import InputError


@dataclass(frozen=True)
class Keys:
    """The keys "section.key" of a simulator's case files."""

    settings: type[Section]  # whose fields are the sections of a case file

    def read(self, where: str, key: str, value: Any) -> Any:
        """A value as written for a key: a number in SI where the key takes quantities.

        Raises InputError, one line that begins with `where`, for an unknown key or a bad unit.
        """
        try:
            field = self._field(key)
        except InputError as error:
            raise InputError(f"{where} {error}") from None
        if not _is_quantity(field) or (isinstance(value, bool) and takes_truth(field)):
            return value
        return to_si(value, unit_of(field), f"{where} {key}")

    def written(self, key: str, value: Any) -> Any:
        """A value of a key in SI as it would stand in a case file."""
        field = self._field(key)
        unit = unit_of(field)
        return f"{value!r} {unit}" if _is_quantity(field) and unit != "1" else value

    def unit(self, key: str) -> str:
        """The SI unit of a key, "1" for a pure number or a word."""
        return unit_of(self._field(key))

    def shown(self, key: str) -> tuple[str, float]:
        """The unit in which a case file has a key, "" for none, and how much of SI it is."""
        field = self._field(key)
        unit, extra = unit_of(field), field.json_schema_extra or {}
        if unit == "1":
            return extra.get("plain_unit", ""), 1.0
        own = unit_in(str((field.examples or [field.default])[0])) or unit
        return own, to_si(f"1 {own}", unit, key)

    def column(self, key: str) -> str:
        """The name of a key's column in a table: "law.kn_n_per_m"."""
        unit = unit_of(self._field(key)).lower()
        if unit == "1":
            return key
        above, _, below = unit.partition("/")
        parts = [key, *([above] if above != "1" else []), *(["per", below] if below else [])]
        return "_".join(parts)

    def _field(self, key: str) -> Any:
        section, _, name = key.partition(".")
        known = known_keys(self.settings)
        if name not in known.get(section, []):
            every = [f"{section}.{name}" for section, names in known.items() for name in names]
            close = [each for each in every if each.startswith(f"{section}.")] or every
            raise InputError(f"unknown key {key!r}; {nearest(key, close)}")
        section_class: Any = self.settings.model_fields[section].annotation
        return section_class.model_fields[name]


def _is_quantity(field: Any) -> bool:
    return any(isinstance(mark, Unit) for mark in marks_of(field))
