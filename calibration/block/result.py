"""Results of the films of a block on a plate: a plate tilted until it slips, and a slide."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from calibration.block.edge import Edge
from calibration.block.slip import Slip
from calibration.flow.result import numbers
from calibration.statistics.uncertainty import Estimate, as_pair
from calibration.tracking.track import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class _Film:
    path: Path

    @property
    def name(self) -> str:
        """Name of the film in file names."""
        return self.path.stem.strip("*?[]") or "pictures"


@dataclass(frozen=True)
class Tilted(_Film):
    """A plate that was tilted until a block on it slipped; a result to draw.

    frame      (n,) of the film
    angle      (n,) inclination of the plate [rad]
    way        (n,) of the block down the plate [px], NaN where it is not seen
    slip       frame of the first slip
    found      inclination there [rad]
    edge       in the first picture
    block      (c, 2) corners of the block there [px]
    """

    frame: Array
    rate: float | None
    angle: Array
    way: Array
    slip: Slip
    found: Estimate
    edge: Edge
    block: Array
    remarks: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """Series in radians and pixels, for JSON."""
        return {
            "film": self.path.name,
            "slip_frame": {"value": self.slip.time, "sigma": self.slip.sigma},
            "angle_rad": as_pair(self.found),
            "fps": self.rate,
            "frame": numbers(self.frame),
            "plate_rad": numbers(self.angle),
            "way_px": numbers(self.way),
        }

    def figure(self) -> "Figure":
        """Edge and block on the first picture, inclination and way against the frame."""
        from calibration.block.figure import draw_tilt

        return draw_tilt(self)


@dataclass(frozen=True)
class Slid(_Film):
    """A block that slides down a plate that stands; a result to draw.

    rate       frames/s used
    rests_on   where the rate comes from
    time       (n,) [s]
    way        (n,) down the plate [m]
    aside      (n,) across it [m]
    incline    of the plate [rad]
    path_px    (n, 2) of the block's middle in the picture
    """

    rate: float | None
    rests_on: str
    time: Array
    way: Array
    aside: Array
    incline: Estimate
    edge: Edge
    block: Array
    path_px: Array
    remarks: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """Series in SI, for JSON."""
        return {
            "film": self.path.name,
            "incline_rad": as_pair(self.incline),
            "fps": self.rate,
            "time_base": {"rests_on": self.rests_on, "checked": False},
            "time_s": numbers(self.time),
            "position_m": numbers(self.way),
        }

    def figure(self) -> "Figure":
        """Edge, block and its path on the first picture, its way and what leaves its line."""
        from calibration.block.figure import draw_slide

        return draw_slide(self)
