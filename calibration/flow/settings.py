"""What a person says of a discharge film."""

from dataclasses import dataclass

COLUMNS = 11  # two grains wide each in the paper's silo


@dataclass(frozen=True)
class Settings:
    """What a person says of a film; lengths as text with units, roi as x, y, width, height [px]."""

    fps: float | None = None
    scale: str | None = None
    width: str | None = None
    roi: tuple[int, int, int, int] | None = None
    interval: str | None = None
    columns: int = COLUMNS
    layer_height: str | None = None
    velocity: bool = True
