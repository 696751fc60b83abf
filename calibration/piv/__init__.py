"""The displacement between two pictures: particle image velocimetry and optical flow."""

from calibration.piv.field import Field, Reason
from calibration.piv.measure import displacement

__all__ = ["Field", "Reason", "displacement"]
