"""The TOML file of a fit: simulator, case, parameters with priors, observations, runs."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from calibration.files.parameter_file import digest_of
from calibration.inverse.observation import Observation, Simulated, Written
from calibration.inverse.statistics.data import Observed
from calibration.inverse.statistics.prior import Array, Prior, prior_of
from granulab.campaign.runs.folder import digest
from granulab.contact.files.casefile import folder_name
from granulab.contact.files.datafile import is_file, read_toml
from granulab.contact.files.units import located, nearest
from granulab.errors import InputError

NAMES = ("silo2d", "damper3d")


def simulator(name: str) -> Simulated:
    """The simulator of a name, "silo2d" or "damper3d"."""
    if name == "silo2d":
        from calibration.inverse.silo import SIMULATED
    else:
        from calibration.inverse.damper import SIMULATED
    return SIMULATED


SCHEMA = 1
MAX_RUNS = 100_000  # more is taken for a slip
# For each parameter: ten of a first design are the rule of Loeppky et al. (Technometrics 51 (2009)
# 366); half of eight cover the prior, where a plane needs one more than there are parameters.
_USUAL_POINTS, _LEAST_POINTS = 10, 8
_KEYS = (
    "name", "simulator", "case", "seeds", "runs", "draw_seed", "settings", "parameters",
    "observation",
)  # fmt: skip


@dataclass(frozen=True)
class Fit:
    """A fit as its file has it, checked.

    cases           case and changes by key of each motion or silo that is simulated
    observations    with the number of the case of each
    points          how many points of the parameters are simulated, `seeds` times each
    """

    path: Path
    name: str
    text: str
    simulated: Simulated
    cases: tuple[tuple[str, dict[str, Any]], ...]
    priors: tuple[Prior, ...]
    observations: tuple[tuple[int, Observation], ...]
    seeds: int
    points: int
    draw_seed: int

    @property
    def runs(self) -> int:
        """Number of runs that it takes."""
        return self.points * self.seeds * len(self.cases)

    @property
    def middle(self) -> Array:
        """Coordinates (p,) of the priors' medians."""
        return np.array([prior.quantile(np.array(0.5)) for prior in self.priors])

    @property
    def digest(self) -> str:
        """Names the fit: its file, what was measured, and the case."""
        files = sorted({str(o.file) for _, o in self.observations if o.file})
        return digest({
            "text": self.text,
            "files": [digest_of([Path(file)]) for file in files],
            "case": self.simulated.campaign.digest(self.case(0, self.middle)),
        })  # fmt: skip

    def case(self, number: int, x: Array) -> Any:
        """One of the cases at coordinates (p,); InputError where the simulator refuses it."""
        name, changes = self.cases[number]
        keys = self.simulated.keys
        written = {
            key: keys.written(key, float(prior.value(float(coordinate))))
            for prior, coordinate in zip(self.priors, x, strict=True)
            for key in prior.keys
        }
        return self.simulated.load(name, changes | written)

    def observed(self) -> Observed:
        """All values one after the other, and the trials that passed or not.

        Without an entry of clogging nothing is known of trials that clogged: values are those of
        the trials that did not, whatever the chance of such a one.
        """
        values = [o for _, o in self.observations if len(o.values)]
        counted = [o for _, o in self.observations if not len(o.values)]
        return Observed(
            np.concatenate([np.zeros(0), *(o.values for o in values)]),
            np.concatenate([np.zeros(0), *(o.sigma for o in values)]),
            np.concatenate([np.zeros(0), *(np.full(len(o.values), o.trials) for o in values)]),
            sum(o.trials - o.blocked for o in counted),
            sum(o.blocked for o in counted),
        )


def read_fit(path: str | Path) -> Fit:
    """The fit of a TOML file; InputError, one line with file, key and what would do."""
    path = Path(path)
    if not is_file(path):
        raise InputError(f"{path}: no such file; calibrate inverse FIT --init writes one")
    document = read_toml(path, "fits", SCHEMA)
    with located(f"{path}:"):
        return _fit(document, path, path.read_text(encoding="utf-8"))


def _fit(document: dict[str, Any], path: Path, text: str) -> Fit:
    for key in document:
        if key not in _KEYS:
            raise InputError(f"unknown key {key!r}; {nearest(key, _KEYS)}")
    name = document.get("name", path.stem)
    try:
        folder_name(name)
    except ValueError as error:
        raise InputError(str(error)) from None
    if document.get("simulator") not in NAMES:
        raise InputError(f"simulator = {document.get('simulator')!r}: one of {', '.join(NAMES)}")
    simulated = simulator(document["simulator"])
    priors = _priors(document.get("parameters"), simulated)
    fitted = [key for prior in priors for key in prior.keys]
    settings = _settings(document.get("settings", {}), simulated, fitted)
    cases, observations = _observations(document, path.parent, simulated, settings, fitted)
    seeds, draw_seed = _count(document, "seeds", 3, 2), _count(document, "draw_seed", 1, 0)
    points = _points(document, seeds * len(cases), len(priors))
    fit = Fit(path, name, text, simulated, cases, priors, observations, seeds, points, draw_seed)
    _check_ends(fit)
    return fit


def _entries(tables: Any, where: str) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Keys that stand together, and what is written for them; by section or "section.key"."""
    if not isinstance(tables, dict):
        raise InputError(f"{where}: must be a table")
    for name, written in tables.items():
        if "." in name:
            yield tuple(key.strip() for key in name.split(",")), written
        elif isinstance(written, dict) and "distribution" not in written:
            yield from (((f"{name}.{key}",), value) for key, value in written.items())
        else:
            raise InputError(f"{where} {name}: write section.key, such as law.mu_wall")


def _priors(tables: Any, simulated: Simulated) -> tuple[Prior, ...]:
    found: list[Prior] = []
    for keys, written in _entries(tables or {}, "[parameters]"):

        def read(part: str, value: Any, keys: tuple[str, ...] = keys) -> float:
            numbers = [simulated.keys.read("[parameters]", key, value) for key in keys]
            number = numbers[0]
            if isinstance(number, bool) or not isinstance(number, int | float):
                raise InputError(f"[parameters] {keys[0]}: {part} = {value!r}: must be a number")
            return float(number)

        for key in keys:
            _refuse_twice(key, [k for prior in found for k in prior.keys], "[parameters]")
            if key == "run.seed":
                raise InputError("[parameters] run.seed: the fit chooses the seeds")
        found.append(prior_of(keys, written, read, simulated.keys.unit))
    if not found:
        raise InputError("[parameters] is missing; give a prior for at least one key of a case")
    return tuple(found)


def _refuse_twice(key: str, there: list[str], where: str) -> None:
    if key in there:
        raise InputError(f"{where} {key}: stands there twice")


def _settings(tables: Any, simulated: Simulated, fitted: list[str]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for keys, written in _entries(tables, "[settings]"):
        for key in keys:
            if key in fitted:
                raise InputError(f"[settings] {key}: is a parameter of the fit; leave it out")
            _refuse_twice(key, list(found), "[settings]")
            simulated.keys.read("[settings]", key, written)
            found[key] = written
    return found


def _observations(
    document: dict[str, Any],
    folder: Path,
    simulated: Simulated,
    settings: dict[str, Any],
    fitted: list[str],
) -> tuple[tuple[tuple[str, dict[str, Any]], ...], tuple[tuple[int, Observation], ...]]:
    """The cases that are simulated, and what was observed of each."""
    tables = document.get("observation")
    if not isinstance(tables, list) or not tables:
        raise InputError("[[observation]] is missing; give at least one measured value or table")
    cases: list[tuple[str, dict[str, Any]]] = []
    found: list[tuple[int, Observation]] = []
    for k, table in enumerate(tables, start=1):
        where = f"[[observation]] {k}:"
        if not isinstance(table, dict) or table.get("kind") not in tuple(simulated.kinds):
            kind = table.get("kind") if isinstance(table, dict) else table
            known = ", ".join(simulated.kinds)
            raise InputError(f"{where} kind = {kind!r}: {simulated.campaign.name} has {known}")
        table = dict(table)
        kind, case = table.pop("kind"), table.pop("case", document.get("case"))
        if not isinstance(case, str) or not case:
            raise InputError(f"case = {case!r}: write a preset or a case file")
        name = str(folder / case) if is_file(folder / case) else case
        written = Written(table, folder, where)
        observations = simulated.kinds[kind].read(written)
        written.end()
        for one in observations:
            setting = (name, settings | dict(one.changes))
            _refuse_given(one, where, settings, fitted)
            if setting not in cases:
                cases.append(setting)
            found.append((cases.index(setting), one))
    if any(o.blocked for _, o in found) and len(cases) > 1:
        raise InputError("clogging goes with one case; fit the others apart")
    return tuple(cases), tuple(found)


def _refuse_given(
    one: Observation, where: str, settings: dict[str, Any], fitted: list[str]
) -> None:
    for key, _ in one.changes:
        for table, keys in (("settings", list(settings)), ("parameters", fitted)):
            if key in keys:
                raise InputError(f"{where} each row has its {key}; leave it out of [{table}]")


def _count(document: dict[str, Any], key: str, usual: int, least: int) -> int:
    value = document.get(key, usual)
    if not isinstance(value, int) or isinstance(value, bool) or not least <= value <= MAX_RUNS:
        raise InputError(f"{key} = {value!r}: give a whole number, {least} or more")
    return value


def _points(document: dict[str, Any], a_point: int, parameters: int) -> int:
    """Number of points that the runs suffice for; InputError for too few to fit to."""
    least = _LEAST_POINTS * parameters
    runs = _count(document, "runs", _USUAL_POINTS * parameters * a_point, 1)
    if runs // a_point < least:
        raise InputError(
            f"runs = {runs}: {runs // a_point} points of {a_point} runs (seeds times cases); give "
            f"{least * a_point} at least, {_LEAST_POINTS} points for each parameter"
        )
    return runs // a_point


def _check_ends(fit: Fit) -> None:
    """InputError where the simulator does not take a prior's end, the others in the middle.

    A case that it does not take as it stands has an error of its own, and no prior is to blame.
    """
    for name, changes in fit.cases:
        fit.simulated.load(name, changes)
    for k, prior in enumerate(fit.priors):
        for share in (0.0, 1.0):
            x = fit.middle
            x[k] = prior.quantile(np.array(share))
            try:
                for number in range(len(fit.cases)):
                    fit.case(number, x)
            except InputError as error:
                value = prior.ends[int(share)]
                unit = "" if prior.unit == "1" else f" {prior.unit}"
                raise InputError(
                    f"[parameters] {prior.name}: the prior reaches to {value:.4g}{unit}, which "
                    f"{fit.simulated.campaign.name} does not take ({error}); give min and max"
                ) from None
