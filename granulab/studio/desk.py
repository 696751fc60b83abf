"""The desk: what the page may ask and order, by name, and what answers it."""

import threading
from collections.abc import Callable, Mapping
from functools import cached_property, partial
from pathlib import Path
from typing import Any

from granulab.errors import InputError
from granulab.studio.folder import Folder, listed
from granulab.studio.forms import Texts
from granulab.studio.processes import Beside, Processes
from granulab.studio.rooms.runs import GOING
from granulab.studio.rooms.simulator import Bench


class Desk:
    """Answers to the page, over one folder."""

    def __init__(self, root: Path) -> None:
        self.folder = Folder(root)
        self.processes = Processes(self.folder.root)
        self.beside = Beside()
        self._checking = threading.Lock()  # a case of millions takes seconds, and much memory

    @cached_property
    def benches(self) -> Mapping[str, Bench]:
        """The simulators, by their commands."""
        from granulab.studio.rooms import damper, silo

        return {one.command: one for one in (silo.bench(), damper.bench())}

    @cached_property
    def runs(self) -> Any:
        """The runs below the folder."""
        from granulab.studio.rooms.runs import Runs

        return Runs(self.folder, self.processes, self.benches)

    @cached_property
    def measuring(self) -> Any:
        """The measurements and questions that the page starts."""
        from granulab.studio.rooms.measuring import Measuring

        return Measuring(self.folder, self.processes)

    @cached_property
    def asks(self) -> dict[str, Callable[..., Any]]:
        """Questions of the page, which change nothing."""
        from granulab.studio.rooms import drawings

        return {
            "start": self.start,
            "files": lambda: listed(self.folder),
            "open": lambda simulator, name: self._bench(simulator).texts(self.folder, name),
            "runs": self.runs.listed,
            "run": self.runs.state,
            "frame": self.runs.frame,
            "results": self.runs.results,
            "shapes": partial(drawings.shapes, self.folder),
            "task": self.measuring.form,
            "measured": self.measuring.state,
            "started": self.measuring.started,
            "open_own": self.measuring.open,
            "materials": partial(drawings.materials, self.folder),
        }

    @cached_property
    def orders(self) -> dict[str, Callable[..., Any]]:
        """Orders of the page, and questions with more than an address holds."""
        from granulab.studio.rooms import drawings

        def check(simulator: str, case: Texts) -> dict[str, Any]:
            with self._checking:
                found = self._bench(simulator).check(self.folder, case)
            if not found["refused"]:
                found["state"] = self.runs.doing(found["run"])
            return found

        def save(simulator: str, case: Texts, replace: bool = False) -> dict[str, Any]:
            return self._bench(simulator).save(self.folder, case, replace)

        def fill(simulator: str, case: Texts) -> dict[str, Any]:
            bench = self._bench(simulator)
            if bench.start is None:
                return {}
            return self.beside.call(bench.start, *bench.tables(self.folder, case), self.folder.root)

        return {
            "check": check,
            "save": save,
            "fill": fill,
            "measure": self.measuring.start,
            "end": self.measuring.stop,
            "keep": self.measuring.keep,
            "begin": self.begin,
            "compare": self.runs.compare,
            "stop": self.runs.stop,
            "resume": self.runs.resume,
            "outline": partial(drawings.outline, self.folder),
            "particles": partial(drawings.particles, self.folder),
            "draw_shapes": partial(drawings.draw_shapes, self.folder),
        }

    def start(self) -> dict[str, Any]:
        """All that the page begins with: forms, presets, shipped files, the folder's content."""
        from importlib.metadata import version

        from granulab.contact.files.datafile import data_names

        return {
            "folder": str(self.folder.root),
            "version": version("granulab"),
            "simulators": {
                name: {"form": bench.form(), "presets": bench.presets()}
                for name, bench in self.benches.items()
            },
            "shapes": data_names("shapes"),
            "materials": data_names("materials"),
            "tasks": self.measuring.listed(),
            "files": listed(self.folder),
        }

    def begin(
        self, simulator: str, case: Texts, replace: bool = False, figures: bool = True
    ) -> dict[str, Any]:
        """Save a case and start its run, unless it goes on already.

        The answer is that of save alone where its file is another's.
        """
        bench = self._bench(simulator)
        saved = bench.save(self.folder, case, replace)
        if saved["exists"] or self.runs.doing(saved["run"]) in GOING:
            return saved
        return saved | self.runs.start(bench, saved["file"], saved["run"], figures)

    def close(self) -> None:
        """End what goes on; runs keep their state."""
        self.beside.end()
        self.processes.end()

    def without_root(self, line: str) -> str:
        """A line without the path of the folder."""
        return line.replace(f"{self.folder.root}/", "")

    def _bench(self, simulator: str) -> Bench:
        if simulator not in self.benches:
            raise InputError(f"{simulator!r}: no such simulator; known: {', '.join(self.benches)}")
        return self.benches[simulator]
