"""Options of a command that change keys of a case; they are made from the simulator's schema."""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from granulab.contact.files.casefile import Section
    from granulab.contact.files.reference import Key


class CaseCommand(click.Command):
    """A command with an option for each key of a case that has one, or for `keys` alone.

    keys: "section.key", and what their help says besides the meaning of the key; without: keys
    that the command sets itself, and what to give in place of their options.

    schema: gives the settings of the simulator, and is called only when the options are
    needed, so that the other commands do without pydantic; also: gives further settings, of
    sections of other names. The command's function gets the values as `section__key`, see
    case_changes.
    """

    def __init__(
        self,
        *arguments: Any,
        schema: Callable[[], "type[Section]"],
        keys: Mapping[str, str] = MappingProxyType({}),
        without: Mapping[str, str] = MappingProxyType({}),
        also: "Callable[[], type[Section]] | None" = None,
        **options: Any,
    ) -> None:
        super().__init__(*arguments, **options)
        self._schema, self._keys, self._without, self._also = schema, keys, without, also
        self._case_options: list[click.Parameter] | None = None

    def get_params(self, context: click.Context) -> list[click.Parameter]:
        """The arguments, the options of the case, and the command's own options."""
        if self._case_options is None:
            self._case_options = _options(self._schema(), self._keys, self._without)
            if self._also is not None:
                self._case_options += _options(self._also(), {}, {})
        given = super().get_params(context)
        first = sum(isinstance(one, click.Argument) for one in given)
        return [*given[:first], *self._case_options, *given[first:]]


def _options(
    schema: "type[Section]", keys: Mapping[str, str], without: Mapping[str, str]
) -> list[click.Parameter]:
    from granulab.contact.files.reference import keys_of

    every = {f"{key.section}.{key.name}": key for key in keys_of(schema)}
    chosen = keys or {name: "" for name, key in every.items() if key.option}
    return [
        _option(every[name], more) if name not in without else _refusal(every[name], without[name])
        for name, more in chosen.items()
    ]


def _refusal(key: "Key", cure: str) -> click.Option:
    """An option that the command does not take and its help does not show; it says what would."""

    def refuse(context: click.Context, option: click.Parameter, value: Any) -> None:
        if value is not None:
            raise click.UsageError(f"{option.opts[0]}: not taken here; {cure}")

    flag = key.option or f"--{key.name.replace('_', '-')}"
    value: dict[str, Any] = {"hidden": True, "expose_value": False, "callback": refuse}
    if key.kind == "boolean":
        value |= {"flag_value": "yes", "default": None}
    return click.Option([flag], help=f"Not taken; {cure}.", **value)


def _option(key: "Key", more: str) -> click.Option:
    flag = key.option or f"--{key.name.replace('_', '-')}"
    names = [flag, f"{key.section}__{key.name}"]
    text = f"{key.meaning[0].upper()}{key.meaning[1:]}{more}."
    if key.kind == "boolean":
        if not key.has_default:  # left out, it is neither
            names[0] = f"{flag}/--no-{flag.removeprefix('--')}"
        return click.Option(names, is_flag=True, default=None, help=text)
    kind = _WholeNumber() if key.kind == "integer" else click.STRING
    return click.Option(names, type=kind, metavar=_metavar(key), help=text)


def _metavar(key: "Key") -> str:
    """An example of the option's value as it is typed in a shell."""
    if key.metavar or key.choices:
        return key.metavar or "|".join(key.choices)
    return key.written if " " in key.written else key.written.strip('"')


class _WholeNumber(click.ParamType):
    """A whole number; another text is left to the case, which refuses it as any other key."""

    name = "integer"

    def convert(self, value: Any, *_: Any) -> Any:
        """The number, or the text."""
        try:
            return int(value)
        except ValueError:
            return value


def case_changes(options: dict[str, Any]) -> dict[str, Any]:
    """The keys of the case that options change, as they would stand in a file."""
    return {name.replace("__", "."): value for name, value in options.items() if value is not None}
