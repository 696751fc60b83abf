"""Result of a fit: posterior, identifiability of the parameters, and how well it meets the data."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from calibration.files.parameter_file import Written
from calibration.inverse.fit_file import Fit
from calibration.inverse.statistics.data import Runs
from calibration.inverse.statistics.identify import NARROWER, Direction, Goodness
from calibration.inverse.statistics.posterior import Posterior
from calibration.inverse.statistics.prior import Array
from granulab.campaign.runs.folder import RunFolder
from granulab.contact.files.units import from_si

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Fitted:
    """A fit that was made; a result (calibration.result).

    mean, sd, median    (p,) of the posterior, in SI
    interval            (2, p) that holds 68.3 % of it, as much being below as above
    written             what of it stands in a parameter file
    """

    fit: Fit
    folder: RunFolder
    runs: Runs
    posterior: Posterior
    mean: Array
    sd: Array
    median: Array
    interval: Array
    widths: Array
    correlations: Array
    directions: list[Direction]
    goodness: Goodness | None
    warnings: list[str]
    written: tuple[Written, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Values in the SI unit that is named with them."""
        fit, good = self.fit, self.goodness
        ended = [run.ended for run in self.runs.runs]
        return {
            "simulator": fit.simulated.campaign.name,
            "cases": [name for name, _ in fit.cases],
            "parameters": [_parameter(self, k) for k in range(len(fit.priors))],
            "correlations": self.correlations.tolist(),
            "directions": [
                {
                    "along": dict(zip(_names(self), d.along.tolist(), strict=True)),
                    "information": d.information,
                    "width_over_prior": d.width,
                    "identifiable": d.identifiable,
                }
                for d in self.directions
            ],
            "goodness": None if good is None else {
                "chi2": good.chi2,
                "freedom": good.freedom,
                "p": good.p,
                "p_rest": good.p_rest,
                "reproducible": good.reproducible,
            },
            "observations": _observations(self),
            "points": len(self.runs.points),
            "runs": {
                "total": len(ended),
                **{word: ended.count(word) for word in ("passed", "blocked", "failed")},
            },
            "samples": {
                "effective": self.posterior.effective,
                "autocorrelation_steps": self.posterior.memory,
            },
            "warnings": self.warnings,
            "folder": str(self.folder.path),
            "table": str(self.folder.path / "table.csv"),
            "into": [one.as_json() for one in self.written],
        }  # fmt: skip

    def text(self) -> str:
        """Parameters with their intervals, what the observation determines, and the fit."""
        name = self.fit.simulated.campaign.name
        ended = [run.ended for run in self.runs.runs]
        blocked, failed = ended.count("blocked"), ended.count("failed")
        lines = [
            f"{self.fit.name}: {name}, {len(self.runs.points)} points, {len(ended)} runs: "
            f"{ended.count('passed')} gave what was observed, {blocked} did not, {failed} failed",
            "",
            f"{'parameter':28} {'mean':>10} {'68 % interval':>23} {'width':>7}",
        ]
        lines += [_line(self, k) for k in range(len(self.fit.priors))]
        lines += ["", "width: of the posterior over that of the prior; identifiable up to "
                  f"{NARROWER:g}"]  # fmt: skip
        if len(self.fit.priors) > 1:
            lines += [
                "",
                *_correlated(self),
                "what the observation determines, the best known first:",
            ]
            lines += [f"  {_combination(self, direction)}" for direction in self.directions]
        return "\n".join([*lines, "", *_fits(self), *(f"warning: {w}" for w in self.warnings)])

    def figure(self) -> "Figure":
        """Posterior of each parameter and of each pair."""
        from calibration.inverse.figures import draw_posterior

        return draw_posterior(self)


def _names(found: Fitted) -> list[str]:
    return [prior.name for prior in found.fit.priors]


def _parameter(found: Fitted, k: int) -> dict[str, Any]:
    prior = found.fit.priors[k]
    return {
        "name": prior.name,
        "unit": prior.unit,
        "prior": {"distribution": prior.kind, "min": prior.ends[0], "max": prior.ends[1]},
        "mean": float(found.mean[k]),
        "sd": float(found.sd[k]),
        "median": float(found.median[k]),
        "interval_68": found.interval[:, k].tolist(),
        "width_over_prior": float(found.widths[k]),
        "identifiable": bool(found.widths[k] <= NARROWER),
    }


def _observations(found: Fitted) -> list[dict[str, Any]]:
    """Each with how far off its worst value is, in standard deviations."""
    rows, start = [], 0
    for _, one in found.fit.observations:
        row: dict[str, Any] = {"kind": one.kind, "file": one.file and str(one.file),
                               "values": len(one.values), "trials": one.trials}  # fmt: skip
        if len(one.values) and found.goodness is not None:
            off = found.goodness.off[start : start + len(one.values)]
            row["furthest_off_sd"] = float(off[abs(off).argmax()])
            start += len(one.values)
        rows.append(row)
    return rows


def _line(found: Fitted, k: int) -> str:
    prior = found.fit.priors[k]
    low, high = (_shown(float(v), prior.unit) for v in found.interval[:, k])
    verdict = "identifiable" if found.widths[k] <= NARROWER else "NOT identifiable"
    return (
        f"{prior.name:28} {_shown(float(found.mean[k]), prior.unit):>10} {low:>10} to {high:>9} "
        f"{found.widths[k]:7.2f}  {verdict}"
    )


def _shown(value: float, unit: str) -> str:
    return f"{value:.4g}" if unit == "1" else from_si(float(f"{value:.4g}"), unit)


def _correlated(found: Fitted) -> list[str]:
    names = _names(found)
    pairs = [(j, i) for i in range(len(names)) for j in range(i)]
    lines = [
        f"correlation of {names[j]} and {names[i]}: {found.correlations[i, j]:+.2f}"
        for j, i in pairs
    ]
    return [*lines, ""]


def _combination(found: Fitted, direction: Direction) -> str:
    parts = " ".join(
        f"{part:+.2f} {name}" for part, name in zip(direction.along, _names(found), strict=True)
    )
    verdict = "identifiable" if direction.identifiable else "NOT identifiable"
    return f"{parts} (in widths of the priors): width {direction.width:.2f}, {verdict}"


def _fits(found: Fitted) -> list[str]:
    good = found.goodness
    if good is None:
        return ["only outcomes were observed: nothing says whether the simulator fits"]
    rest = "" if good.p_rest is None else f"; of what no parameter changes p = {good.p_rest:.2g}"
    lines = [f"best fit: chi2 = {good.chi2:.2f} of {good.freedom:.1f} degrees of freedom, "
             f"p = {good.p:.2g}{rest}"]  # fmt: skip
    if good.reproducible:
        return [*lines, "the simulator can reproduce the observation"]
    worst = max(
        (row for row in zip(found.fit.observations, _observations(found), strict=True)
         if "furthest_off_sd" in row[1]),
        key=lambda row: abs(row[1]["furthest_off_sd"]),
    )  # fmt: skip
    return [
        *lines,
        "the simulator CANNOT reproduce the observation with these parameters: the intervals "
        f"mean nothing; furthest off is the {worst[0][1].label}, by "
        f"{worst[1]['furthest_off_sd']:+.1f} standard deviations",
    ]
