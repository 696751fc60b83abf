"""Checkpoints: the arrays from which a run goes on to the same bits, sealed against damage.

Nothing of a damaged file reaches HDF5. A run keeps some of its earlier checkpoints too, the fewer
the older they are: where a part of its trajectory is damaged, it goes on from the one before it.

    checkpoint.h5    checkpoints/00012.h5, 00011.h5, 00010.h5, 00008.h5
"""

import json
import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from granulab.campaign.output.files import replacing, write_all
from granulab.campaign.runs.folder import RunFolder, plain
from granulab.campaign.runs.h5file import made, opened
from granulab.campaign.runs.seal import content


def save_checkpoint(
    path: str | Path, arrays: Mapping[str, np.ndarray], meta: Mapping[str, Any]
) -> None:
    """Write arrays (any shape, exact to the bit) and meta (numbers and texts) as one whole file.

    Raises FolderError when the file cannot be written; the one before it then stands.
    """
    with made(Path(path), "checkpoint") as file:
        group = file.create_group("arrays")
        for name, array in arrays.items():
            group.create_dataset(name, data=array)
        file["meta"] = json.dumps(meta, default=plain)


def load_checkpoint(path: str | Path) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """The arrays and meta that save_checkpoint wrote.

    Raises FolderError when the file is missing or of another schema, DamagedError when damaged,
    UnreadableError when it cannot be read now.
    """
    arrays: dict[str, np.ndarray] = {}

    def collect(name: str, item: h5py.Dataset | h5py.Group) -> None:
        if isinstance(item, h5py.Dataset):
            arrays[name] = np.asarray(content(item))

    with opened(Path(path), "checkpoint") as file:
        file["arrays"].visititems(collect)  # "grains/x" is a name too
        return arrays, json.loads(content(file["meta"]))


def keep_checkpoint(
    run: RunFolder, parts: int, arrays: Mapping[str, np.ndarray], meta: Mapping[str, Any]
) -> None:
    """Write the checkpoint of a run that has flushed so many parts; keep some of those before it.

    With n parts the checkpoint of m stays while n - m is less than twice the largest power of two
    that divides m: about log2(n) stand, and one lies before any damage, not much further back.
    Where the file system has no second names for a file, none of those before it is kept.
    """
    save_checkpoint(run.checkpoint, arrays, meta)
    older = run.checkpoints
    if older.is_symlink():  # nothing is removed elsewhere
        return
    with suppress(OSError):
        older.mkdir(exist_ok=True)
        this = older / f"{parts:05d}.h5"
        this.unlink(missing_ok=True)
        os.link(run.checkpoint, this)
        for path in older.glob("[0-9]*.h5"):
            known = int(path.stem)
            if not 0 <= parts - known < 2 * (known & -known):
                path.unlink()


def go_back(run: RunFolder, path: Path) -> None:
    """Make an earlier checkpoint of a run the newest: what is computed again may be cut elsewhere.

    A later one would go with other parts than those that it was written after.
    """
    for later in checkpoints(run)[1:]:
        if later == path:
            break
        later.unlink()
    with replacing(run.checkpoint) as file:
        write_all(file, path.read_bytes())


def checkpoints(run: RunFolder) -> list[Path]:
    """The checkpoints that a run may go on from, the newest first; empty where it has none."""
    if not run.checkpoint.exists():  # deleted, so that the run starts from its beginning
        return []
    there = [] if run.checkpoints.is_symlink() else run.checkpoints.glob("[0-9]*.h5")
    return [run.checkpoint, *sorted(there, key=lambda path: int(path.stem), reverse=True)]
