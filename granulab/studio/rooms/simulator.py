"""Cases of a simulator on the page: checked, written as TOML, opened; whichever simulator it is."""

import contextlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from granulab.contact.files.casefile import Section
from granulab.errors import FolderError, InputError
from granulab.studio.folder import Folder
from granulab.studio.forms import Texts, case_form, document, texts_of, to_toml

SCHEMA = 1
_HEAD = "Made by granulab studio; `{command} run {file}` runs it."


@dataclass(frozen=True)
class Bench:
    """A simulator, as far as the page builds and runs its cases.

    command    name of its command and module
    settings   the schema
    presets    cases that are known by name
    read       the tables of a case file
    resolve    a case from tables, its name for refusals, and the folder of files that it names
    simulator  its part in sweeps: digest and run folder of a case
    echo       a case in words, with what its run would take
    preview    what is shown of a case before anything runs, for the page to draw
    sketch     what can be shown of a case that is refused, from its tables and its name; or None
    start      the particles of a case, as its filling begins with them, where that takes kernels:
               a function that another process calls with what resolve takes; or None
    frame      the last stored frame of a run in a folder, for the page; raises FolderError
    report     the results of a finished run in words
    compare    two runs side by side in words, and a picture of both
    player     a page that plays a run, of at most so many bytes, and a remark on it
    """

    command: str
    settings: type[Section]
    presets: Callable[[], list[str]]
    preset: Callable[[str], dict[str, Any]]
    read: Callable[[Path], dict[str, Any]]
    resolve: Callable[[dict[str, Any], str, Path], Any]
    simulator: Any
    echo: Callable[[Any], str]
    preview: Callable[[Any], dict[str, Any]]
    frame: Callable[[Path], dict[str, Any]]
    report: Callable[[Path], str]
    compare: Callable[[Path, Path], tuple[str, Path]]
    player: Callable[[str | Path, float], tuple[str, str]]
    sketch: Callable[[dict[str, Any], str], dict[str, Any]] | None = None
    start: Callable[[dict[str, Any], str, Path], dict[str, Any]] | None = None

    def form(self) -> list[dict[str, Any]]:
        """Sections and keys of its cases."""
        return case_form(self.settings)

    def check(self, folder: Folder, texts: Texts) -> dict[str, Any]:
        """A case as the texts of a form have it: its words, its file, its run; or its refusal.

        The refusal is the line that the command would say of the file.
        """
        found: dict[str, Any] = {"toml": "", "refused": "", "file": ""}
        tables: dict[str, Any] = {}
        try:
            tables, file = self.tables(folder, texts)
            found |= {"toml": self.written(tables), "file": file}
            case = self.resolve(tables, file, folder.root)
            run = self.simulator.run_folder(case, folder.runs)
        except (InputError, FolderError) as error:
            if self.sketch is not None:
                with contextlib.suppress(InputError):  # the line is said already
                    found["preview"] = self.sketch(tables, found["file"])
            return {**found, "refused": str(error).replace(f"{folder.root}/", "")}
        return {
            **found,
            "words": _rows(self.echo(case)),
            "run": run.path.name,
            "state": run.state,
            "digest": self.simulator.digest(case),
            "preview": self.preview(case),
        }

    def tables(self, folder: Folder, texts: Texts) -> tuple[dict[str, Any], str]:
        """The tables of a case from the texts of a form, and the name of its file.

        Raises InputError where they name a file outside of the folder.
        """
        tables = document(self.settings, texts)
        file = f"{tables.setdefault('name', 'case')}.toml"
        folder.refuse_outside(tables, file)
        return tables, file

    def written(self, tables: Mapping[str, Any]) -> str:
        """The case file of some tables."""
        file = f"{tables.get('name', 'case')}.toml"
        return to_toml(tables, SCHEMA, _HEAD.format(command=self.command, file=file))

    def texts(self, folder: Folder, name: str) -> Texts:
        """The texts of a preset, or of a case file in the folder."""
        if name in self.presets():
            return texts_of(self.preset(name))
        return texts_of(self._of_file(folder, name, "choose a case"))

    def _of_file(self, folder: Folder, name: str, cure: str) -> dict[str, Any]:
        """The tables of a case file in the folder; InputError where it is of something else."""
        tables = self.read(folder.file(name))
        others = [_KINDS[one] for one in _KINDS if one in tables]
        others = [one for one in others if one != f"a case of {self.command}"]
        if others:
            raise InputError(f"{name}: holds {others[0]}, no case of {self.command}; {cure}")
        return tables

    def save(self, folder: Folder, texts: Texts, replace: bool) -> dict[str, Any]:
        """Write the case file of a form, where no other stands under its name or it may go.

        A file of the same tables stays as it is, with its comments. InputError where the file
        holds something else than a case.
        """
        checked = self.check(folder, texts)
        if checked["refused"]:
            raise InputError(checked["refused"])
        file = checked["file"]
        if folder.path(file).is_file():
            there = texts_of(self._of_file(folder, file, "give the case another name"))
            if document(self.settings, there) == self.tables(folder, texts)[0]:
                return {"file": file, "exists": False, "run": checked["run"]}
        if not folder.write(file, checked["toml"], replace):
            return {"file": file, "exists": True}
        return {"file": file, "exists": False, "run": checked["run"]}


def _rows(echo: str) -> list[tuple[str, str]]:
    """Label and words of each line of a case in words; the first line is about the whole."""
    first, *lines = echo.splitlines()
    ends = [max(line.find(" ", _LABEL), _LABEL) for line in lines]  # longer ones have one space
    rows = [(line[:end].strip(), line[end:].strip()) for line, end in zip(lines, ends, strict=True)]
    return [("case", first), *rows]


_LABEL = 13  # column where the label of a line ends
# What a file holds that has one of these tables.
_KINDS = {
    "silo": "a case of silo2d", "enclosure": "a case of damper3d", "motion": "a case of damper3d",
    "shape": "shapes", "spheroradius": "shapes", "material": "materials", "pair": "materials",
    "vary": "a study", "structure": "a structure to be damped",
}  # fmt: skip
