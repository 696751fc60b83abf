"""Load of a triaxial test at the moments of a film's frames."""

from pathlib import Path

import numpy as np

from calibration.files.tables import read_table
from calibration.tracking.track import Array
from granulab.errors import InputError

_OVERLAP = 8  # frames with a load


def load_at(path: str | Path, frame: Array, time: Array | None, offset: float) -> Array:
    """(n,) load at each frame [N]; NaN outside the record.

    frame, time   of the film; the record has a column "time" or "frame", and "load"
    offset        time of the film when the record's clock is zero [s]

    Raises InputError where columns are missing, or film and record hardly overlap.
    """
    table = read_table(path)
    load = table.column("load", "N")
    if table.has("time", "s"):
        if time is None:
            raise InputError(f"{path}: has times, and the film no rate; give --fps")
        clock, at, unit = table.column("time", "s", "s") + offset, time, "s"
    elif table.has("frame"):
        clock, at, unit = table.column("frame", "1"), frame, "frames"
    else:
        raise InputError(f"{path}: no column 'time' and none 'frame': when was each load?")
    kept = np.isfinite(clock) & np.isfinite(load)
    clock, load = clock[kept], load[kept]
    if len(clock) < 2 or not np.all(np.diff(clock) > 0):
        raise InputError(f"{path}: its times do not grow from line to line")
    inside = (at >= clock[0]) & (at <= clock[-1])
    if inside.sum() < _OVERLAP:
        raise InputError(
            f"{path}: the record lasts from {clock[0]:.4g} to {clock[-1]:.4g} {unit} of the film, "
            f"the film from {at[0]:.4g} to {at[-1]:.4g}: they do not overlap; see --offset"
        )
    return np.where(inside, np.interp(at, clock, load), np.nan)
