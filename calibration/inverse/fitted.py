"""From a fit file to its posterior: the runs, in rounds, and what they tell; kept in a folder."""

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from calibration.inverse.campaign_runs import CampaignRuns, Cut
from calibration.inverse.fit_file import Fit
from calibration.inverse.statistics.data import Runs
from calibration.inverse.statistics.design import explore
from calibration.inverse.statistics.identify import (
    Direction,
    Goodness,
    at_the_edge,
    correlations,
    directions,
    goodness,
    widths,
)
from calibration.inverse.statistics.posterior import NothingPassed, Posterior, infer
from calibration.inverse.statistics.prior import Array
from granulab.campaign.cli.commandline import Ended
from granulab.campaign.output.table import write_table
from granulab.campaign.runs.folder import RunFolder, write_atomic, writing
from granulab.campaign.runs.provenance import provenance

_INTERVAL = 0.158655, 0.841345  # 68.3 %: one standard deviation of a normal distribution


@dataclass(frozen=True)
class Fitted:
    """A fit that was made.

    mean, sd, median    (p,) of the posterior, in SI
    interval            (2, p) that holds 68.3 % of it, as much being below as above
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


def run_fit(fit: Fit, *, out: Path, **engine: Any) -> Fitted:
    """Run a fit in out/inverse/<name>-<digest>; its runs are in `out`, where others find them.

    engine: as of sweeps.sweep.run_labelled. Raises Ended, with the table of the runs kept, where
    they were interrupted or none gave what was observed.
    """
    folder = RunFolder(out / "inverse" / f"{fit.name}-{fit.digest}")
    with writing(folder.path):
        folder.path.mkdir(parents=True, exist_ok=True)
    write_atomic(folder.path / "fit.toml", fit.text)
    campaign = fit.simulated.campaign
    folder.write_provenance(
        provenance(
            command=sys.argv, seed=fit.draw_seed, packages=[*campaign.packages, "scipy",
            "scikit-learn", "emcee"], sources=campaign.sources.folders,
        )
    )  # fmt: skip
    evaluate = CampaignRuns(fit, out, **engine)
    observed = fit.observed()
    try:
        runs = explore(fit.priors, observed, evaluate, fit.points, fit.draw_seed)
        posterior = infer(fit.priors, observed, runs, fit.draw_seed)
    except Cut:
        raise Ended("stopped; the same command goes on from there", 130) from None
    except NothingPassed:
        raise Ended(_none_passed(evaluate, folder), 3) from None
    finally:
        write_table(folder.path, evaluate.rows)
    return judged(fit, folder, runs, posterior)


def judged(fit: Fit, folder: RunFolder, runs: Runs, posterior: Posterior) -> Fitted:
    """A posterior with all that is said of it."""
    values = posterior.values()
    return Fitted(
        fit, folder, runs, posterior, values.mean(axis=0), values.std(axis=0),
        np.median(values, axis=0), np.quantile(values, _INTERVAL, axis=0), widths(posterior),
        correlations(posterior), directions(posterior), goodness(posterior),
        _warnings(fit, runs, posterior),
    )  # fmt: skip


def _warnings(fit: Fit, runs: Runs, posterior: Posterior) -> list[str]:
    said = [
        f"{fit.priors[k].name} runs against the {end} end of its prior: the interval is the "
        "prior's; widen it where the parameter may lie beyond"
        for k, end in at_the_edge(posterior)
    ]
    failed = [run for run in runs.runs if run.ended == "failed"]
    if failed:
        said.append(f"{len(failed)} of {len(runs.runs)} runs failed; the first: {failed[0].reason}")
    return said


def _none_passed(evaluate: CampaignRuns, folder: RunFolder) -> str:
    failed = sum(row["state"] == "failed" for row in evaluate.rows)
    return (
        f"of {len(evaluate.rows)} runs {failed} failed, and no two of a point gave what was "
        f"observed; change the priors or the case; see {folder.path / 'table.csv'}"
    )
