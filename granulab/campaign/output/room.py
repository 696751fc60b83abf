"""Room that runs need at most, on disk and in memory: reckoned, reported, and looked for."""

import math
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

CONTACTS = 7.0  # of a particle, at most: found 2.2 to 6.3 in beds, each counted once
_OF_A_FILE, _OF_THE_WHOLE = 35e3, 150e3  # [B] names and places of arrays; found 22 kB and 120 kB
_AS_TEXT = 3.0  # a number in records.csv over its 8 bytes
_HELD = 2.0  # frames until they are written: as they were taken, and end to end
_OF_ARRAYS = 60e6  # [B] chunks of all arrays while the parts of a trajectory are merged


def on_disk(
    *,
    frames: Sequence[tuple[float, float]],
    numbers: float,
    contacts: tuple[float, float],
    parts: float,
    checkpoint: float,
    merged: bool = True,
) -> dict[str, int]:
    """Bytes that a run takes at most but for pictures: frames, contacts, checkpoints.

    frames      kinds of them: how many, and bytes of one
    numbers     that records.csv has
    contacts    tables of them, and bytes of one
    parts       files of frames until the end, and as many checkpoints of so many bytes, of which
                about log2(parts) stand
    merged      whether they end in one file: it may be as long as the parts, which go after it
    """
    times = 2.0 if merged else 1.0
    of_frames = times * sum(count * each for count, each in frames)
    found = {
        "frames": of_frames + parts * _OF_A_FILE + _OF_THE_WHOLE + 8 * _AS_TEXT * numbers,
        "contacts": times * contacts[0] * contacts[1],
        "checkpoints": (math.log2(max(parts, 1.0)) + 3) * (checkpoint + _OF_A_FILE),
    }
    return {name: math.ceil(n_bytes) for name, n_bytes in found.items()}


def in_memory(process: float, unwritten: float) -> int:
    """Bytes of memory that a run takes at most.

    process     of the program with its kernels, compiled just now, and the particles
    unwritten   of the frames between two checkpoints
    """
    return math.ceil(process + _HELD * unwritten + _OF_ARRAYS)


def lines(disk: Mapping[str, int], memory: int) -> list[str]:
    """Lines of an echo on what a run takes at most."""
    parts = ", ".join(f"{name} {in_words(n_bytes)}" for name, n_bytes in disk.items())
    return [
        f"  disk        at most {in_words(sum(disk.values()))} besides pictures: {parts}",
        f"  memory      at most {in_words(memory)}",
    ]


def line(planned: Mapping[str, Any]) -> str:
    """Line of the plan of many runs on the disk that they take at most."""
    needed, there = (in_words(planned[key]) for key in ("disk_bytes_at_most", "disk_free_bytes"))
    return f"disk        at most {needed} besides pictures; {there} are free"


def in_words(n_bytes: float) -> str:
    """Bytes with two digits: 35 kB, 1.2 MB, 20 GB."""
    for unit, size in (("GB", 1e9), ("MB", 1e6)):
        if n_bytes >= 0.995 * size:
            digits = 1 if n_bytes < 9.95 * size else 0
            return f"{n_bytes / size:,.{digits}f} {unit}"
    return f"{math.ceil(n_bytes / 1e3)} kB"


def free(folder: Path) -> int:
    """Bytes that are free on the disk of a folder, which may not be there yet."""
    whole = folder.absolute()
    return shutil.disk_usage(next(p for p in (whole, *whole.parents) if p.is_dir())).free


def shortage(needed: float, folder: Path) -> str | None:
    """A warning where less is free on the disk of a folder than may be needed; None where not."""
    there = free(folder)
    if needed <= there:
        return None
    return (
        f"the disk of {folder} has {in_words(there)} left and up to {in_words(needed)} may be "
        "needed: make room, take another folder with --out, or keep less ([output])"
    )
