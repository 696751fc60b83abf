"""measure_flow: the film of a silo that empties to times, curve, profiles and velocities."""

from collections.abc import Callable
from pathlib import Path

from calibration.flow.result import Flow
from calibration.flow.silo import Settings, check_columns, check_options, find_silo, layer_height
from calibration.flow.survey import survey
from calibration.flow.watch import Watch
from calibration.tracking.film.reader import frame_rate, open_film
from granulab.contact.files.units import to_si
from granulab.errors import InputError

INTERVAL = 0.25  # s, as in the paper's figures


def measure_flow(
    path: str | Path, settings: Settings, report: Callable[[float, str], None] = lambda f, w: None
) -> Flow:
    """Read a film twice, frame by frame: what is where, then what moves how.

    report    of the fraction done and of what goes on
    Raises InputError, one line, where something cannot be measured.
    """
    film = open_film(path)
    rate = frame_rate(film, settings.fps)
    interval = (
        INTERVAL if settings.interval is None else to_si(settings.interval, "s", "--interval")
    )
    if not interval * rate >= 1:
        raise InputError(
            f"--interval {settings.interval or f'{interval:g} s'}: shorter than a frame, "
            f"{1 / rate:.3g} s; say a longer one"
        )
    check_options(film, settings.roi, settings.scale, settings.width)
    check_columns(settings.columns, settings.roi[2] if settings.roi else film.width)
    layer_height(settings)
    try:
        seen = survey(film, lambda part: report(0.2 * part, "first look"))
        silo = find_silo(film, seen, settings.roi, settings.scale, settings.width)
        check_columns(settings.columns, silo.width)
    except InputError as error:
        text = str(error)
        raise InputError(text if str(path) in text else f"{path}: {text}") from None
    watch = Watch(film, rate, interval, seen, silo, settings)
    for frame in film.frames():
        watch.see(frame.number, frame.picture)
        report(0.2 + 0.8 * frame.number / seen.count, "following the material")
    return watch.flow()
