"""Options that the measuring commands share: --out, --into, --pair and --material."""

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from calibration.files.parameter_file import Written
    from calibration.statistics.uncertainty import Estimate

_PAIR_KEYS = ("friction", "restitution", "kn", "kt", "gamma_n", "gamma_t")


@dataclass(frozen=True)
class Into:
    """The parameter file that --into names, and the pair or material to write to."""

    path: Path
    pair: str | None
    material: str | None

    def put(
        self, key: str, estimate: "Estimate", *, method: str, files: Sequence[str | Path] = (),
        source: str | None = None,
    ) -> "Written":  # fmt: skip
        """Write an estimate, in SI, that was measured from files, and say so on stderr.

        source is the names of the files unless given. Raises InputError; see
        calibration.files.parameter_file.into.
        """
        from calibration.files.parameter_file import digest_of, into

        paths = [Path(file) for file in files]
        written = into(
            self.path,
            self._where(key),
            key,
            estimate,
            method=method,
            source=source or ", ".join(path.name for path in paths),
            digest=digest_of(paths) if paths else None,
        )
        click.echo(said(written), err=True)
        return written

    def takes(self, key: str) -> bool:
        """Whether the pair, or the material, that has this property was named."""
        return (self.pair if key in _PAIR_KEYS else self.material) is not None

    def check(self, keys: Sequence[str]) -> None:
        """Raise InputError now for what put would refuse after the work."""
        from calibration.files.parameter_file import check_file, check_place

        check_file(self.path)
        for key in [key for key in keys if self.takes(key)] or keys:
            check_place(self._where(key), key)

    def _where(self, key: str) -> str:
        from granulab.errors import InputError

        kind = "pair" if key in _PAIR_KEYS else "material"
        name = self.pair if kind == "pair" else self.material
        if name is None:
            example = "wood-steel" if kind == "pair" else "wood"
            raise InputError(f"--into {self.path}: say of which {kind}: --{kind} {example}")
        return f"{kind}.{name}"


def sheets_option(words: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """-o, --out: a folder for what the command draws; refused before the work if not writable."""

    def checked(_context: click.Context, _option: click.Parameter, out: Path | None) -> Path | None:
        from granulab.campaign.runs.folder import refuse_unless_writable

        if out is not None:
            refuse_unless_writable(out, "--out")
        return out

    kind = click.Path(path_type=Path)
    return click.option("-o", "--out", type=kind, metavar="DIR", callback=checked, help=words)


def into_options(*keys: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """--into FILE with --pair or --material, as properties `keys` need; checked before the work.

    The command gets `into`, an Into, or None where nothing is to be written. One that has several
    keys, of a pair and of a material, writes those that `into` takes.
    """
    of_pair = [key for key in keys if key in _PAIR_KEYS]
    named = ", ".join(keys)

    def decorate(command: Callable[..., Any]) -> Callable[..., Any]:
        @functools.wraps(command)
        def with_into(*args: Any, into: str | None, **given: Any) -> Any:
            pair, material = given.pop("pair", None), given.pop("material", None)
            return command(*args, into=_checked(into, pair, material, keys), **given)

        options = [
            click.option(
                "--into", metavar="FILE.toml", help=f"Write {named} into this parameter file."
            )
        ]
        if of_pair:
            options.append(click.option("--pair", metavar="wood-steel", help="Of which pair."))
        if len(of_pair) < len(keys):
            options.append(click.option("--material", metavar="wood", help="Of which material."))
        for option in reversed(options):
            with_into = option(with_into)
        return with_into

    return decorate


def _checked(
    into: str | None, pair: str | None, material: str | None, keys: Sequence[str]
) -> Into | None:
    from granulab.errors import InputError

    if into is None:
        if name := pair or material:
            raise InputError(f"{name}: names what is written; give the file, too: --into wood.toml")
        return None
    wanted = Into(Path(into), pair, material)
    wanted.check(keys)
    return wanted


def said(written: "Written") -> str:
    """What became of a value, and what simulators still need."""
    what = f"{written.path}: [{written.section}] {written.key}"
    if not written.changed:
        return f"{what} stands there already, from this measurement; nothing changed"
    before = "added" if written.replaces is None else "replaced; the old value is kept as history"
    needs = f"; a simulator still needs {', '.join(written.lacking)}" if written.lacking else ""
    return f"{what} {before}{needs}"
