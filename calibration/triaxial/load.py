"""Load of a triaxial test at the moments of a film's frames."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from calibration.files.tables import read_table
from calibration.tracking.track import Array
from granulab.errors import InputError

_OVERLAP = 8  # frames with a load


class Record(NamedTuple):
    """A record of the load [N] by its clock, (m,) each: times [s] or frames, by `unit`."""

    path: str | Path
    clock: Array
    load: Array
    unit: str

    def at(self, frame: Array, time: Array | None, offset: float) -> Array:
        """(n,) load at each frame of a film [N]; NaN outside the record.

        frame, time   of the film; the record has the one or the other
        offset        time of the film when the record's clock is zero [s]

        Raises InputError where the film has no times, or the two hardly overlap.
        """
        clock, at = self.clock, frame
        if self.unit == "s":
            if time is None:
                raise InputError(f"{self.path}: has times, and the film no rate; give --fps")
            clock, at = clock + offset, time
        inside = (at >= clock[0]) & (at <= clock[-1])
        if inside.sum() < _OVERLAP:
            raise InputError(
                f"{self.path}: the record lasts from {clock[0]:.4g} to {clock[-1]:.4g} {self.unit} "
                f"of the film, the film from {at[0]:.4g} to {at[-1]:.4g}: they do not overlap; see "
                "--offset"
            )
        return np.where(inside, np.interp(at, clock, self.load), np.nan)


def read_record(path: str | Path) -> Record:
    """A table with a column "time" or "frame", and "load".

    Raises InputError where columns are missing, or the clock does not grow.
    """
    table = read_table(path)
    load = table.column("load", "N")
    if table.has("time", "s"):
        clock, unit = table.column("time", "s", "s"), "s"
    elif table.has("frame"):
        clock, unit = table.column("frame", "1"), "frames"
    else:
        raise InputError(f"{path}: no column 'time' and none 'frame': when was each load?")
    kept = np.isfinite(clock) & np.isfinite(load)
    clock, load = clock[kept], load[kept]
    if len(clock) < 2 or not np.all(np.diff(clock) > 0):
        raise InputError(f"{path}: its times do not grow from line to line")
    return Record(path, clock, load, unit)
