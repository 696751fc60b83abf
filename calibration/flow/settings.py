"""What a person says of a discharge film."""

from dataclasses import dataclass

COLUMNS = 11  # two grains wide each in the paper's silo


@dataclass(frozen=True)
class Settings:
    """What a person says of a film; lengths as text with units."""

    fps: float | None = None
    scale: str | None = None
    width: str | None = None
    roi: str | None = None
    interval: str | None = None
    columns: int = COLUMNS
    layer_height: str | None = None
    velocity: bool = True
