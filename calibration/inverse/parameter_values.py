"""Values of pairs and materials that follow from a fit, written into a parameter file."""

from pathlib import Path

import numpy as np

from calibration.files.parameter_file import Written, check_file, digest_of, into
from calibration.inverse.fit_file import Fit
from calibration.inverse.observation import Values
from calibration.inverse.result import Fitted
from calibration.inverse.statistics.identify import NARROWER
from calibration.statistics.uncertainty import Estimate
from granulab.errors import InputError


def refuse_unless_written(found: Fitted) -> None:
    """InputError where the values of a fit would mislead who uses them."""
    if found.goodness is not None and not found.goodness.reproducible:
        raise InputError(
            "--into: nothing is written, as the simulator cannot reproduce the observation"
        )
    if not (found.widths <= NARROWER).any():
        raise InputError("--into: nothing is written, as no parameter is identifiable")


def write_into(found: Fitted, path: Path) -> list[Written]:
    """Write what the identifiable parameters say of pairs and materials; method "inverse".

    A parameter may stand in several sections (kn in both pairs); sigma is half of the 68.3 %
    interval. Raises InputError; see calibration.files.parameter_file.into.
    """
    refuse_unless_written(found)
    fit = found.fit
    files = [one.file for _, one in fit.observations if one.file]
    files = list(dict.fromkeys([fit.path, *files]))
    source = f"{', '.join(file.name for file in files)}; simulated by {fit.simulated.campaign.name}"
    written = []
    for k in np.flatnonzero(found.widths <= NARROWER):
        for (section, key), (value, sigma) in _follows(found, int(k)).items():
            written.append(
                into(path, section, key, Estimate(value, sigma, 0), method="inverse",
                     source=source, digest=digest_of(files))
            )  # fmt: skip
    return written


def check_into(path: Path, fit: Fit) -> None:
    """InputError before the work, where a parameter of a fit has no section in a parameter file."""
    check_file(path)
    for k, prior in enumerate(fit.priors):
        moved = fit.middle
        moved[k] = prior.quantile(np.array(0.75))
        before, after = (fit.simulated.parameters(fit.case(0, x)) for x in (fit.middle, moved))
        if not _changed(before, after):
            raise InputError(
                f"--into {path}: {prior.name} is nothing that a parameter file holds; leave "
                "--into out"
            )


def _follows(found: Fitted, k: int) -> dict[tuple[str, str], tuple[float, float]]:
    """Values and sigmas in a parameter file that change with a parameter, by section and key."""
    fit = found.fit
    low, high = found.interval[:, k]

    coordinates = [_coordinates(found, k, value) for value in (low, found.mean[k], high)]
    below, at, above = (fit.simulated.parameters(fit.case(0, x)) for x in coordinates)
    return {
        section: (at[section], abs(above[section] - below[section]) / 2)
        for section in _changed(below, above)
    }


def _coordinates(found: Fitted, k: int, value: float) -> np.ndarray:
    """The posterior's mean with one parameter at a value."""
    x = found.posterior.samples.mean(axis=0)
    x[k] = found.fit.priors[k].coordinate(value)
    return x


def _changed(before: Values, after: Values) -> list[tuple[str, str]]:
    return [section for section in before if before[section] != after[section]]
