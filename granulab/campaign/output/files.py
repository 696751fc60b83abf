"""Files that are written whole, and refusals of places that cannot be written to."""

import errno
import io
import os
import secrets
import shlex
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from granulab.errors import FolderError

SHOWN = ("figures", "export")  # folders of a run that what shows it writes to, without its lock


@contextmanager
def writing(path: Path, option: str = "--out") -> Iterator[None]:
    """Turn an OSError of the enclosed lines into a FolderError about `path`.

    option: of the command line, which says where to write.
    """
    try:
        yield
    except OSError as error:
        if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
            cure = "make room there and start the run again: it goes on from its last checkpoint"
        else:
            cure = f"choose a folder you may write to with {option}"
        reason = error.strerror or type(error).__name__
        raise FolderError(f"{path}: cannot be written ({reason}); {cure}") from error


def refuse_unless_writable(folder: Path, option: str) -> None:
    """Raise FolderError where a folder cannot be made or written to; nothing is made.

    option: of the command line, which gave the folder.
    """
    with writing(folder, option):
        whole = folder.absolute()
        there = next(p for p in (whole, *whole.parents) if p.exists() or p.is_symlink())
        if not there.is_dir():
            raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR))
        if not os.access(there, os.W_OK | os.X_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))


@contextmanager
def replacing(path: str | Path) -> Iterator[io.FileIO]:
    """A new file that takes the place of one when the enclosed lines end, and none when they fail.

    At any moment, also after kill -9, the file is the old or the new one whole. Raises FolderError
    when it cannot be written (no permission, disk full), or a run folder's link leads elsewhere.
    """
    path = Path(path)
    _refuse_link_out(path.parent)
    # A name of its own: two processes may write the same file at once (a shared packing).
    part = path.with_name(f".{path.name}.{secrets.token_hex(4)}.tmp")
    with writing(path):
        try:
            with io.FileIO(part, "w+") as file:
                yield file
                os.fsync(file.fileno())
            part.replace(path)
        except BaseException:
            part.unlink(missing_ok=True)
            raise


def _refuse_link_out(folder: Path) -> None:
    """Raise FolderError for the folder of a run's pictures or exports that is a link.

    The run may be a stranger's, who would have files elsewhere replaced.
    """
    if folder.name in SHOWN and folder.is_symlink() and (folder.parent / "case.toml").exists():
        raise FolderError(f"{folder}: a link that leads out of the run folder; remove it")


def below(folder: Path) -> Iterator[Path]:
    """All files and folders below a folder; what goes meanwhile, as parts of a run do, is no error.

    Links are given and not followed; what cannot be read is left out.
    """

    def pass_over(error: OSError) -> None:
        if not isinstance(error, FileNotFoundError | NotADirectoryError | PermissionError):
            raise error

    for place, folders, files in os.walk(folder, onerror=pass_over):
        yield from (Path(place) / name for name in (*folders, *files))


def in_shell(word: str) -> str:
    """A word of a command line as the shell of this system takes it: quoted where it must be."""
    if sys.platform == "win32":
        import subprocess  # --help needs it not

        return subprocess.list2cmdline([word])
    return shlex.quote(word)


def write_atomic(path: str | Path, content: bytes | str) -> None:
    """Write a file whole; see replacing."""
    with replacing(path) as file:
        write_all(file, content.encode() if isinstance(content, str) else content)


def write_all(file: io.FileIO, content: bytes | memoryview) -> None:
    """Write all of some bytes: a disk that is nearly full takes a part and says so."""
    left = memoryview(content).cast("B")
    while left:
        left = left[file.write(left) :]
