"""The commands `init`, `list`, `show`: new files to edit; packings and runs in words."""

import importlib
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import click

from granulab.campaign.cli.commandline import MANY, Ended, all_option, out_option
from granulab.campaign.output.files import below, in_shell, write_atomic, writing
from granulab.campaign.output.layout import wrapped
from granulab.campaign.runs.folder import RunFolder, resume_run
from granulab.errors import FolderError, InputError


class NewFile(NamedTuple):
    """A kind of file that `init` writes."""

    text: Callable[[], str]  # as an example, with a comment on every key
    use: str  # the command that takes it, with {file}
    folder: str  # of the shipped ones
    names: Callable[[], Sequence[str]]  # of those there that --from copies
    table: str  # one that such a file has


_LONGEST = 40  # characters of a value in a list


def file_commands(
    package: str,
    study_file: str,
    kinds: str,
    new: Sequence[str] = ("materials",),
    case_options: Callable[[Callable[..., Any]], Callable[..., Any]] | None = None,
) -> list[click.Command]:
    """The commands `init`, `list` and `show` of a simulator's package, called as it is.

    Its `commands.library` has `listing(root)`, the cases and files that there are and what stands
    below a folder of runs, `description(name)`, one of these in words, `new_files()`, the kinds of
    files that `init` writes besides studies: "case" and those in `new`, and `preset_case(name)`,
    the case file of a preset or None. study_file: a shipped one, as an example; kinds: of files,
    for the help. case_options: of `init`, which `commands.library.case_of` makes a case of, or None
    where none is given.
    """

    def library() -> Any:
        return importlib.import_module(f"{package}.commands.library")

    def known() -> dict[str, NewFile]:
        study, sweep = [study_file], f"{package} sweep {{file}}"
        return {
            **library().new_files(),
            "study": NewFile(lambda: _shipped(study_file), sweep, "studies", lambda: study, "vary"),
        }

    @click.command("list", help="List presets, files, packings; runs with their state and size.")
    @out_option
    @all_option
    @click.option("--verify", "check", is_flag=True, help="Check all files below DIR for damage.")
    def list_(out: str, every: bool, check: bool) -> None:
        (_verify if check else partial(_list, library(), every))(Path(out))

    @click.command(help=f"Describe a preset, {kinds} or run folder in words and numbers.")
    @click.argument("name")
    def show(name: str) -> None:
        click.echo(wrapped(library().description(name), 14))

    return [_init_command(library, known, kinds, new, case_options), list_, show]


def _init_command(
    library: Callable[[], Any],
    known: Callable[[], dict[str, NewFile]],
    kinds: str,
    new: Sequence[str],
    case_options: Callable[[Callable[..., Any]], Callable[..., Any]] | None,
) -> click.Command:
    """The command `init`; see file_commands."""

    @click.argument("file")
    @click.option("--study", "kind", flag_value="study", help="Write a study file instead.")
    @click.option(
        "--from", "source", metavar="NAME",
        help=f"Write a copy of this one to change: a preset, a shipped {kinds}, or a file.",
    )  # fmt: skip
    def init(file: str, kind: str | None, source: str | None, **given: Any) -> None:
        files = known()
        made = library().case_of(**given) if case_options else None
        if made is not None:
            if source or kind:
                raise InputError(
                    "a drawing makes a case; leave --from and other kinds of files out"
                )
            kind, text = "case", made
        elif source is None:
            kind = kind or "case"
            text = files[kind].text()
        else:
            text, found = _copied(source, files, library().preset_case)
            if kind not in (None, found):
                raise InputError(f"--from {source}: a {found} file, and --{kind} wants another")
            kind = found
        write_new(Path(file), text)
        use = files[kind].use.format(file=in_shell(file))
        click.echo(f"wrote {file}; change it, and use it with: {use}")

    if case_options:
        init = case_options(init)
    for one in new:
        text = f"Write a {one} file instead."
        init = click.option(f"--{one}", "kind", flag_value=one, help=text)(init)
    about = "Write a file with a comment on every key: a case."
    return click.command("init", help=about)(init)


def _copied(
    source: str, files: dict[str, NewFile], preset_case: Callable[[str], str | None]
) -> tuple[str, str]:
    """The text and the kind of the preset or file that `init --from` names."""
    from granulab.contact.files.datafile import data_file, is_file, toml_text
    from granulab.contact.files.units import nearest

    if (text := preset_case(source)) is not None:
        return text, "case"
    shipped = {name: one.folder for one in reversed(files.values()) for name in one.names()}
    path = Path(source) if is_file(Path(source)) else None
    if path is None and source in shipped:
        path = data_file(shipped[source], source)
    if path is None:
        names = list(shipped)
        raise InputError(f"--from {source}: no such preset or file; {nearest(source, names)}")
    text, tables = toml_text(path)
    return text, next((kind for kind, one in files.items() if one.table in tables), "case")


def _list(library: Any, every: bool, root: Path) -> None:
    """Print what there is to run, and what stands below a folder."""
    click.echo(wrapped(library.listing(root, every), 11))


def _verify(root: Path) -> None:
    """Print what is damaged below a folder; Ended where anything is."""
    from granulab.campaign.runs.verify import verify  # h5py: --help needs it not

    if not root.is_dir():
        raise FolderError(f"{root}: no such folder; give that of the runs with --out")
    found = verify(root)
    for line in found.damaged:
        click.echo(f"damaged    {line}")
    n_files = len(found.whole) + len(found.unsealed) + len(found.damaged)
    click.echo(
        f"{n_files} files below {root}: {len(found.whole)} sealed and whole, "
        f"{len(found.damaged)} damaged, {len(found.unsealed)} without a seal (pictures, films, "
        "exports, and runs of versions before there were seals)"
    )
    if found.damaged:
        raise Ended(f"{len(found.damaged)} of {n_files} files below {root} are damaged", 2)


def _shipped(study: str) -> str:
    from granulab.contact.files.datafile import data_file

    file = data_file("studies", study)
    assert file is not None
    return file.read_text(encoding="utf-8")


def read_shown(name: str, known: Sequence[str]) -> tuple[str, dict[str, Any]]:
    """The path of a TOML file or shipped materials table of a name, and its tables.

    known: all names that there are. Raises InputError where there is none, or none that is TOML.
    """
    from granulab.contact.files.datafile import data_file, toml_text
    from granulab.contact.files.units import nearest

    file = Path(name) if Path(name).is_file() else data_file("materials", name)
    if file is None:
        raise InputError(f"{name!r}: no such preset, file or run; {nearest(name, known)}")
    return str(file), toml_text(file)[1]


def write_new(path: Path, text: str) -> None:
    """Write a file that is not there yet; FolderError where it is, or cannot be written."""
    try:
        with path.open("x", encoding="utf-8", newline="\n") as file:
            file.write(text)
    except FileExistsError:
        raise FolderError(f"{path}: exists; give another name, nothing was written") from None
    except OSError as error:
        raise FolderError(f"{path}: cannot be written ({error.strerror}); give another") from None


def write_output(path: Path, content: bytes) -> Path:
    """Write a file to a path that was given; the path. FolderError where it cannot be."""
    try:
        with writing(path.parent):
            path.parent.mkdir(parents=True, exist_ok=True)
        write_atomic(path, content)
    except FolderError as error:
        if error.__cause__ is None:  # a link, which another place does not cure
            raise
        reason = getattr(error.__cause__, "strerror", None) or "no reason given"
        raise FolderError(
            f"{path}: cannot be written ({reason}); make room there, or choose another place "
            "with --output"
        ) from error
    return path


def packings_and_runs(
    root: Path, section: str, result: Callable[[dict[str, Any]], str], every: bool = False
) -> list[str]:
    """Lines on what stands below a folder: packings, studies, and each run in which runs differ.

    section: one that every case of the simulator has; runs of another are left out.
    result: words on a finished run, from its summary; where it raises, that is damaged.
    every: list each run also of a case that has more than MANY, not a line for all of them.
    """
    packings = sorted((root / "packings").glob("*/packing.h5"))
    studies = sorted((root / "studies").glob("*/study.toml"))
    cases = {path.parent: _keys(path) for path in sorted(root.glob("*/case.toml"))}
    runs = {run: keys for run, keys in cases.items() if not keys or _has(keys, section)}
    lines = []
    if packings:
        lines.append(f"packings   {len(packings)} in {root / 'packings'} ({_size(*packings)})")
    lines += [f"study      {path.parent} ({_size(path.parent)})" for path in studies]
    for name, alike in _by_name(runs).items():
        if name and len(alike) > MANY and not every:
            states = Counter(_kind_of_state(run) for run in alike)
            shown = ", ".join(f"{number} {state}" for state, number in states.items())
            lines.append(f"runs       {len(alike)} of {name} in {root}: {shown} ({_size(*alike)}); "
                         "each with --all")  # fmt: skip
            continue
        for run, own in _differences(alike).items():
            shown = "".join(f"; {key} {value}" for key, value in own.items())
            lines.append(f"run        {run}: {_state(run, result)}{shown} ({_size(run)})")
    return lines


def _by_name(runs: Mapping[Path, dict[str, str]]) -> dict[str | None, dict[Path, dict[str, str]]]:
    """The runs and their keys by the name of their case."""
    found: dict[str | None, dict[Path, dict[str, str]]] = {}
    for run, case in runs.items():
        found.setdefault(case.get("name"), {})[run] = case
    return found


def _kind_of_state(run: Path) -> str:
    folder = RunFolder(run)
    return "failed" if folder.failure else folder.state


def _has(keys: Mapping[str, str], section: str) -> bool:
    return any(key.startswith(f"{section}.") for key in keys)


def _differences(runs: Mapping[Path, dict[str, str]]) -> dict[Path, dict[str, str]]:
    """Keys of the cases, with their values as written, in which these runs differ."""
    names = dict.fromkeys(key for case in runs.values() for key in case)
    vary = [key for key in names if len({case.get(key) for case in runs.values()}) > 1]
    return {run: {key: case.get(key, "left out") for key in vary} for run, case in runs.items()}


def _keys(case: Path) -> dict[str, str]:
    """The keys of a case file as "section.key", and their values; none where it is damaged."""
    from granulab.contact.files.casefile import flat
    from granulab.contact.files.datafile import toml_text

    try:
        _, tables = toml_text(case)
    except (InputError, OSError):
        return {}
    return {key: _as_written(value) for key, value in flat(tables).items()}


def _as_written(value: Any) -> str:
    """A value of a case in a few words."""
    words = str(value).lower() if isinstance(value, bool) else str(value)
    return words if len(words) <= _LONGEST else f"{words[: _LONGEST - 3]}..."


def run_in_words(
    path: Path, command: str, echo: Callable[[Path], str], report: Callable[[RunFolder], str]
) -> str:
    """A run folder in words: its case by `echo`; then `report` of a finished one.

    Of another, what became of it, and that `command` goes on with it. FolderError where it is no
    run folder.
    """
    run = resume_run(path)
    case = echo(run.path / "case.toml")
    if run.state == "finished":
        return f"{case}\n\n{report(run)}"
    go_on = run.go_on(command)
    if run.failure:
        again = f"it is tried again from its last checkpoint by: {go_on}"
        return f"{case}\n\n{path}: failed: {run.failure}\n{again}"
    return f"{case}\n\n{path}: unfinished; go on with: {go_on}"


def _state(folder: Path, result: Callable[[dict[str, Any]], str]) -> str:
    run = RunFolder(folder)
    if run.state != "finished":
        return f"failed: {run.failure}" if run.failure else "unfinished"
    try:
        return result(run.read_summary())
    except (TypeError, ValueError):  # FolderError is one
        return "damaged"


def _size(*places: Path) -> str:
    """Size of folders, or of files, with all that they hold."""
    total = 0
    for file in (file for place in places for file in (place, *below(place))):
        with suppress(FileNotFoundError):  # of a run that goes on
            total += file.stat().st_size if file.is_file() else 0
    return f"{total / 1e6:.1f} MB"
