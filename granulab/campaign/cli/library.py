"""The commands `init`, `list`, `show`: new files to edit; packings and runs in words."""

import importlib
import shlex
import tomllib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import click

from granulab.campaign.cli.commandline import out_option
from granulab.campaign.runs.folder import FolderError, RunFolder, resume_run, write_atomic, writing
from granulab.errors import InputError


def file_commands(package: str, study_file: str, kinds: str) -> list[click.Command]:
    """The commands `init`, `list` and `show` of a simulator's package, called as it is.

    Its `case.settings.commented_case()` gives a case file with a comment on every key; its
    `commands.library` has `listing(root)`, the cases and files that there are and what stands
    below a folder of runs, and `description(name)`, one of these in words. study_file: a shipped
    one, as an example; kinds: of files, for the help.
    """

    def of_package(module: str) -> Any:
        return importlib.import_module(f"{package}.{module}")

    @click.command(help="Write a case file with a comment on every key.")
    @click.argument("file")
    @click.option("--study", is_flag=True, help="Write a study file instead.")
    def init(file: str, study: bool) -> None:
        text = _shipped(study_file) if study else of_package("case.settings").commented_case()
        write_new(Path(file), text)
        click.echo(f"wrote {file}; run it with: {package} {'sweep' if study else 'run'} {file}")

    @click.command("list", help="List presets, files, packings; runs with their state and size.")
    @out_option
    def list_(out: str) -> None:
        click.echo(of_package("commands.library").listing(Path(out)))

    @click.command(help=f"Describe a preset, {kinds} or run folder in words and numbers.")
    @click.argument("name")
    def show(name: str) -> None:
        click.echo(of_package("commands.library").description(name))

    return [init, list_, show]


def _shipped(study: str) -> str:
    from granulab.contact.files.datafile import data_file

    file = data_file("studies", study)
    assert file is not None
    return file.read_text(encoding="utf-8")


def read_shown(name: str, known: Sequence[str]) -> tuple[str, dict[str, Any]]:
    """The path of a TOML file or shipped materials table of a name, and its tables.

    known: all names that there are. Raises InputError where there is none, or none that is TOML.
    """
    from granulab.contact.files.datafile import data_file
    from granulab.contact.files.units import nearest

    file = Path(name) if Path(name).is_file() else data_file("materials", name)
    if file is None:
        raise InputError(f"{name!r}: no such preset, file or run; {nearest(name, known)}")
    try:
        return str(file), tomllib.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(f"{file}: cannot be read ({error}); give a TOML file") from None


def write_new(path: Path, text: str) -> None:
    """Write a file that is not there yet; FolderError where it is, or cannot be written."""
    try:
        with path.open("x", encoding="utf-8") as file:
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
        reason = getattr(error.__cause__, "strerror", None) or "no reason given"
        raise FolderError(
            f"{path}: cannot be written ({reason}); make room there, or choose another place "
            "with --output"
        ) from error
    return path


def packings_and_runs(root: Path, result: Callable[[dict[str, Any]], str]) -> list[str]:
    """A line for each packing and run below a folder: where it is, its state and size.

    result: words on a finished run, from its summary; where it raises, that is damaged.
    """
    packings = sorted((root / "packings").glob("*/packing.h5"))
    runs = sorted(root.glob("*/case.toml"))
    return [
        *(f"packing    {path.parent}  {_size(path.parent)}" for path in packings),
        *(f"run        {p.parent}  {_state(p.parent, result)}  {_size(p.parent)}" for p in runs),
    ]


def run_in_words(path: Path, command: str, report: Callable[[RunFolder], str]) -> str:
    """A run folder in words: `report` of a finished one; `command` goes on with an unfinished one.

    FolderError where it is no run folder.
    """
    run = resume_run(path)
    if run.state == "unfinished":
        return f"{path}: unfinished; go on with: {command} run --resume {shlex.quote(str(path))}"
    return report(run)


def _state(folder: Path, result: Callable[[dict[str, Any]], str]) -> str:
    run = RunFolder(folder)
    if run.state != "finished":
        return "unfinished"
    try:
        return result(run.read_summary())
    except (FolderError, KeyError, TypeError, ValueError):
        return "damaged"


def _size(folder: Path) -> str:
    size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
    return f"{size / 1e6:.1f} MB"
