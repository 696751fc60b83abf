"""The chosen folder: names of the page to files below it, and nothing outside."""

import os
import secrets
from collections.abc import AsyncIterator, Iterator, Mapping
from pathlib import Path
from typing import Any

from granulab.campaign.output.files import write_atomic, writing
from granulab.contact.files.casefile import folder_name
from granulab.errors import FolderError, InputError
from granulab.studio.contents import KIND, MB, most_bytes, refuse_unless_it_is

RUNS = "runs"  # of a folder, as the commands have it
_MOST_SHOWN = 500  # files of a kind


class Folder:
    """The folder that the page may read and write.

    Names are those of files in it, or in folders below it, with "/" between; they come from the
    page, so that none may lead out: not by "..", an absolute path, a drive, or a link.
    """

    def __init__(self, root: Path) -> None:
        self.root = root.resolve()

    @property
    def runs(self) -> Path:
        """Folder of the runs; it may not be there yet."""
        return self.path(RUNS)

    def path(self, name: str) -> Path:
        """The path of a name, there or not; InputError where it leads out of the folder."""
        parts = name.split("/")
        odd = any(part in ("", ".", "..") or {"\\", "\0", ":"} & set(part) for part in parts)
        path = self.root.joinpath(*parts) if not odd else self.root
        if odd or not path.resolve().is_relative_to(self.root):
            raise InputError(f"{name!r}: not within the folder of the studio; give a file in it")
        return path

    def file(self, name: str) -> Path:
        """The path of a file that is there; InputError where none is, or it leads out."""
        path = self.path(name)
        if not path.is_file():
            raise InputError(f"{name}: no such file in {self.root}")
        return path

    def refuse_outside(self, value: Any, where: str) -> None:
        """Raise InputError for a text, or any in tables and lists, that names a file outside.

        "10 N/mm" and "mesh:rock.stl" are none, or lead nowhere else.
        """
        for text in _texts_in(value):
            for name in (text, text.partition(":")[2]):
                try:
                    path = (self.root / name).resolve()
                    outside = "\0" in name or not path.is_relative_to(self.root)
                except (OSError, ValueError):
                    outside = True
                if outside:
                    raise InputError(f"{where} = {text!r}: not within the folder of the studio")

    def files(self, kind: str) -> list[str]:
        """Names of the files of a kind ("picture", "film", "data", "text") in the folder itself."""
        found = (
            entry.name for entry in os.scandir(self.root)
            if entry.is_file(follow_symlinks=False)
            and KIND.get(Path(entry.name).suffix.lower()) == kind
        )  # fmt: skip
        return sorted(found)[:_MOST_SHOWN]

    def write(self, name: str, text: str, replace: bool = False) -> bool:
        """Write a text under a name; False where another text stands there that may stay.

        The same text again is no change. InputError for a name that no file can have.
        """
        path = self.path(_checked(name))
        if path.is_file() and path.read_bytes() == text.encode():
            return True
        if path.exists() and not replace:
            return False
        write_atomic(path, text)
        return True

    async def receive(self, name: str, stream: AsyncIterator[bytes]) -> str:
        """Keep a file that the page sends, once it is found to be what it says; its name.

        Another of that name stays: the new one gets a number.
        """
        name, most = _checked(name), most_bytes(name)
        part = self.root / f".{secrets.token_hex(4)}.part"
        try:
            with writing(self.root, "--folder"), part.open("xb") as file:
                size = 0
                async for piece in stream:
                    size += len(piece)
                    if size > most:
                        raise InputError(f"{name}: larger than {most // MB} MB, the most taken")
                    file.write(piece)
            refuse_unless_it_is(part, name)
            target = _free(self.path(name), part)
            part.replace(target)
            return target.name
        finally:
            part.unlink(missing_ok=True)


def _texts_in(value: Any) -> Iterator[str]:
    """All texts in tables and lists."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, Mapping | list):
        for inner in value.values() if isinstance(value, Mapping) else value:
            yield from _texts_in(inner)


def _checked(name: str) -> str:
    """A name of a file in the folder itself; InputError where it can be none, on any system."""
    try:
        return folder_name(name)
    except ValueError as error:
        words = str(error).replace("the run folder is called after it", "no file can be called so")
        raise InputError(words.replace("name = ", "")) from None


def _free(path: Path, new: Path) -> Path:
    """The path, or with the first number that is free; the same content keeps its name."""
    for k in range(1, 1000):
        one = path if k == 1 else path.with_stem(f"{path.stem}-{k}")
        if not one.exists() or _same(one, new):
            return one
    raise FolderError(f"{path.name}: a thousand of that name are there; give another")


def _same(one: Path, other: Path) -> bool:
    if not one.is_file() or one.stat().st_size != other.stat().st_size:
        return False
    with one.open("rb") as a, other.open("rb") as b:
        while piece := a.read(MB):
            if piece != b.read(MB):
                return False
    return True


def listed(folder: Folder) -> dict[str, Any]:
    """The files of the folder by kind, for the page."""
    return {kind: folder.files(kind) for kind in ("text", "picture", "film", "data")}
