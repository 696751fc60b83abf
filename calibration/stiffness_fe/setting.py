"""Setting of the test from the command's options: what the paper gives, and what is ours.

The paper gives E, nu, both frictions and the markers' displacements (Table 1); an amplitude of
100 um for the roughness across the fibres; and A = 10 mm x 120 mm with L = 20 mm (sec. 3.2.1),
which are two blocks 10 mm wide, 10 mm high and 120 mm deep. Everything else is ours.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from calibration.statistics.quantity import measured_quantity
from calibration.statistics.uncertainty import Estimate
from calibration.stiffness_fe import markers
from calibration.stiffness_fe.assumptions import Setting
from calibration.stiffness_fe.blocks import Elastic
from calibration.stiffness_fe.protocol import Case, Load
from calibration.stiffness_fe.surfaces import Paths, Waves, read_paths
from granulab.contact.files.units import to_si
from granulab.errors import InputError

PROFILES = 8  # pairs of them, drawn by chance
_FRICTION = {"flat": 0.37, "rough": 0.2}  # sec. 3.2.2
_AMPLITUDE = 100e-6  # m, across the fibres (sec. 3.2.1), taken from valley to summit
_RA = _AMPLITUDE / math.pi  # Ra of a sine of that range, thesis eq. 7.1
_WAVELENGTH = 1e-3  # m: ours; the text gives none
_COLUMNS_A_WAVE = 8  # four on half as many columns, from which the mesh's error is estimated
_LARGEST_STRAIN = 0.1  # the theory is one of small strains
_ROUGHEST = 0.1  # of a block's height: rougher ones have no bulk


def read_setting(given: Mapping[str, Any]) -> tuple[Setting, float]:
    """The test of the command's options, and the relative sigma of Young's modulus."""
    modulus = measured_quantity(given["youngs_modulus"], "Pa", "--E")
    _positive(modulus.value, "Pa", "--E")
    material = Elastic(modulus.value, _poisson(given["poisson"]), given["plane"])
    width, height, depth = (_length(given[key], f"--{key}") for key in ("width", "height", "depth"))
    case = Case(material, width, height, depth, given["sides"], given["mesh"])
    flat, rough = (_load(given, name) for name in ("flat", "rough"))
    for load in (flat, rough):
        _check_travel(load, case)
    _refuse_of_rough(given)
    surface = _surface(given, case)
    if given["surface"] != "flat":
        _check_surface(surface, case)
    return Setting(case, flat, rough, surface), (modulus.sigma or 0.0) / modulus.value


def read_kn(text: str | None, needed: bool) -> Estimate | None:
    """A measured normal stiffness [N/m]; the blocks' own is that of their size, not a contact's."""
    if text is None:
        if needed:
            raise InputError('--into: kt = (kt/kn) kn: give kn, such as --kn "1e4 N/mm +- 18 %"')
        return None
    known = measured_quantity(text, "N/m", "--kn")
    _positive(known.value, "N/m", "--kn")
    return Estimate(known.value, known.sigma, 1)


def _load(given: Mapping[str, Any], surface: str) -> Load:
    table = markers.printed(surface)
    friction = _FRICTION[surface] if given["friction"] is None else given["friction"]
    if not 0 <= friction <= 2:
        raise InputError(f"--friction = {friction:g}: a number from 0 to 2, such as 0.37")
    across, along = (
        default if given[key] is None else _length(given[key], f"--{key}")
        for key, default in (("across", table.across), ("along", table.along))
    )
    return Load(friction, across, along)


def _refuse_of_rough(given: Mapping[str, Any]) -> None:
    """Raise InputError for an option of rough surfaces where only the flat contact is tested."""
    options = {"profiles": "profile", "columns": "column"} | {
        key: key.replace("_", "-") for key in ("roughness", "wavelength", "random_profiles")
    }
    if given["surface"] == "flat":
        for key, flag in options.items():
            if given[key] not in (None, ()):
                raise InputError(
                    f"--{flag}: of rough surfaces, and --surface is flat: leave it out"
                )
    if given["columns"] and not given["profiles"]:
        raise InputError(
            "--column: names one of a measured profile: give --profile, or leave it out"
        )


def _surface(given: Mapping[str, Any], case: Case) -> Waves | Paths:
    made = [f"--{key}" for key in ("roughness", "wavelength") if given[key] is not None]
    if given["profiles"]:
        if made:
            raise InputError(f"{made[0]} is of a made surface, --profile a measured one: give one")
        return read_paths(given["profiles"], given["columns"])
    ra, wavelength = (
        default if given[key] is None else _length(given[key], f"--{key}")
        for key, default in (("roughness", _RA), ("wavelength", _WAVELENGTH))
    )
    if ra > _ROUGHEST * case.height:
        raise InputError(
            f"--roughness = {ra:g} m: at most a tenth of the blocks' height, "
            f"{_ROUGHEST * case.height:g} m"
        )
    return Waves(ra, wavelength)


def _check_surface(surface: Waves | Paths, case: Case) -> None:
    """Refuse now what would not do after the flat contact's test."""
    least = _COLUMNS_A_WAVE * case.width / case.columns
    if isinstance(surface, Waves) and surface.wavelength < least * (1 - 1e-9):
        raise InputError(
            f"--wavelength = {surface.wavelength:g} m: {case.columns} columns on {case.width:g} m "
            f"show waves from {least:g} m on; a larger --mesh would do, or a smaller --width"
        )
    surface.draw(case.points(), False, np.random.default_rng(0))


def _check_travel(load: Load, case: Case) -> None:
    if load.across > _LARGEST_STRAIN * 2 * case.height:
        raise InputError(
            f"--across = {load.across:g} m: blocks of together {2 * case.height:g} m would be "
            f"strained by more than 10 %; at most {_LARGEST_STRAIN * 2 * case.height:g} m"
        )
    if load.along > case.width / 4:
        raise InputError(
            f"--along = {load.along:g} m: at most a quarter of the width, {case.width / 4:g} m"
        )


def _poisson(value: float) -> float:
    if not -1 < value < 0.5:
        raise InputError(f"--nu = {value:g}: Poisson's ratio lies between -1 and 0.5, such as 0.2")
    return value


def _length(text: str, flag: str) -> float:
    return _positive(to_si(text, "m", flag), "m", flag)


def _positive(value: float, unit: str, flag: str) -> float:
    if value <= 0:
        raise InputError(f"{flag} = {value:g} {unit}: must be more than 0")
    return value
