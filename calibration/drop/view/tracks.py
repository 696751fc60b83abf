"""The figure of a drop test that was refused: every track against time, and its stretches."""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from calibration.tracking.segments import position, stretches
from calibration.tracking.track import Track
from granulab.campaign.output.figure import BLUE, GREY, headline
from granulab.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST = 6  # tracks that are drawn: those of the widest range


@dataclass(frozen=True)
class Refused:
    """Tracks in which no drop test was found; `draw` of calibration.result writes its figure."""

    name: str
    tracks: Sequence[Track]

    def figure(self) -> "Figure":
        """y(frame) of the tracks of the widest range, and the parabolas that were found in each."""
        from matplotlib.figure import Figure

        kept = sorted(self._seen(), key=_range, reverse=True)[:_MOST]
        figure = Figure(figsize=(9, 1.2 + 2.2 * max(len(kept), 1)), layout="constrained")
        for k, track in enumerate(kept, start=1):
            axes = figure.add_subplot(len(kept), 1, k)
            axes.plot(track.frame, track.y, ".", color=GREY, ms=3)
            for one in stretches(track.clock, track.y):
                at = np.linspace(one.start, one.end, 50)
                y = [position(one, time) for time in at]
                axes.plot(np.interp(at, track.clock, track.frame), y, color=BLUE, lw=1)
            axes.set_ylabel(f"{track.name or 'track'}: y [{'px' if track.scale != 1 else 'm'}]")
            axes.invert_yaxis()
        if kept:
            axes.set_xlabel("frame")
        headline(figure, f"{self.name}: no drop test; positions, and stretches that are parabolas")
        return figure

    def _seen(self) -> Iterator[Track]:
        """Tracks that can be drawn; one with two positions in a frame cannot."""
        for track in self.tracks:
            with suppress(InputError):
                seen = track.seen()
                if len(seen.frame) > 1:
                    yield seen


def _range(track: Track) -> float:
    return float(np.ptp(track.y))
