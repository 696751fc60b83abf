"""measure_triaxial: the film of two loaded blocks and the load's record to kn and kt."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from calibration.bench.compression import Branch
from calibration.result import checked
from calibration.statistics.correlated import propagated
from calibration.statistics.uncertainty import Estimate
from calibration.tracking.film.reader import Progress, frame_rate, open_film, said_rate
from calibration.tracking.film.stamps import clean_stamps
from calibration.tracking.track import Array
from calibration.triaxial.blocks import Line, relative
from calibration.triaxial.load import read_record
from calibration.triaxial.markers import Dots, follow
from calibration.triaxial.result import Setting, Triaxial
from calibration.triaxial.stiffness import Slopes, slopes
from granulab.contact.material import Measured
from granulab.errors import InputError

_READ = 0.5  # px: sigma of a point that is read off a picture
NAMES = ("kn", "kt", "kt_over_kn", "kn_rotation_left_in", "kt_rotation_left_in")
_UNLOADING = Branch(0.9, 0.1, 0.3)
_SHOWN = 4.0  # sigma by which a displacement must be seen: its reciprocal is the stiffness


def measure_triaxial(
    film: str | Path,
    load: str | Path,
    *,
    contact: Sequence[float],
    scale: Measured,
    inclination: Measured | None = None,
    load_line: float | None = None,
    fps: float | None = None,
    offset: float = 0.0,
    branch: Branch = _UNLOADING,
    progress: Progress | None = None,
) -> Triaxial:
    """Normal and tangential stiffness of an inclined contact between two blocks (sec. 3.2).

    film         two blocks with at least two dots on each, loaded vertically
    load         table of the vertical load, against time or frame
    contact      x1, y1, x2, y2: ends of the contact in the first frame [px]
    scale        metres per pixel
    inclination  of the contact to the horizontal [rad]; else that of `contact`
    load_line    x of the line along which the load acts [px]: gives the contact moment
    fps          frames per second; overrides what time stamps say
    offset       time of the film when the record's clock is zero [s]
    branch       part of each unloading that is fitted

    Raises InputError, one line, for what cannot be measured.
    """
    opened = open_film(film)
    line = _line(contact, opened.width, opened.height)
    angle = inclination or Measured(line.inclination, 2**0.5 * _READ / line.length)
    if not 0 < angle.value < np.radians(60):
        raise InputError(
            f"--inclination: {np.degrees(angle.value):.3g} degrees: above 0, where nothing is "
            "sheared, and below 60, where blocks slide: tan(alpha) is below the friction"
        )
    _refuse_load_line(load_line, opened.width)
    said_rate(fps)
    record = read_record(load)
    dots = follow(opened, progress)
    moved = relative(dots, line, str(film))
    setting = Setting(line, angle, scale, load_line)
    force = record.at(dots.frame, _times(dots, opened.rate, fps, film), offset)
    seen = np.stack([moved.x, moved.y, moved.rotation, moved.mean_x, moved.mean_y])
    fitted = slopes(force, seen, branch, str(film))
    values = _stiffness(fitted, setting)
    _refuse_unknown(values, str(film))
    found = Triaxial(dots, moved, force, setting, fitted, values)
    found = replace(found, path=Path(film), warnings=tuple(_warnings(found)))
    checked(found.to_dict(), [film])
    return found


def _line(contact: Sequence[float], width: int, height: int) -> Line:
    ends = np.array(contact, dtype=float).reshape(2, 2)
    inside = np.all((ends >= 0) & (ends < [width, height]))
    if not inside or np.abs(ends[1, 0] - ends[0, 0]) < 2:
        raise InputError(
            f"--contact {','.join(f'{one:g}' for one in contact)}: two ends of the contact, x1,y1,"
            f"x2,y2, side by side within the picture of {width} x {height} px"
        )
    return Line(ends)


def _refuse_load_line(x: float | None, width: int) -> None:
    if x is not None and not 0 <= x < width:
        raise InputError(
            f"--load-line {x:g}: x of the line along which the load acts, within the picture: 0 to "
            f"below {width} px"
        )


def _times(dots: Dots, rate: float | None, fps: float | None, film: str | Path) -> Array | None:
    """Times of the frames [s], None where no rate is known."""
    if fps is not None:
        return np.asarray((dots.frame - dots.frame[0]) / frame_rate(open_film(film), fps))
    stamps = [None if np.isnan(t) else float(t) for t in dots.time]
    time, _ = clean_stamps([int(n) for n in dots.frame], stamps, rate)
    return time


def _stiffness(fitted: Slopes, setting: Setting) -> dict[str, Estimate]:
    """NAMES [N/m], and what the moment does; sigma of noise, inclination and scale."""
    angle, scale = setting.inclination, setting.scale
    values = np.array([*fitted.value, angle.value, scale.value])
    read = np.diag(np.square([0.0] * 5 + [angle.sigma or 0.0, scale.sigma or 0.0]))

    def quantities(q: Array) -> Array:
        alpha, length = q[5], q[6]
        axes = setting.line.axes(float(alpha))
        found = []
        for c in (q[:2], q[3:5]):
            along, across = axes @ c * length
            found += [np.cos(alpha) / across, np.sin(alpha) / along]
        kn, kt, kn_left, kt_left = found
        return np.array([kn, kt, kt / kn, kn_left, kt_left])

    found = [
        propagated(values, np.pad(one, (0, 2)) + read, quantities) for one in fitted.covariances
    ]
    known, sigma = found[0][0], np.sqrt(np.max([np.diag(spread) for _, spread in found], axis=0))
    stiff = {
        name: Estimate(float(v), float(s), len(fitted.branches))
        for name, v, s in zip(NAMES, known, sigma, strict=True)
    }
    return stiff | _moment(fitted, setting)


def _moment(fitted: Slopes, setting: Setting) -> dict[str, Estimate]:
    """Rotation per load [rad/N], and with a line of load: its lever [m], stiffness [N m/rad]."""
    turn = float(fitted.value[2])
    turn_sigma = float(np.sqrt(max(one[2, 2] for one in fitted.covariances)))
    trials = len(fitted.branches)
    found = {"rotation_per_load": Estimate(turn, turn_sigma, trials)}
    if setting.load_line is None:
        return found
    values = np.array([
        turn, setting.load_line, float(setting.line.middle[0]), setting.scale.value,
    ])  # fmt: skip
    sigma = [turn_sigma, _READ, _READ / 2**0.5, setting.scale.sigma or 0.0]
    known, spread = propagated(
        values, np.diag(np.square(sigma)),
        lambda q: np.array([(q[1] - q[2]) * q[3], (q[1] - q[2]) * q[3] / q[0]]),
    )  # fmt: skip
    error = np.sqrt(np.diag(spread))
    found["eccentricity"] = Estimate(float(known[0]), float(error[0]), trials)
    if abs(turn) > _SHOWN * turn_sigma:
        found["rotational_stiffness"] = Estimate(float(known[1]), float(error[1]), trials)
    return found


def _refuse_unknown(values: dict[str, Estimate], where: str) -> None:
    """InputError where load and displacement do not go together."""
    for name, way in (("kn", "across the contact"), ("kt", "along it, down the slope")):
        one = values[name]
        if one.value < _SHOWN * (one.sigma or 0.0):
            raise InputError(
                f"{where}: {name} = {one.value:.3g} +- {one.sigma or 0.0:.2g} N/m: no displacement "
                f"{way} falls with the load beyond noise; film nearer, or check --contact and "
                "--offset"
            )


def _warnings(found: Triaxial) -> list[str]:
    said = []
    turn, sigma = found.values["rotation_per_load"].value, found.values["rotation_per_load"].sigma
    ends = abs(turn) * found.setting.line.length / 2
    axes = found.setting.line.axes(found.setting.inclination.value)
    across = abs(float((axes @ found.fitted.value[:2])[1]))
    if abs(turn) > _SHOWN * (sigma or 0.0) and ends > across / 2:
        said.append(
            f"the blocks rotate: the contact's ends move by {ends / across:.1f} of its middle's "
            "approach as the load falls: a contact moment bends it, and kn and kt are those of a "
            "contact that is not pressed evenly (sec. 3.2)"
        )
    if len(found.fitted.branches) == 1:
        said.append(
            "one unloading: sigma is that of its frames' noise; how far unloadings differ is not "
            "known"
        )
    if found.setting.load_line is None:
        said.append("the contact moment is not known: give --load-line, where the load acts")
    return said
