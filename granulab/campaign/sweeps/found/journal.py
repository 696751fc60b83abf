"""Journal of a study: a line for each finished run, so that a repeated sweep opens no run folder.

The sweep appends a line as it hears of a run. A line counts while folder and summary are what they
were, by their times and the summary's size. Where one is torn or damaged, the folder is read.
"""

import hashlib
import json
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Self

from granulab.campaign.output.files import write_all
from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.seal import open_kept

_NEW_LINE = b"\n"


class Journal:
    """The lines of a journal, and the file that they are appended to.

    A line is the first 12 digits of the SHA-256 of what follows, a space, and a JSON list: name of
    the run's folder, its stamp (see _stamp), digests of the sources that made it, fields.
    """

    def __init__(self, path: Path | None) -> None:
        """The journal in a file, which need not exist; None: one that keeps nothing."""
        self._path = path
        self._file: Any = None
        self._lines: dict[str, tuple[Any, Any, dict[str, Any]]] = {}  # by name of the folder

    def __enter__(self) -> Self:
        if self._path is None:
            return self
        kept = b""
        with suppress(OSError), open_kept(self._path) as file:
            kept = file.read()
        for line in kept.splitlines():
            match _opened(line):
                case [str() as name, stamp, made_by, dict() as fields]:
                    self._lines[name] = stamp, made_by, fields
        with suppress(OSError):  # a full disk: then the folders are read the next time
            self._file = self._path.open("ab", buffering=0)
            if kept and not kept.endswith(_NEW_LINE):
                write_all(self._file, _NEW_LINE)  # a torn line takes no other with it
        return self

    def __exit__(self, *_: object) -> None:
        if self._file is not None:
            self._file.close()

    def fields(self, folder: RunFolder, made_by: Sequence[str]) -> dict[str, Any] | None:
        """The fields of a finished run; None where no line counts for it.

        made_by: digests of the sources that would make it now; those of others are read.
        """
        stamp, by, fields = self._lines.get(folder.path.name, (None, None, None))
        return fields if by == list(made_by) and stamp == _stamp(folder) else None

    def add(self, folder: RunFolder, made_by: Sequence[str], fields: dict[str, Any]) -> None:
        """Append the line of a finished run; nothing where its summary is not seen here yet.

        On a shared disk a file may be seen late: that folder is read the next time.
        """
        stamp = _stamp(folder)
        if self._file is None or stamp is None:
            return
        text = json.dumps([folder.path.name, stamp, list(made_by), fields]).encode()
        with suppress(OSError):
            write_all(self._file, _seal(text) + b" " + text + _NEW_LINE)


def _seal(text: bytes) -> bytes:
    return hashlib.sha256(text).hexdigest()[:12].encode()


def _opened(line: bytes) -> Any:
    """Content of a line; None where it is not whole."""
    seal, _, text = line.partition(b" ")
    return json.loads(text) if seal == _seal(text) else None


def _stamp(folder: RunFolder) -> list[int] | None:
    """Times [ns] of a folder, in which a file was last replaced, and of its summary; size [B]."""
    try:
        place, summary = folder.path.stat(), (folder.path / "summary.json").stat()
    except OSError:
        return None
    return [place.st_mtime_ns, summary.st_mtime_ns, summary.st_size]
