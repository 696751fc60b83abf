"""Forms of the page: keys of a case from its schema, options of a command from the command.

What a person writes into a form is text. A text becomes the value that would stand in a case file:
quantities and words stay text, all else is read as TOML reads it.
"""

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import click

from granulab.contact.files.casefile import Section, sections, toml_value
from granulab.contact.files.reference import Key, keys_of
from granulab.contact.files.units import is_plain_number
from granulab.errors import InputError

Texts = dict[str, Any]  # name, and by section the texts of its keys; or one text of a whole table

_FLAG = "yes"


def case_form(settings: type[Section]) -> list[dict[str, Any]]:
    """The sections of a case file with their keys, for inputs."""
    by_section: dict[str, list[Key]] = {}
    for key in keys_of(settings):
        by_section.setdefault(key.section, []).append(key)
    return [
        {
            "name": name,
            "meaning": " ".join((model.__doc__ or "").split()),
            "keys": [_input(key) for key in by_section[name]],
        }
        for name, model in sections(settings).items()
    ]


def _input(key: Key) -> dict[str, Any]:
    choices = [*key.choices] or (["true", "false"] if key.kind == "boolean" else [])
    return {
        "name": key.name,
        "meaning": key.meaning,
        "unit": key.unit,
        "takes": key.takes.replace("`", ""),
        "choices": choices,
        "rows": 3 if key.kind in ("array", "object") else 1,
        "usual": _plain(key.written) if key.has_default else key.left_out,
        "example": "" if key.has_default else _plain(key.written),
    }


def _plain(written: str) -> str:
    """A value as a person writes it into an input, from TOML: without quotation marks."""
    return tomllib.loads(f"x = {written}")["x"] if written.startswith('"') else written


def document(settings: type[Section], texts: Texts) -> dict[str, Any]:
    """The tables of a case file from the texts of a form; empty texts are keys left out.

    Whether they can stand in a case is for its schema to say.
    """
    known = {(key.section, key.name): key for key in keys_of(settings)}
    tables: dict[str, Any] = {}
    for section, table in texts.items():
        if isinstance(table, Mapping):
            values = {
                name: _value(known.get((section, name)), text)
                for name, text in table.items()
                if str(text).strip()
            }
            if values:
                tables[section] = values
        elif str(table).strip():
            tables[section] = str(table).strip() if section == "name" else _read(str(table))
    return tables


def _value(key: Key | None, text: Any) -> Any:
    """A text as the value that a case file would have."""
    text = str(text).strip()
    kind = "" if key is None else key.kind
    if kind == "string" or (kind == "number" and not is_plain_number(text)):
        return text
    return _read(text)


def _read(text: str) -> Any:
    """The value of a text in TOML; the text itself where it is none."""
    if text.lower() in ("nan", "inf", "+inf", "-inf"):
        return text
    try:
        found = tomllib.loads(f"x = {text}")
    except (ValueError, RecursionError):
        return text
    return found["x"] if len(found) == 1 else text


def texts_of(tables: Mapping[str, Any]) -> Texts:
    """The texts of a form from the tables of a case file."""
    return {
        section: {name: _text(value) for name, value in table.items()}
        if isinstance(table, Mapping)
        else _text(table)
        for section, table in tables.items()
    }


def _text(value: Any) -> str:
    return value if isinstance(value, str) else toml_value(value)


def to_toml(tables: Mapping[str, Any], schema: int, head: str) -> str:
    """A case file of the keys that are given, as they are written; head: its first line."""
    lines = [f"# {head}", f"schema = {schema}"]
    plain = {name: value for name, value in tables.items() if not isinstance(value, Mapping)}
    lines += [f"{name} = {toml_value(value)}" for name, value in plain.items()]
    for section, table in tables.items():
        if isinstance(table, Mapping):
            lines += ["", f"[{section}]"]
            lines += [f"{name} = {toml_value(value)}" for name, value in table.items()]
    return "\n".join(lines) + "\n"


# Options that the page sets itself, or that are for a terminal.
_OWN = {"quiet", "as_json", "out", "output", "workers", "engine", "scheduler", "resume",
        "again", "dry_run", "no_figures", "version", "table", "interactive"}  # fmt: skip


def command_form(command: click.Command) -> dict[str, Any]:
    """The inputs of a command: its files, and its options but for those that the page sets."""
    context = click.Context(command)
    arguments = [one for one in command.get_params(context) if isinstance(one, click.Argument)]
    return {
        "meaning": (command.help or "").partition("\n\n")[0].replace("\n", " "),
        "help": command.help or "",
        "files": [{"name": one.name, "several": one.nargs == -1} for one in arguments],
        "options": [
            {
                "name": option.opts[-1].removeprefix("--"),
                "meaning": option.help or "",
                "example": (option.metavar or "").strip('"'),
                "choices": [_FLAG] if option.is_flag else _choices(option),
                "several": option.multiple,
            }
            for option in _options(command, context)
        ],
    }


def _options(command: click.Command, context: click.Context) -> Iterator[click.Option]:
    for one in command.get_params(context):
        helps = one.opts == context.help_option_names[:1]
        if isinstance(one, click.Option) and not (one.name in _OWN or one.hidden or helps):
            yield one


def _choices(option: click.Option) -> list[str]:
    return [str(one) for one in getattr(option.type, "choices", ())]


def command_line(command: click.Command, texts: Mapping[str, Any]) -> list[str]:
    """The options of a command line from the texts of a form; several of one stand on lines.

    Raises InputError for an option that the command has not.
    """
    context = click.Context(command)
    known = {one.opts[-1].removeprefix("--"): one for one in _options(command, context)}
    line: list[str] = []
    for name, text in texts.items():
        text = str(text).strip()
        if name not in known:
            raise InputError(f"--{name}: no option of {command.name}")
        if not text:
            continue
        flag = known[name].opts[-1]
        if known[name].is_flag:
            line.append(flag)
        else:
            values = text.splitlines() if known[name].multiple else [text]
            line += [f"{flag}={value.strip()}" for value in values if value.strip()]
    return line


def as_files(names: Sequence[str]) -> list[str]:
    """Names of files as the last words of a command line, where none can be an option."""
    return ["--", *names] if any(name.startswith("-") for name in names) else [*names]
