"""Methods of the bench as functions, one for each command that reads tables: files to a result.

Columns, units and equations are those of the command: docs/laboratory/bench.md.
"""

import importlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypedDict, Unpack

if TYPE_CHECKING:
    from calibration.bench.measure import Measurement, Quantity
    from calibration.tracking.film.reader import Progress

Files = str | Path | Sequence[str | Path]
Named = Mapping[str, str] | Sequence[str]
Region = tuple[int, int, int, int]  # x, y, width, height [px]


class Inputs(TypedDict, total=False):
    """Description of the tables of a method, by keyword; with units, as the options have it.

    columns      {input: head in the file}, of columns called otherwise: {"load": "Force [kN]"}
    constants    {input: value} that all trials share, instead of a column: {"length": "30 cm"}
    instruments  {input: sigma} that all trials share, such as a zero: {"angle": "0.2 deg"}
    readings     {input: sigma} that differs from trial to trial
    group        head of the column that distinguishes pairings; "group" or "pairing" if there is
    only         the one group to evaluate

    Each of the first four may also be a list of texts "input=value".
    """

    columns: Named
    constants: Named
    instruments: Named
    readings: Named
    group: str | None
    only: str | None


class Method(NamedTuple):
    """The function of a method in its module of calibration.bench, and what it finds.

    writes   {property of a parameter file: key of its quantity}
    """

    function: str
    writes: Mapping[str, str]


METHODS = {
    "heights": Method("restitution", {"restitution": "restitution"}),
    "incline": Method("friction", {"friction": "friction"}),
    "slide": Method("damping", {"gamma_t": "gamma_t_per_s"}),
    "compression": Method("stiffness", {"kn": "kn_n_per_m", "youngs_modulus": "youngs_modulus_pa"}),
    "interface": Method("stiffness_ratio", {"kt": "kt_n_per_m"}),
    "roughness": Method("mean_roughness", {}),
    "density": Method("density", {"density": "density_kg_m3"}),
}


def measure_heights(files: Files, **inputs: Unpack[Inputs]) -> "Measurement":
    """Restitution from heights of drop and rebound, e = sqrt(H1/H0) (eqs 3.5, 3.6).

    files: tables, with a row a trial, a column a drop height, or means with standard deviations.
    inputs: see Inputs. Raises InputError, one line, for what cannot be measured.
    """
    return _measured("heights", files, inputs)


def measure_incline(
    files: Files, *, along: Literal["slope", "base"] = "slope", fps: float | None = None,
    roi: Region | None = None, start_angle: str | None = None,
    progress: "Progress | None" = None, **inputs: Unpack[Inputs],
) -> "Measurement":  # fmt: skip
    """Friction from the angle of first slip, mu = tan(alpha), of tables or films (sec. 3.1).

    files        tables, a row a trial; or films of a plate that is tilted until a block slips
    along        where L of a table was measured
    fps, roi     of films
    start_angle  "0 deg": inclination of a film's plate in its first frame
    inputs       see Inputs

    Raises InputError, one line, for what cannot be measured.
    """
    return _measured("incline", files, inputs, along=along, fps=fps, roi=roi,
                    start_angle=start_angle, progress=progress)  # fmt: skip


def measure_slide(
    files: Files, *, trial: str | None = None, start: Literal["rest", "any"] = "rest",
    fps: float | None = None, roi: Region | None = None, scale: str | None = None,
    progress: "Progress | None" = None, **inputs: Unpack[Inputs],
) -> "Measurement":  # fmt: skip
    """Tangential damping gamma_t of a sliding block, of tables or films (eqs 3.11a-c).

    files            tables, v(t) or x(t) of a trial, or a row a trial; or films of the block
    trial            head of the column that distinguishes curves of one file
    start            "rest" at t = 0 (eq. 3.11b), or "any" velocity there
    fps, roi, scale  of films: "0.5 mm/px"
    inputs           see Inputs

    Raises InputError, one line, for what cannot be measured.
    """
    return _measured("slide", files, inputs, trial=trial, start=start, fps=fps, roi=roi,
                    scale=scale, progress=progress)  # fmt: skip


def measure_compression(
    files: Files = (), *, trial: str | None = None, share: tuple[float, float] = (0.95, 0.5),
    least_cycle: float = 0.1, **inputs: Unpack[Inputs],
) -> "Measurement":  # fmt: skip
    """Unloading stiffness of each cycle, modulus, and kn = E A/L, as far as the inputs suffice.

    files        records of load and displacement, one a trial; none where constants say all
    trial        head of the column that distinguishes records of one file
    share        upper and lower share of each fall of the load that the slope is fitted to
    least_cycle  a fall by less than this share of the range of the load is no cycle
    inputs       see Inputs

    Raises InputError, one line, for what cannot be measured.
    """
    return _measured("compression", files, inputs, trial=trial, share=share,
                    least_cycle=least_cycle)  # fmt: skip


def measure_interface(files: Files, **inputs: Unpack[Inputs]) -> "Measurement":
    """kt/kn = (sigma_t/sigma_n) (dx_n/dx_t) of an interface (eq. 3.3); kt where kn is given.

    files: tables, a row a marker. inputs: see Inputs. Raises InputError, one line, for what cannot
    be measured.
    """
    return _measured("interface", files, inputs)


def measure_roughness(
    files: Files, *, trial: str | None = None,
    form: Literal["mean", "line", "parabola", "circle"] = "line", **inputs: Unpack[Inputs],
) -> "Measurement":  # fmt: skip
    """Mean roughness Ra = (1/L) integral |z| dx [m] of profiles z(x) (thesis, eq. 7.1).

    files   tables, a path a trial
    trial   head of the column that distinguishes paths of one file
    form    taken off the profile first, by least squares
    inputs  see Inputs

    Raises InputError, one line, for what cannot be measured.
    """
    return _measured("roughness", files, inputs, trial=trial, form=form)


def measure_density(files: Files, **inputs: Unpack[Inputs]) -> "Measurement":
    """Density [kg/m3], mass over volume.

    files: tables of masses and sizes, a row a particle. inputs: see Inputs. Raises InputError, one
    line, for what cannot be measured.
    """
    return _measured("density", files, inputs)


def _measured(name: str, files: Files, inputs: Inputs, **own: Any) -> "Measurement":
    """The result of a method. own: arguments that only this method takes."""
    from calibration.bench.measure import Measurement
    from calibration.bench.sections import request_of

    module = importlib.import_module(f"calibration.bench.{name}")
    method = METHODS[name]
    paths = [files] if isinstance(files, str | Path) else list(files)
    named = {key: _options(value) for key, value in inputs.items()}
    found = getattr(module, method.function)(paths, request_of(module.INPUTS, **named), **own)
    first = replace(found[0], remarks=(*found[0].remarks, *_idle(found)))
    return Measurement((first, *found[1:]), name, method.writes, not paths)


def _idle(found: "Sequence[Quantity]") -> list[str]:
    """A remark on each input whose uncertainty was given and is in no result."""
    names = set.intersection(*(set(one.idle) for one in found))
    return [
        f"the uncertainty of {name} is in no sigma: nothing here depends on {name}, or an offset "
        "of a whole curve leaves its slope as it is"
        for name in sorted(names)
    ]


def _options(value: Any) -> Any:
    """A table as the options that the command takes; all else as it is."""
    if isinstance(value, Mapping):
        return [f"{name}={text}" for name, text in value.items()]
    return value
