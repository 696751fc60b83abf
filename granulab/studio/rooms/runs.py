"""Runs on the page: started, watched, stopped, gone on with; their results and files."""

import contextlib
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from granulab.campaign.runs.folder import RunFolder
from granulab.errors import FolderError, InputError
from granulab.studio.folder import RUNS, Folder
from granulab.studio.forms import Texts, as_files
from granulab.studio.processes import Processes
from granulab.studio.rooms.simulator import Bench

_SHOWN = (".png", ".mp4", ".webm", ".gif")  # of a run's figures
_BESIDE = (".toml", ".csv", ".wav", ".stl", ".obj")  # of files that a run keeps with its case
_MOST_RUNS = 500
GOING = ("running", "elsewhere")  # states of a run that a process computes: of the page, another's
_PLAYER_MB = 6.0  # of the page that plays a run, at most: it goes no further than this machine


class Runs:
    """The runs below a folder, and the processes that compute some of them."""

    def __init__(self, folder: Folder, processes: Processes, benches: Mapping[str, Bench]) -> None:
        self._folder, self._processes, self._benches = folder, processes, benches

    def listed(self) -> list[dict[str, Any]]:
        """All runs, the newest first: simulator, state, and words on each."""
        cases = [*self._folder.runs.glob("*/case.toml")]
        cases.sort(key=lambda case: case.stat().st_mtime, reverse=True)
        found = []
        for case in cases[:_MOST_RUNS]:
            name = case.parent.name
            with contextlib.suppress(InputError):  # a link that leads out
                self._path(name)
                try:
                    found.append(self.state(name))
                except InputError as error:
                    damaged = {"simulator": "", "state": "damaged", "failure": str(error)}
                    found.append({"run": name, **damaged, "process": None})
        return found

    def start(self, bench: Bench, file: str, run: str, figures: bool) -> dict[str, Any]:
        """Start the command that runs a case file of the folder, with figures and film or without.

        It goes on with the run where one was begun.
        """
        self._folder.file(file)
        options = ["--out", RUNS, *["--no-figures"] * (not figures)]
        self._processes.start(_key(run), [bench.command, "run", *options, *as_files([file])])
        return {"run": run, "simulator": bench.command}

    def resume(self, run: str) -> dict[str, Any]:
        """Go on with a run that was stopped, cut off, or failed."""
        bench, options = self._bench(run), ["--resume", f"{RUNS}/{run}"]
        with contextlib.suppress(FolderError):
            begun = RunFolder(self._path(run)).read_provenance().get("command", [])
            options += ["--no-figures"] * ("--no-figures" in begun)
        self._processes.start(_key(run), [bench.command, "run", *options])
        return {"run": run, "simulator": bench.command}

    def stop(self, run: str) -> dict[str, Any]:
        """Ask the process of a run to keep its state and end."""
        process = self._processes.get(_key(run))
        if process is None or process.code is not None:
            raise InputError(f"{run}: does not run now; nothing to stop")
        process.stop()
        return self.state(run)

    def state(self, run: str) -> dict[str, Any]:
        """State of a run: of its process, where the page started one, and of its folder."""
        folder = RunFolder(self._path(run))
        process = self._processes.get(_key(run))
        bench = self._bench(run, process.command[0] if process else None)
        return {
            "run": run,
            "simulator": bench.command,
            "state": self.doing(run),
            "failure": folder.failure or "",
            "process": process.state() if process else None,
        }

    def doing(self, run: str) -> str:
        """State of a run, which may not be there yet.

        "running" by the page, "elsewhere" by another program, or that of its folder.
        """
        folder, process = RunFolder(self._path(run)), self._processes.get(_key(run))
        if process is not None and process.code is None:
            return "running"
        state = folder.state
        return "elsewhere" if state == "unfinished" and folder.is_computed else state

    def results(self, run: str) -> dict[str, Any]:
        """Results of a finished run in words, and the names of its pictures and films."""
        path, bench = self._path(run), self._bench(run)
        figures = sorted(
            one.name for one in (path / "figures").glob("*") if one.suffix.lower() in _SHOWN
        )
        return {
            "words": bench.report(path).replace(f"{self._folder.root}/", ""),
            "figures": [f"{RUNS}/{run}/figures/{name}" for name in figures],
            "case": self._case(bench, run),
        }

    def _case(self, bench: Bench, run: str) -> Texts:
        """The texts of a run's case, with the files beside it by names from the chosen folder."""
        texts, beside = bench.texts(self._folder, f"{RUNS}/{run}/case.toml"), self._path(run)

        def named(text: str) -> str:
            there = "/" not in text and text.endswith(_BESIDE) and (beside / text).is_file()
            return f"{RUNS}/{run}/{text}" if there else text

        return {
            section: named(table)
            if isinstance(table, str)
            else {name: named(text) for name, text in table.items()}
            for section, table in texts.items()
        }

    def frame(self, run: str) -> dict[str, Any]:
        """The last stored frame of a run; empty where there is none yet."""
        try:
            return self._bench(run).frame(self._path(run))
        except FolderError:
            return {}

    def compare(self, first: str, second: str) -> dict[str, Any]:
        """Two runs of one simulator side by side: a table, and a picture in the first's folder."""
        bench = self._bench(first)
        if self._bench(second) is not bench:
            raise InputError("the runs are of two simulators; choose two of one")
        table, picture = bench.compare(self._path(first), self._path(second))
        return {"words": table, "figures": [picture.relative_to(self._folder.root).as_posix()]}

    def player(self, run: str) -> str:
        """The page that plays a finished run, which needs nothing but itself."""
        page, _ = self._bench(run).player(self._path(run), 1e6 * _PLAYER_MB)
        return page

    def _path(self, run: str) -> Path:
        if "/" in run:
            raise InputError(f"{run!r}: no run; give the name of its folder")
        return self._folder.path(f"{RUNS}/{run}")

    def _bench(self, run: str, command: str | None = None) -> Bench:
        """The simulator of a run, by the tables of its case."""
        if command is None:
            try:
                text = (self._path(run) / "case.toml").read_text(encoding="utf-8")
                tables = tomllib.loads(text)
            except OSError:
                raise InputError(f"{run}: no run of that name below {RUNS}") from None
            except ValueError:
                raise InputError(
                    f"{run}: its case.toml is damaged; restore it, or remove the folder"
                ) from None
            command = "silo2d" if "silo" in tables else "damper3d"
        return self._benches[command]


def _key(run: str) -> str:
    return f"{RUNS}/{run}"
