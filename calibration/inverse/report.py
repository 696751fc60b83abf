"""What a fit found, as JSON and in words."""

from typing import Any

from calibration.inverse.fitted import Fitted
from calibration.inverse.statistics.identify import NARROWER, Direction
from granulab.contact.files.units import from_si


def as_json(found: Fitted) -> dict[str, Any]:
    """The answer of calibrate inverse; values in the SI unit that stands beside them."""
    fit, good = found.fit, found.goodness
    ended = [run.ended for run in found.runs.runs]
    return {
        "simulator": fit.simulated.campaign.name,
        "cases": [name for name, _ in fit.cases],
        "parameters": [_parameter(found, k) for k in range(len(fit.priors))],
        "correlations": found.correlations.tolist(),
        "directions": [
            {
                "along": dict(zip(_names(found), d.along.tolist(), strict=True)),
                "information": d.information,
                "width_over_prior": d.width,
                "identifiable": d.identifiable,
            }
            for d in found.directions
        ],
        "goodness": None if good is None else {
            "chi2": good.chi2,
            "freedom": good.freedom,
            "p": good.p,
            "p_rest": good.p_rest,
            "reproducible": good.reproducible,
        },
        "observations": _observations(found),
        "points": len(found.runs.points),
        "runs": {
            "total": len(ended),
            **{word: ended.count(word) for word in ("passed", "blocked", "failed")},
        },
        "samples": {
            "effective": found.posterior.effective,
            "autocorrelation_steps": found.posterior.memory,
        },
        "warnings": found.warnings,
        "folder": str(found.folder.path),
        "table": str(found.folder.path / "table.csv"),
    }  # fmt: skip


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


def as_text(found: Fitted) -> str:
    """The same for a person."""
    name = found.fit.simulated.campaign.name
    ended = [run.ended for run in found.runs.runs]
    blocked, failed = ended.count("blocked"), ended.count("failed")
    lines = [
        f"{found.fit.name}: {name}, {len(found.runs.points)} points, {len(ended)} runs: "
        f"{ended.count('passed')} gave what was observed, {blocked} did not, {failed} failed",
        "",
        f"{'parameter':28} {'mean':>10} {'68 % interval':>23} {'width':>7}",
    ]
    lines += [_line(found, k) for k in range(len(found.fit.priors))]
    lines += ["", "width: of the posterior over that of the prior; identifiable up to "
              f"{NARROWER:g}"]  # fmt: skip
    if len(found.fit.priors) > 1:
        lines += ["", *_correlated(found), "what the observation tells, the best known first:"]
        lines += [f"  {_combination(found, direction)}" for direction in found.directions]
    return "\n".join([*lines, "", *_fits(found), *(f"warning: {w}" for w in found.warnings)])


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
