"""What a drop test leaves in a folder to be judged by: a sheet, and the annotated film."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from calibration.drop.result import Drop
from calibration.tracking.film.reader import Told, is_film, is_pattern, open_film
from calibration.tracking.track import Track


def with_pictures(
    drop: Drop,
    source: str | Path | Track | Sequence[Track],
    folder: Path,
    progress: Told | None = None,
) -> Drop:
    """The drop test with `sheet`, drop-NAME.png, and `film`, drop-NAME.mp4, where it was filmed.

    Raises FolderError where they cannot be written.
    """
    from calibration.drop.sheet import draw_sheet
    from calibration.tracking.film.annotate import annotate

    if not isinstance(source, str | Path):
        name = f"drop-{drop.bounces.track.name or 'track'}"
        return replace(drop, sheet=draw_sheet(drop, folder / f"{name}.png", name[5:]))
    name = _name(Path(source))
    sheet = folder / f"drop-{name}.png"
    if not is_film(source):
        return replace(drop, sheet=draw_sheet(drop, sheet, name))
    film, pictures = annotate(drop, open_film(source), folder / f"drop-{name}.mp4", progress)
    return replace(drop, sheet=draw_sheet(drop, sheet, name, pictures), film=film)


def _name(path: Path) -> str:
    """A film's own name; of pictures "im*.png" that of their folder."""
    named = path.parent if is_pattern(path) else path
    return named.resolve().stem
