"""The form that every result of calibration has, and the one way in which a command ends.

A measurement of calibration returns a `Result`: numbers for a script, text for a person, a
diagnostic figure. `finish` writes what was requested and prints the result; no command does so by
itself.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, runtime_checkable

import click

from granulab.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from calibration.files.parameter_file import Written
    from calibration.statistics.uncertainty import Estimate

PAIR_KEYS = ("friction", "restitution", "kn", "kt", "gamma_n", "gamma_t")

TABLE = "calibration.table"  # of a command's context: where --table writes the answers

Files = Mapping[str, "Path | Sequence[Path] | None"]

_LABELS = {"sheet": "diagnostic figure"}  # of files whose JSON key is not what people read


class Drawn(Protocol):
    """A measurement, or a film of one, that can be drawn."""

    def figure(self) -> "Figure | None":
        """The figure, by which a person believes the result or not; None without one."""


class Result(Drawn, Protocol):
    """A measurement: numbers, text and figure."""

    def to_dict(self) -> dict[str, Any]:
        """Quantities in SI, ready for JSON; None where a value does not exist."""

    def text(self) -> str:
        """The same for a person, warnings last."""


class AsText:
    """Base of results that Python shows as a person reads them."""

    def text(self) -> str:
        """See Result."""
        raise NotImplementedError

    def __repr__(self) -> str:
        return self.text()


class Parameter(NamedTuple):
    """A value for a parameter file, in SI, and how it was found.

    source   in place of the names of the files that were measured
    """

    estimate: "Estimate"
    method: str
    source: str | None = None


@runtime_checkable
class Parameters(Protocol):
    """A result with values that --into writes."""

    def parameters(self) -> dict[str, Parameter]:
        """Values by property ("restitution"); InputError, one line, where there is none."""


@dataclass(frozen=True)
class Into:
    """The parameter file that --into names, the pair or material, and the properties to write."""

    path: Path
    pair: str | None
    material: str | None
    keys: tuple[str, ...] = ()

    def put(
        self, key: str, estimate: "Estimate", *, method: str, files: Sequence[str | Path] = (),
        source: str | None = None,
    ) -> "Written":  # fmt: skip
        """Write an estimate, in SI, that was measured from files, and report it on stderr.

        source is the names of the files unless given. Raises InputError; see
        calibration.files.parameter_file.into.
        """
        from calibration.files.parameter_file import digest_of, into

        paths = [Path(file) for file in files]
        written = into(
            self.path,
            self._section(key),
            key,
            estimate,
            method=method,
            source=source or ", ".join(path.name for path in paths),
            digest=digest_of(paths) if paths else None,
        )
        click.echo(report_of(written), err=True)
        return written

    def put_all(
        self, found: Mapping[str, Parameter], files: Sequence[str | Path]
    ) -> "list[Written]":
        """Write those of `keys` that the named pair or material has; InputError where one lacks."""
        written = []
        for key in filter(self.takes, self.keys):
            if key not in found:
                raise InputError(
                    f"--into {self.path}: no {key}: its columns or constants are missing"
                )
            one = found[key]
            put = self.put(key, one.estimate, method=one.method, files=files, source=one.source)
            written.append(put)
        return written

    def takes(self, key: str) -> bool:
        """True if the pair, or the material, that has this property was named."""
        return (self.pair if key in PAIR_KEYS else self.material) is not None

    def check(self) -> None:
        """Raise InputError now for what put would refuse after the work."""
        from calibration.files.parameter_file import check_file, check_section

        check_file(self.path)
        for key in [key for key in self.keys if self.takes(key)] or self.keys:
            check_section(self._section(key), key)

    def _section(self, key: str) -> str:
        kind = "pair" if key in PAIR_KEYS else "material"
        name = self.pair if kind == "pair" else self.material
        if name is None:
            example = "wood-steel" if kind == "pair" else "wood"
            raise InputError(f"--into {self.path}: say of which {kind}: --{kind} {example}")
        return f"{kind}.{name}"


def report_of(written: "Written") -> str:
    """A line on what became of a value in a parameter file, and what simulators still need."""
    what = f"{written.path}: [{written.section}] {written.key}"
    if not written.changed:
        return f"{what} stands there already, from this measurement; nothing changed"
    before = "added" if written.replaces is None else "replaced; the old value is kept as history"
    if not written.lacking:
        return f"{what} {before}"
    from granulab.contact.files.needs import lacking_words

    return f"{what} {before}; a simulator still needs {lacking_words(written.lacking)}"


def finish(
    result: Result,
    *,
    as_json: bool,
    quiet: bool = False,
    out: Path | None = None,
    name: str = "",
    figure_key: str | None = "sheet",
    files: Files | None = None,
    into: Into | None = None,
    measured: Sequence[str | Path] = (),
) -> None:
    """End a command: --into, the diagnostic figure, and the result on stdout as text or --json.

    out, name    folder of the figure, and its file name without ".png"; no figure without a folder
    figure_key   JSON key of the figure's path; None where the command draws none
    files        JSON key and path, or paths, of what else the command has written
    into         the result is a `Parameters`; its values were measured from the files `measured`

    Paths of files are printed on stderr, unless quiet or as_json. Raises InputError or FolderError
    for what cannot be written; nothing is printed then.
    """
    answers = result.to_dict()
    warnings = checked(answers, measured)
    if into is not None:
        if not isinstance(result, Parameters):
            raise InputError(f"--into {into.path}: this result has no value for it")
        found = result.parameters()
        _keep_records(result, answers, into.put_all(found, measured), found, measured)
    paths: dict[str, Path | Sequence[Path] | None] = dict(files or {})
    said = [*answers.get("warnings", []), *warnings]
    if figure_key is not None and figure_key not in paths:
        paths[figure_key] = None if out is None else draw(result, out / f"{name}.png")
    context = click.get_current_context(silent=True)
    if table := context and context.meta.get(TABLE):
        from calibration.files.answers import write_answers

        paths["tables"] = write_answers(table, answers | ({"warnings": said} if said else {}))
    if as_json:
        listed = {key: _as_words(path) for key, path in paths.items()}
        if warnings:
            listed["warnings"] = said
        click.echo(json.dumps(answers | listed, indent=2))
        return
    click.echo("\n".join([result.text(), *(f"warning: {warning}" for warning in warnings)]))
    if not quiet:
        for key, one in paths.items():
            label = _LABELS.get(key, key.removesuffix("s").replace("_", " "))
            for path in [one] if isinstance(one, Path) else one or []:
                click.echo(f"{label}: {path}", err=True)


def _keep_records(
    result: Result, answers: Mapping[str, Any], written: "Sequence[Written]",
    found: Mapping[str, Parameter], measured: Sequence[str | Path],
) -> None:  # fmt: skip
    """Keep how each value came into its file next to it, for `calibrate report`."""
    from calibration.files.record import keep
    from granulab.campaign.output.figure import as_png

    picture = as_png(result.figure)
    for one in written:
        value = found[one.key].estimate.value
        keep(one.path, one.section, one.key, value, answers, measured, picture)


def checked(answers: Mapping[str, Any], measured: Sequence[str | Path] = ()) -> list[str]:
    """Warnings about answers that no such experiment finds; InputError for impossible ones.

    answers    of a result, as they stand in its JSON
    measured   the files that they came from
    """
    from granulab.campaign.output.ranges import judged
    from granulab.contact.files.units import located

    if not measured:
        return judged("calibration", answers)
    with located(f"{', '.join(map(str, measured))}:"):
        return judged("calibration", answers)


def draw(result: Drawn, path: Path) -> Path:
    """Write the diagnostic figure of a result, which must have one, as a PNG; its path."""
    from granulab.campaign.output.figure import write_figure

    def figure() -> "Figure":  # drawn by write_figure, in its style
        drawn = result.figure()
        assert drawn is not None
        return drawn

    return write_figure(path, figure)


def _as_words(path: "Path | Sequence[Path] | None") -> Any:
    if path is None or isinstance(path, Path):
        return path and str(path)
    return [str(one) for one in path]
