"""Commands that take files and options: measurements of the laboratory, maps; their figures."""

import importlib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import click

from granulab.errors import InputError
from granulab.studio.folder import RUNS, Folder
from granulab.studio.forms import as_files, command_form, command_line
from granulab.studio.processes import Process, Processes

_MEASUREMENTS = ("drop", "pendulum", "rebound", "triaxial", "flow", "packing", "piv", "impacts",
                 "shaker", "heights", "incline", "slide", "compression", "interface", "roughness",
                 "density", "damping")  # fmt: skip
_LAB = "lab"  # folder of their figures
_SHOWN = (".png", ".mp4", ".webm", ".gif")


class Task(NamedTuple):
    """A command that the page offers: the module it is of, its name, and its click command."""

    module: str
    name: str
    command: Callable[[], click.Command]


def _measurement(name: str) -> click.Command:
    app = importlib.import_module("calibration.commands.main").app
    found = app.get_command(click.Context(app), name)
    assert found is not None
    return found


def _map() -> click.Command:
    return importlib.import_module("damper3d.commands.map").map_


TASKS = {
    **{
        f"calibrate {name}": Task("calibration", name, lambda name=name: _measurement(name))  # type: ignore[misc]
        for name in _MEASUREMENTS
    },
    "damper3d map": Task("damper3d", "map", _map),
}


class Measuring:
    """Tasks started by the page, and what they found."""

    def __init__(self, folder: Folder, processes: Processes) -> None:
        self._folder, self._processes = folder, processes

    def listed(self) -> list[dict[str, str]]:
        """Names and purposes of all tasks."""
        return [
            {"task": name, "meaning": command_form(task.command())["meaning"]}
            for name, task in TASKS.items()
        ]

    def form(self, task: str) -> dict[str, Any]:
        """The inputs of a task."""
        return command_form(_known(task).command())

    def start(
        self,
        task: str,
        files: Sequence[str],
        options: Mapping[str, str],
        presets: Sequence[str] = (),
    ) -> dict[str, Any]:
        """Start a task with files of the folder; presets: shipped names in place of files.

        Raises InputError for files, or options that name files, outside of the folder.
        """
        known = _known(task)
        command = known.command()
        for file in files:
            self._folder.file(file)
        line = [known.module, known.name, *command_line(command, options)]
        for word in [*line, *presets]:
            self._folder.refuse_outside(word.partition("=")[2] or word, word.partition("=")[0])
        place = f"{_LAB}/{known.name}-{Path(files[0]).stem}" if files else f"{_LAB}/{known.name}"
        own = {one.name for one in command.get_params(click.Context(command))}
        if known.module == "damper3d":
            line += ["--out", RUNS, "--json"]
        elif "out" in own:
            line += ["--out", place]
        self._processes.start(place, [*line, *as_files([*presets, *files])])
        return {"place": place}

    def state(self, place: str) -> dict[str, Any]:
        """State of a started task: its words, and once it is done its answer and its figures."""
        process = self._process(place)
        found = process.state()
        if found["state"] == "running":
            return found
        return found | {"said": process.said, "figures": self._figures(place, process)}

    def stop(self, place: str) -> dict[str, Any]:
        """Ask a task to end."""
        self._process(place).stop()
        return self.state(place)

    def _process(self, place: str) -> Process:
        process = self._processes.get(place)
        if process is None or not place.startswith(_LAB):
            raise InputError(f"{place}: nothing of that name was started")
        return process

    def _figures(self, place: str, process: Process) -> list[str]:
        """Names of the pictures and films that a task made, the newest first."""
        result = process.result()
        where = self._folder.path(place)
        if result and isinstance(result.get("folder"), str):  # of a map
            where = self._folder.path(result["folder"])
        made = [
            path for path in where.glob("*")
            if path.suffix.lower() in _SHOWN and path.stat().st_mtime >= process.begun - 1
        ]  # fmt: skip
        made.sort(key=lambda path: path.name)
        return [path.relative_to(self._folder.root).as_posix() for path in made]


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
