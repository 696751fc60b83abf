"""The page that plays a run: what a simulator's picture is made of, and thinning it to a size.

A simulator gives a `Recording` of some of its frames; parts/player.js plays it.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from granulab.campaign.output.page.document import document
from granulab.campaign.output.page.packing import (
    LEVELS,
    Quantised,
    counted,
    linear,
    logarithmic,
    on_scale,
    packed,
)
from granulab.campaign.output.room import in_words
from granulab.errors import InputError

Floats = NDArray[np.float64]
Facts = Mapping[str, tuple[str, Callable[[Any], str]]]  # by key: its label, and its value in words

SCRIPTS = ("data.js", "scale.js", "contacts.js", "theme.js", "legend.js", "marks.js", "plane.js",
           "shaders.js", "space.js", "curves.js", "picture.js", "controls.js",
           "player.js")  # fmt: skip
DECADES_OF_FORCE = 5.0
_DECADES = 3.0  # that the colours of a force or a stress resolve
_HIGHEST = 99.5  # percentile of the values that a scale of colours ends with
_FEW_WALL_LEVELS = 60  # of where a particle touches a wall, each way
_CURVE = 2000  # samples of a curve, at most about
_FRAMES = 60_000  # of a page, at most: 16 bits count them


class Colour(NamedTuple):
    """A quantity by which particles are coloured.

    per       "particle" (n,), "frame" (F, n), or "moment" (M, n), a frame with contacts
    low, high  ends of the scale
    names     of categories, in whose place the array has numbers; or how many are `numbered` from 1
              on; colours come again where they are fewer
    """

    label: str
    unit: str
    per: str
    array: str
    colours: Sequence[str]
    low: float = 0.0
    high: float = 1.0
    names: Sequence[str] | None = None
    numbered: int = 0


class Line(NamedTuple):
    """A line of a chart: its values (T,), and its colour, None: that of ink."""

    label: str
    values: Floats
    colour: str | None = None
    dashed: bool = False


class Touching(NamedTuple):
    """Bodies that touch at a moment, walls numbered after the n particles; SI.

    frame     of the run
    bodies    (c, 2), ascending in each and from row to row
    force     (c,) size of the force between them
    pulls     (c,) whether it pulls
    branch    (w, d) from the particle's centre to the wall, of the rows with one in turn
    """

    frame: int
    bodies: NDArray[np.int64]
    force: Floats
    pulls: NDArray[np.bool_]
    branch: Floats


@dataclass
class Recording:
    """Content of a page: the data that stand in it as JSON, its arrays, and its colours."""

    data: dict[str, Any]
    arrays: dict[str, Quantised] = field(default_factory=dict)
    colours: list[Colour] = field(default_factory=list)
    curves: list[dict[str, Any]] = field(default_factory=list)

    def add_colour(self, colour: Colour) -> None:
        """Add a quantity whose array is there, or is made of the contacts' forces."""
        self.colours.append(colour)

    def add_scale(self, label: str, unit: str, values: Floats, colours: Sequence[str], *,
                  name: str) -> None:  # fmt: skip
        """Add a quantity from 0 to the most that all but a few particles have; in thousandths."""
        high = (float(np.percentile(values, _HIGHEST)) if values.size else 0.0) or 1.0
        self.arrays[name] = linear(values, high / LEVELS)
        self.add_colour(Colour(label, unit, "frame", name, colours, 0.0, high))

    def add_decades(self, label: str, unit: str, values: Floats, colours: Sequence[str], *,
                    name: str, per: str) -> None:  # fmt: skip
        """Add a quantity over decades; nothing where none of its values is positive."""
        if not (values > 0.0).any():
            return
        self.arrays[name] = logarithmic(values, DECADES_OF_FORCE)
        high = float(np.percentile(values[values > 0.0], _HIGHEST))
        self.add_colour(Colour(label, unit, per, name, colours, high / 10**_DECADES, high))

    def add_curve(
        self, name: str, unit: str, time: Floats,
        series: Sequence[Line], *,
        window: float | None = None, since: float = 0.0, spans: Sequence[dict[str, Any]] = (),
        steps: bool = False,
    ) -> None:  # fmt: skip
        """Add a chart of some lines over time (T,) [s].

        window   of the time [s] that is shown at once; None: all of it
        since    the time [s] from which on the values decide the scale
        spans    from, to [s], label and colour of what is marked
        steps    whether values hold until the next
        """
        every = max(1, len(time) // _CURVE)
        at = f"curve{len(self.curves)}"
        self.arrays[f"{at}_time"] = linear(time[::every], 0.0, order=2)
        drawn = []
        for k, line in enumerate(series):
            self.arrays[f"{at}_{k}"] = on_scale(line.values[::every])
            drawn.append({"label": line.label, "colour": line.colour, "dashed": line.dashed,
                          "array": f"{at}_{k}"})  # fmt: skip
        self.curves.append(
            {"name": name, "unit": unit, "time": f"{at}_time", "series": drawn, "window": window,
             "since": since, "spans": list(spans), "steps": steps}
        )  # fmt: skip

    def add_contacts(
        self, moments: Sequence[Touching], time: Floats, frames: NDArray[np.int64], n: int,
        colours: Sequence[str],
    ) -> list[int]:  # fmt: skip
        """Add the contacts that the frames show, and the forces on n particles as a colour.

        Of moments between two frames the last is taken. time (F,) [s] of the run's frames. Gives
        the numbers of the moments taken; none where no contact ever was.
        """
        after = np.searchsorted(frames, [moment.frame for moment in moments])
        taken = [
            k for k, frame in enumerate(after)
            if frame < len(frames) and (k + 1 == len(after) or after[k + 1] != frame)
        ]  # fmt: skip
        shown = [moments[k] for k in taken]
        if not any(len(moment.bodies) for moment in shown):
            return []
        bodies = np.concatenate([moment.bodies for moment in shown])
        force = np.concatenate([moment.force for moment in shown])
        branch = np.concatenate([moment.branch for moment in shown])
        reach = float(np.abs(branch).max(initial=0.0))
        self.arrays |= {
            "first": counted(bodies[:, 0]),
            "second": counted(bodies[:, 1]),
            "force": logarithmic(force, DECADES_OF_FORCE, order=0),
            "pulls": counted(np.concatenate([moment.pulls for moment in shown])),
            "branch": linear(branch, reach / _FEW_WALL_LEVELS, order=0),
            "moment_frame": counted(after[taken]),
            "moment_length": counted([len(moment.bodies) for moment in shown]),
            "moment_time": linear(time[[moment.frame for moment in shown]], 0.0, order=2),
        }
        high = float(np.percentile(np.concatenate([_on_each(m, n) for m in shown]), _HIGHEST))
        high = high or float(force.max())
        self.data["usual_force"] = float(force.mean())
        self.add_colour(Colour("force", "N", "moment", "force", colours, high / 10**_DECADES, high))
        return taken

    def add_wall_forces(self, force: Floats, counted_from: int = 0) -> None:
        """Add the forces on the walls in each frame (F, walls, d) [N].

        counted_from: the frame from which on the largest decides how long arrows are.
        """
        flat = force.reshape(len(force), -1)
        largest = float(np.linalg.norm(force[counted_from:], axis=2).max(initial=0.0))
        self.arrays["wall_force"] = linear(flat, float(np.abs(flat).max()) / _CURVE)
        self.data["largest_wall_force"] = largest or 1.0


def _on_each(moment: Touching, n: int) -> Floats:
    """Sum of the sizes of the forces on each particle that is touched."""
    total = np.zeros(n)
    for column in moment.bodies.T:
        of_particle = column < n
        np.add.at(total, column[of_particle], moment.force[of_particle])
    return total[total > 0.0]


def player(
    record: Callable[[NDArray[np.int64]], Recording], time: Floats, most_bytes: float
) -> tuple[str, str]:
    """The page of a run, and a remark where it has not all of the frames, "" where it has.

    record   gives the recording of some frames (k,) of the run; each second, third, ... is taken
             until the page is small enough
    time     of all frames (F,) [s]

    Raises InputError where a page of two frames would be larger than `most_bytes`.
    """
    total = len(time)
    stride = -(-total // _FRAMES)
    while True:
        frames = np.arange(0, total, stride)
        remark = "" if stride == 1 else (
            f"Every {_ordinal(stride)} of the run's {total} frames, for a page of at most "
            f"{in_words(most_bytes)}."
        )  # fmt: skip
        page = _page(record(frames), time[frames], remark)
        if len(page) <= most_bytes:
            return page, remark
        if len(frames) <= 2:
            raise InputError(
                f"--size: {in_words(most_bytes)} hold no two frames of this run, which take "
                f"{in_words(len(page))}; give more"
            )
        stride = max(stride + 1, min(math.ceil(stride * len(page) / most_bytes), total - 1))


def _page(recording: Recording, time: Floats, remark: str) -> str:
    arrays = {"time": linear(time, 0.0, order=2), **recording.arrays}
    heads, binary = packed(arrays)
    data: Mapping[str, Any] = {
        "usual_force": 1.0,
        "largest_wall_force": 1.0,
        "period": None,
        "counted": "",
        "pull_words": "",
        **recording.data,
        "frames": len(time),
        "arrays": heads,
        "colours": [colour._asdict() for colour in recording.colours],
        "curves": recording.curves,
        "notes": [*recording.data.get("notes", []), *([remark] if remark else [])],
    }
    return document("player.html", SCRIPTS, str(data["title"]), data, binary)


def _ordinal(k: int) -> str:
    """Ordinal of a number from 2 on, such as "2nd"."""
    last = 0 if 10 < k % 100 < 14 else k % 10
    return f"{k}{ {1: 'st', 2: 'nd', 3: 'rd'}.get(last, 'th') }"


def facts(summary: Mapping[str, Any], of: Facts) -> list[list[str]]:
    """Results of a run in words; those that it has not are left out."""
    return [
        [label, words(summary[key])]
        for key, (label, words) in of.items()
        if summary.get(key) is not None
    ]


def colours_of(name: str, number: int = 17) -> list[str]:
    """Colours #rrggbb along a colour map of matplotlib."""
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    return [to_hex(colormaps[name](part)) for part in np.linspace(0.0, 1.0, number)]
