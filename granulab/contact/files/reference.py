"""Texts made from a schema: a case file with a comment on every key, and tables of the keys."""

import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from granulab.contact.files.casefile import Section, marks_of, sections, toml_value, unit_of
from granulab.contact.files.needs import Needs, keys_needed, with_besides
from granulab.contact.files.schema import SCHEMA
from granulab.contact.files.table import ContactTable, entry_of, toml_entry
from granulab.contact.material import PROPERTIES, Measured

_COLUMN = 35  # where comments begin in a commented case
_WIDTH = 100


@dataclass(frozen=True)
class Key:
    """A key of a case file as people read of it; texts, but for what stands in the schema."""

    section: str
    name: str
    meaning: str
    written: str  # its default or an example, as TOML
    has_default: bool
    spelled_out: bool  # written by `init`, rather than as a comment
    left_out: str  # what holds without the key, if it has no default
    unit: str  # SI unit of a quantity, "" of all else
    takes: str  # range or choices
    kind: str  # "boolean", "integer", "number", "string", "array" or "" (several)
    choices: tuple[str, ...]
    option: str | None  # flag of the commands that changes it
    metavar: str | None

    @property
    def default(self) -> str:
        """The default as it would be written, or what holds without one."""
        return f"`{self.written}`" if self.has_default else self.left_out


def keys_of(settings: type[Section]) -> Iterator[Key]:
    """The keys of all sections of a case file, in their order."""
    for section, model in sections(settings).items():
        schema = model.model_json_schema()["properties"]
        for name, field in model.model_fields.items():
            yield _key(section, name, field, schema[name])


def _key(section: str, name: str, field: Any, schema: dict[str, Any]) -> Key:
    kinds = [kind for kind in schema.get("anyOf", [schema]) if kind.get("type") != "null"]
    unit = unit_of(field)
    example = (schema.get("examples") or [None])[0]
    return Key(
        section,
        name,
        meaning=schema.get("description", ""),
        written=toml_value(*(field.default, unit) if example is None else (example,)),
        has_default=field.default is not None,
        spelled_out=field.default is not None or schema.get("spelled_out", False),
        left_out=schema.get("left_out", ""),
        unit=schema.get("plain_unit", "") if unit == "1" else unit,
        takes=", ".join([" or ".join(map(_takes, kinds)), *_bounds(field)]),
        kind=kinds[0]["type"] if len(kinds) == 1 else "",
        choices=tuple(kinds[0].get("enum", ())),
        option=schema.get("option"),
        metavar=schema.get("metavar"),
    )


def _takes(kind: dict[str, Any]) -> str:
    """The range of one kind of value, such as "above 0"."""
    if "enum" in kind:
        return ", ".join(f'`"{word}"`' for word in kind["enum"])
    if kind["type"] == "boolean":
        return "`true`, `false`"
    if kind["type"] == "array":
        count = f"{kind['minItems']} " if "minItems" in kind else ""
        inner = {"number": "numbers", "array": "points"}.get(kind["items"].get("type"), "tables")
        return f"list of {count}{inner}"
    if kind["type"] == "string":
        return "text"
    if kind["type"] == "object":
        return "table of texts"
    return "whole number" if kind["type"] == "integer" else "number"


def _bounds(field: Any) -> list[str]:
    """The range of a number, such as ["above 0", "at most 1"]."""
    found = {}
    for mark in marks_of(field):
        for bound, words in (
            ("gt", "above"),
            ("ge", "at least"),
            ("lt", "below"),
            ("le", "at most"),
        ):
            if getattr(mark, bound, None) is not None:
                found[words] = f"{words} {getattr(mark, bound):,}"
    if "above" in found:
        found.pop("at least", None)  # which the type alone would take
    return list(found.values())


def commented_case(
    settings: type[Section],
    head: str,
    name: str,
    schema: int,
    values: Mapping[str, Any] = MappingProxyType({}),
) -> str:
    """A case file with a comment on every key; what stands in it are the defaults.

    head: of the file; values: by "section.key", what is written instead; None: a comment. Keys
    without a default are comments themselves, with an example.
    """
    lines = [*_comment(head), f"schema = {schema}"]
    lines += _commented(f"name = {toml_value(name)}", "the run folder is called after it")
    for section, model in sections(settings).items():
        lines += ["", f"[{section}]", *_comment(_text(model))]
        for key in keys_of(settings):
            if key.section == section:
                lines += _commented(_entry(key, values), _remark(key))
    return "\n".join(lines) + "\n"


def commented_file(
    settings: type[Section], head: str, schema: int, values: Mapping[str, Any]
) -> str:
    """A file of keys without sections, with a comment on every key.

    values: what is written for keys, where it is not the default.
    """
    lines = [*_comment(head), f"schema = {schema}"]
    for key in plain_keys(settings):
        written = toml_value(values[key.name]) if key.name in values else key.written
        lines += _commented(f"{key.name} = {written}", _remark(key))
    return "\n".join(lines) + "\n"


def commented_materials(needs: Needs, particle: str, wall: str, example: ContactTable) -> str:
    """A materials file of two materials and their pairs, with a comment on every key.

    example: holds them; its values alone are written, not where they are from.
    """
    head = (
        f"Materials and contact parameters for {needs.program}. What stands here are values of "
        f"{' and '.join(dict.fromkeys([particle, wall]))}, as an example: replace them by yours, "
        "names of materials too (a case names them). An entry may say what is known of it: "
        '{ value = "0.45 g/cm3", sigma = "6 %", source = "weighed, five particles" }; '
        "`calibrate ... --into FILE` writes such entries from measurements."
    )
    lines, last = [*_comment(head), f"schema = {SCHEMA}"], ""
    for where, name in with_besides(needs, keys_needed(needs, particle, wall)):
        known = entry_of(example, where, name)
        if known is None:
            continue
        if where != last:
            lines += ["", f"[{where}]"]
            last = where
        lines += _commented(f"{name} = {toml_entry(name, Measured(known.value))}",
                            PROPERTIES[name].meaning)  # fmt: skip
    return "\n".join(lines) + "\n"


def plain_keys(settings: type[Section]) -> Iterator[Key]:
    """The keys of a file without sections, in their order."""
    schema = settings.model_json_schema()["properties"]
    for name, field in settings.model_fields.items():
        yield _key("", name, field, schema[name])


def _entry(key: Key, values: Mapping[str, Any]) -> str:
    """A key as a line of a case file, a comment where it is left out."""
    own = f"{key.section}.{key.name}"
    if values.get(own) is not None:
        return f"{key.name} = {toml_value(values[own])}"
    left_out = own in values or not key.spelled_out
    return f"{'# ' * left_out}{key.name} = {key.written}"


def _remark(key: Key) -> str:
    words = key.meaning
    if key.choices:
        named = f"{key.written} {key.meaning}"
        other = [f'"{word}"' for word in key.choices if f'"{word}"' not in named]
        words += f"; or {', '.join(other)}" if other else ""
    return f"{words}; left out: {key.left_out}" if key.left_out else words


def _commented(entry: str, remark: str) -> list[str]:
    """A line of TOML with its comment behind it, or above it where the line is long."""
    if len(entry) >= _COLUMN:
        return [*_comment(remark), entry]
    first, *others = textwrap.wrap(remark, _WIDTH - _COLUMN - 2)
    return [f"{entry:{_COLUMN}}# {first}", *(f"{'':{_COLUMN}}# {line}" for line in others)]


def _comment(text: str) -> list[str]:
    return [f"# {line}" for line in textwrap.wrap(text, _WIDTH - 2)]


def _text(model: type[Section]) -> str:
    """The docstring of a section in one line."""
    return " ".join((model.__doc__ or "").split())


def key_tables(settings: type[Section]) -> str:
    """The keys of a case file as Markdown, a table for each section."""
    parts = []
    for section, model in sections(settings).items():
        rows = [_row(key) for key in keys_of(settings) if key.section == section]
        parts.append(
            f"### [{section}]\n\n{_text(model)}\n\n"
            "| key | unit | default | takes | meaning | option |\n|---|---|---|---|---|---|\n"
            + "\n".join(rows)
        )
    return "\n\n".join(parts) + "\n"


def plain_table(settings: type[Section]) -> str:
    """The keys of a file without sections as Markdown."""
    rows = [f"| `{key.name}` | {key.default} | {key.meaning} |" for key in plain_keys(settings)]
    return "\n".join(["| key | default | meaning |", "|---|---|---|", *rows]) + "\n"


def _row(key: Key) -> str:
    example = "" if key.has_default else f" (such as `{key.written}`)"
    option = f"`{key.option}`" if key.option else ""
    cells = (f"`{key.name}`", key.unit, key.default, key.takes, key.meaning + example, option)
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"
