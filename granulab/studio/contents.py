"""Kinds of files by their endings, and whether a file is what its ending says, from its content."""

import tomllib
from collections.abc import Callable
from pathlib import Path

from granulab.errors import InputError

MB = 2**20
_HEAD = 4096  # bytes that tell a kind
_MOST = {"film": 2048 * MB, "data": 256 * MB, "picture": 64 * MB, "text": 64 * MB}  # of a file


def _begins(*starts: bytes, at: int = 0) -> Callable[[bytes], bool]:
    return lambda head: head[at:].startswith(starts)


def _riff(kind: bytes) -> Callable[[bytes], bool]:
    return lambda head: head[:4] == b"RIFF" and head[8:12] == kind


def _text(head: bytes) -> bool:
    return b"\0" not in head and bool(head.strip())


def _svg(head: bytes) -> bool:
    return _text(head) and head.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"<") and b"<svg" in head


def _dxf(head: bytes) -> bool:
    return _text(head) and b"SECTION" in head


Test = Callable[[bytes], bool]  # of the first bytes of a file

_PICTURES: dict[str, Test] = {
    ".png": _begins(b"\x89PNG\r\n\x1a\n"),
    ".jpg": _begins(b"\xff\xd8\xff"),
    ".jpeg": _begins(b"\xff\xd8\xff"),
    ".tif": _begins(b"II*\0", b"MM\0*"),
    ".tiff": _begins(b"II*\0", b"MM\0*"),
    ".bmp": _begins(b"BM"),
    ".webp": _riff(b"WEBP"),
}
_FILMS: dict[str, Test] = {
    ".mp4": _begins(b"ftyp", at=4),
    ".m4v": _begins(b"ftyp", at=4),
    ".mov": _begins(b"ftyp", b"moov", b"mdat", b"wide", b"free", at=4),
    ".avi": _riff(b"AVI "),
    ".mkv": _begins(b"\x1aE\xdf\xa3"),
    ".webm": _begins(b"\x1aE\xdf\xa3"),
}
_DATA: dict[str, Test] = {
    ".wav": _riff(b"WAVE"),
    ".xlsx": _begins(b"PK\x03\x04"),
    ".ods": _begins(b"PK\x03\x04"),
    ".xls": _begins(b"\xd0\xcf\x11\xe0"),
    ".stl": lambda head: bool(head),  # binary or text: read where it is used
}
_TEXTS: dict[str, Test] = {
    **dict.fromkeys((".toml", ".csv", ".txt", ".tsv", ".obj"), _text),
    ".svg": _svg,
    ".dxf": _dxf,
}
_KINDS = {"picture": _PICTURES, "film": _FILMS, "data": _DATA, "text": _TEXTS}
KIND = {ending: kind for kind, tests in _KINDS.items() for ending in tests}


def most_bytes(name: str) -> int:
    """Largest size of a file of this name; InputError for an ending that is not taken."""
    ending = Path(name).suffix.lower()
    if ending not in KIND:
        raise InputError(f"{name}: files of this kind are not taken; known: {', '.join(KIND)}")
    return _MOST[KIND[ending]]


def refuse_unless_it_is(path: Path, name: str) -> None:
    """Raise InputError where the content of a file at a path is not what its name says."""
    ending = Path(name).suffix.lower()
    most = most_bytes(name)
    if path.stat().st_size > most:
        raise InputError(f"{name}: larger than {most // MB} MB, the most that is taken")
    with path.open("rb") as file:
        head = file.read(_HEAD)
    if not _KINDS[KIND[ending]][ending](head):
        raise InputError(f"{name}: its content is no {ending[1:].upper()} file; nothing was kept")
    if ending == ".toml":
        try:
            tomllib.loads(path.read_text(encoding="utf-8"))
        except (ValueError, RecursionError) as error:
            reason = " ".join(str(error).split())
            raise InputError(f"{name}: not valid TOML ({reason}); nothing was kept") from None
