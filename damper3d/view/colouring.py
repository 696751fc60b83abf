"""Colours of particles: by velocity along the motion, by power dissipated, or by kind."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from damper3d.view.scene import Scene
from granulab.contact.files.units import nearest
from granulab.errors import InputError

if TYPE_CHECKING:
    from matplotlib.cm import ScalarMappable

Array = NDArray[np.float64]

_DECADES = 3  # of power that colours resolve, down from the largest


@dataclass(frozen=True)
class Colouring:
    """A scale of colours that is the same in all pictures of a run.

    scale       a matplotlib ScalarMappable, to draw the colour bar with
    label       of the scale, with its unit
    name        "velocity", "dissipation" or "kind"
    ticks       of the colour bar; None: as matplotlib puts them
    """

    scene: Scene
    scale: "ScalarMappable"
    label: str
    name: str
    ticks: list[int] | None = None

    def of(self, frame: int) -> Array:
        """Colours (n, 3), between 0 and 1, of the particles in a frame."""
        return self.scale.to_rgba(VALUES[self.name](self.scene, frame))[:, :3]


def velocity(scene: Scene, frame: int) -> Array:
    """Velocity of the particles (n,) along the motion, in the lab [m/s]."""
    return scene.along(scene.particles(frame).velocity)


def power(scene: Scene, frame: int) -> Array:
    """Dissipated at the particles (n,) [W], mean since the frame before; 0 in the first one."""
    if frame == 0:
        return np.zeros(len(scene.radius))
    earlier, now = (scene.time[scene.frame_sample[k]] for k in (frame - 1, frame))
    gained = scene.particles(frame).dissipated - scene.particles(frame - 1).dissipated
    return gained / (now - earlier)


def kind(scene: Scene, _frame: int) -> Array:
    """Kinds of the particles (n,), counted from 1."""
    return scene.kind + np.float64(1.0)


VALUES = {"velocity": velocity, "dissipation": power, "kind": kind}


def colouring(scene: Scene, by: str, frames: list[int]) -> Colouring:
    """The scale for pictures of some frames; InputError where `by` names none.

    Velocities reach from minus to plus the 99th percentile of their size, at least to the
    largest velocity of the enclosure; powers over the three decades below their 99.9th.
    """
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import ListedColormap, LogNorm, Normalize

    if by not in VALUES:
        raise InputError(f"--by {by!r}: {nearest(by, VALUES)}")
    if by == "kind":
        known = colormaps["Set2"].colors  # type: ignore[attr-defined]  # of a listed map
        chosen = ListedColormap([known[k % len(known)] for k in range(scene.kinds)])
        norm = Normalize(0.5, scene.kinds + 0.5)  # a band for each number
        ticks = list(range(1, scene.kinds + 1))
        return Colouring(scene, ScalarMappable(norm, chosen), "kind", by, ticks)
    values = np.concatenate([VALUES[by](scene, frame) for frame in frames])
    if by == "velocity":
        limit = max(scene.peak_speed, float(np.percentile(np.abs(values), 99)))
        scale = ScalarMappable(Normalize(-limit, limit), "coolwarm")
        return Colouring(scene, scale, "velocity along\nthe motion [m/s]", by)
    largest = float(np.percentile(values, 99.9)) if (values > 0).any() else 1.0
    norm = LogNorm(largest / 10**_DECADES, largest, clip=True)
    return Colouring(scene, ScalarMappable(norm, "YlOrRd"), "dissipated at\na particle [W]", by)
