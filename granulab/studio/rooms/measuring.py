"""Commands that take files and options: measurements, questions; what they said and drew."""

import importlib
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import click

from granulab.campaign.runs.folder import digest
from granulab.errors import InputError
from granulab.studio.folder import RUNS, Folder
from granulab.studio.forms import Texts, as_files, command_form, command_line
from granulab.studio.processes import Process, Processes
from granulab.studio.rooms.ownfile import OwnFile

_MEASUREMENTS = ("drop", "pendulum", "rebound", "triaxial", "flow", "packing", "piv", "impacts",
                 "shaker", "heights", "incline", "slide", "compression", "interface", "roughness",
                 "density", "damping")  # fmt: skip
_LAB = "lab"  # folder of their figures
_SHOWN = (".png", ".mp4", ".webm", ".gif")
_PAGE = ".html"


class Task(NamedTuple):
    """A command that the page offers.

    module, name  of the command
    command       its click command
    own           the kind of file that it takes besides cases, where it takes one
    option        that this file goes with, if it is no argument: its answer takes no time
    """

    module: str
    name: str
    command: Callable[[], click.Command]
    own: Callable[[], OwnFile] | None = None
    option: str = ""


def _measurement(name: str) -> click.Command:
    app = importlib.import_module("calibration.commands.main").app
    found = app.get_command(click.Context(app), name)
    assert found is not None
    return found


def _of(module: str, name: str) -> Callable[[], click.Command]:
    return lambda: getattr(importlib.import_module(module), name)


def _design() -> OwnFile:
    from damper3d.studies.design.spec import FILE, example

    return OwnFile("damper3d design", FILE, example)


def _loads() -> OwnFile:
    from silo2d.loads.spec import FILE, commented_spec

    return OwnFile("silo2d loads --silo", FILE, commented_spec)


_STRUCTURE = "damper3d.commands.structure"
TASKS = {
    **{
        f"calibrate {name}": Task("calibration", name, lambda name=name: _measurement(name))  # type: ignore[misc]
        for name in _MEASUREMENTS
    },
    "damper3d map": Task("damper3d", "map", _of("damper3d.commands.map", "map_")),
    "damper3d predict": Task("damper3d", "predict", _of("damper3d.commands.predict", "predict")),
    "damper3d design": Task("damper3d", "design", _of(f"{_STRUCTURE}.design", "design"), _design),
    "damper3d response": Task("damper3d", "response", _of(f"{_STRUCTURE}.response", "response")),
    "silo2d loads": Task("silo2d", "loads", _of("silo2d.commands.loads", "loads"), _loads,
                         "--silo"),
    "silo2d loads CASE": Task("silo2d", "loads", _of("silo2d.commands.loads", "loads")),
    "silo2d clog": Task("silo2d", "clog", _of("silo2d.commands.clog", "clog")),
}  # fmt: skip


class Started(NamedTuple):
    """A task that the page started, as it was asked for."""

    task: str
    files: Sequence[str]
    options: Mapping[str, str]
    presets: Sequence[str]
    dry: bool


class Measuring:
    """Tasks started by the page, and what they found."""

    def __init__(self, folder: Folder, processes: Processes) -> None:
        self._folder, self._processes = folder, processes
        self._started: dict[str, Started] = {}  # by their places, in their order

    def listed(self) -> list[dict[str, str]]:
        """Names and purposes of all tasks."""
        return [
            {"task": name, "meaning": command_form(task.command())["meaning"]}
            for name, task in TASKS.items()
        ]

    def form(self, task: str) -> dict[str, Any]:
        """The inputs of a task: of its command, and of the file of its own, where it takes one."""
        known = _known(task)
        command = known.command()
        return {
            **command_form(command),
            "dry": "dry_run" in _names(command) and not known.option,
            "own": known.own().form() if known.own else None,
        }

    def start(
        self,
        task: str,
        files: Sequence[str],
        options: Mapping[str, str],
        presets: Sequence[str] = (),
        dry: bool = False,
    ) -> dict[str, Any]:
        """Start a task with files of the folder, or let it say what it would take.

        presets: shipped names in place of files. Raises InputError for files, or options that name
        files, outside of the folder.
        """
        known, asked = _known(task), Started(task, files, options, presets, dry)
        command = known.command()
        for file in files:
            self._folder.file(file)
        line = [known.module, known.name, *command_line(command, options)]
        for word in [*line, *presets]:
            self._folder.refuse_outside(word.partition("=")[2] or word, word.partition("=")[0])
        _refuse_without_file(command, [*files, *presets])
        line += ["--dry-run", "--no-figures"] if dry else []
        words = [f"{known.option}={file}" for file in files] if known.option else []
        words += as_files([*presets, *(() if known.option else files)])
        place = f"{_LAB}/{known.name}-{Path(files[0]).stem}" if files else f"{_LAB}/{known.name}"
        if known.module != "calibration":  # other options are another question
            line += ["--out", RUNS]
            place += f"-{digest({'line': [*line, *words]})}"
        elif "out" in _names(command):
            line += ["--out", place]
        self._processes.start(place, [*line, *words])
        self._started.pop(place, None)
        self._started[place] = asked
        return {"place": place}

    def started(self) -> list[dict[str, Any]]:
        """Tasks that the page started so far, the last first: going on, or ended."""
        found = []
        for place, asked in reversed(self._started.items()):
            process = self._process(place).state()
            known = {name: process[name] for name in ("state", "command", "seconds")}
            found.append({"place": place, **asked._asdict(), **known})
        return found

    def state(self, place: str) -> dict[str, Any]:
        """State of a started task: its words, and once it is done its answer and its figures."""
        process = self._process(place)
        found = process.state() | {"dry": self._started[place].dry}
        if found["state"] == "running":
            return found
        made = [self._named(path) for path in self._made(place, process)]
        return found | {
            "said": process.said.replace(f"{self._folder.root}/", ""),
            "figures": [name for name in made if not name.endswith(_PAGE)],
            "pages": [name for name in made if name.endswith(_PAGE)],
        }

    def stop(self, place: str) -> dict[str, Any]:
        """Ask a task to end."""
        self._process(place).stop()
        return self.state(place)

    def open(self, task: str, name: str) -> Texts:
        """The texts of a file of a task's own kind."""
        return _own_of(task).texts(self._folder, name)

    def keep(self, task: str, texts: Texts, replace: bool = False) -> dict[str, Any]:
        """Write a file of a task's own kind."""
        return _own_of(task).save(self._folder, texts, replace)

    def page(self, name: str) -> str:
        """The page of an answer, which needs nothing but itself; InputError where it is none."""
        path = self._folder.file(name)
        if not name.startswith(f"{RUNS}/") or path.suffix != _PAGE:
            raise InputError(f"{name}: no page of an answer")
        return path.read_text(encoding="utf-8")

    def _process(self, place: str) -> Process:
        process = self._processes.get(place)
        if process is None or place not in self._started:
            raise InputError(f"{place}: nothing of that name was started")
        return process

    def _named(self, path: Path) -> str:
        return path.relative_to(self._folder.root).as_posix()

    def _made(self, place: str, process: Process) -> list[Path]:
        """Pictures, films and pages that a task made.

        Measurements have a folder of their own for them; other commands say the name of each.
        """
        if process.command[0] == "calibration":
            made = sorted(self._folder.path(place).glob("*"))
            made = [path for path in made if path.stat().st_mtime >= process.begun - 1]
        else:
            made = []
            for line in process.lines:
                with suppress(InputError):
                    made.append(self._folder.file(line))
        return [path for path in made if path.suffix.lower() in (*_SHOWN, _PAGE)]


def _names(command: click.Command) -> set[str | None]:
    return {one.name for one in command.get_params(click.Context(command))}


def _refuse_without_file(command: click.Command, given: Sequence[str]) -> None:
    """Raise InputError for a command that takes a file and has none: it would name its usage."""
    for one in command.get_params(click.Context(command)):
        if isinstance(one, click.Argument) and one.required and not given:
            what = "case" if one.name in ("case", "host") else "film or table"
            how = "save one in its room" if what == "case" else "drop one on the page"
            raise InputError(f"no {what} was chosen: {how} first, or choose one of the folder")


def _own_of(task: str) -> OwnFile:
    own = _known(task).own
    if own is None:
        raise InputError(f"{task}: takes no file of its own kind")
    return own()


def _known(task: str) -> Task:
    if task not in TASKS:
        raise InputError(f"{task!r}: no such task; known: {', '.join(TASKS)}")
    return TASKS[task]


def film_frame(folder: Folder, name: str, number: int) -> bytes:
    """A frame of a film, or a picture, as a PNG.

    Raises InputError where it is none, or has no such frame.
    """
    import cv2

    from calibration.tracking.film.reader import open_film, open_picture

    path = folder.file(name)
    film = open_picture(path) or open_film(path)
    for frame in film.some({number}):
        done, content = cv2.imencode(".png", frame.picture)
        if done:
            return content.tobytes()
    raise InputError(f"{name}: has no frame {number}; give one from 0 to {max(film.count - 1, 0)}")
