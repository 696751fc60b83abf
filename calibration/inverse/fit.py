"""A fit from its file to its posterior: the runs on the campaign's engine, in rounds.

Every run has its folder, where it is read again if it is there.
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np

from calibration.inverse.fit_file import Fit
from calibration.inverse.observation import Row
from calibration.inverse.result import Fitted
from calibration.inverse.statistics.data import Run, Runs
from calibration.inverse.statistics.design import explore
from calibration.inverse.statistics.identify import (
    at_the_edge,
    correlations,
    directions,
    goodness,
    widths,
)
from calibration.inverse.statistics.posterior import NothingPassed, Posterior, infer
from calibration.inverse.statistics.prior import Array
from granulab.campaign.cli.commandline import Ended
from granulab.campaign.output.files import write_atomic, writing
from granulab.campaign.output.layout import stopped
from granulab.campaign.output.table import write_table
from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.provenance import provenance
from granulab.campaign.sweeps.sweep import Labelled, over_seeds, run_labelled
from granulab.errors import InputError

_INTERVAL = 0.158655, 0.841345  # 68.3 %: one standard deviation of a normal distribution


class Cut(Exception):
    """The runs were interrupted; the same command goes on."""


class CampaignRuns:
    """Evaluates points; `rows` has a row for each run (see sweeps.sweep.run_labelled).

    A point has seeds of its own: with the same ones everywhere, their common chance would look
    like something that the parameters do.
    """

    def __init__(self, fit: Fit, out: Path, **engine: Any) -> None:
        self.rows: list[Row] = []
        self._fit, self._out, self._engine = fit, out, engine
        self._points = 0

    def __call__(self, points: Array) -> list[Run]:
        """The runs of points (n, p) of coordinates; raises Cut after Ctrl-C."""
        known: list[Labelled] = []
        refused: list[Row] = []
        for k, x in enumerate(points):
            for number in range(len(self._fit.cases)):
                labels = self._labels(self._points + k, number, x)
                seeds = [1 + (self._points + k) * self._fit.seeds + s
                         for s in range(self._fit.seeds)]  # fmt: skip
                try:
                    known += over_seeds(labels, self._fit.case(number, x), seeds)
                except InputError as error:  # such as a time step that is not stable there
                    refused += [
                        {**labels, "seed": seed, "state": "failed", "reason": str(error)}
                        for seed in seeds
                    ]
        rows = run_labelled(self._fit.simulated.campaign, known, out=self._out, **self._engine)
        rows = sorted(rows + refused, key=lambda r: (r["point"], r["case"], r["seed"]))
        self.rows += rows
        if stopped(rows):
            raise Cut
        first, self._points = self._points, self._points + len(points)
        return self._runs(rows, first)

    def _labels(self, point: int, number: int, x: Array) -> Row:
        keys = self._fit.simulated.keys
        values = {
            keys.column(key): float(prior.value(float(coordinate)))
            for prior, coordinate in zip(self._fit.priors, x, strict=True)
            for key in prior.keys
        }
        return {"point": point, "case": number, **values}

    def _runs(self, rows: list[Row], first: int) -> list[Run]:
        """A run of the fit for each point and seed: of all cases together."""
        together: dict[tuple[int, int], list[Row]] = {}
        for row in rows:
            together.setdefault((row["point"] - first, row["seed"]), []).append(row)
        return [self._run(point, cases) for (point, _), cases in sorted(together.items())]

    def _run(self, point: int, rows: list[Row]) -> Run:
        failed = next((row for row in rows if row["state"] == "failed"), None)
        if failed is not None:
            return Run(point, "failed", reason=failed["reason"])
        if not all(self._fit.simulated.passed(row) for row in rows):
            return Run(point, "blocked")
        by_case = {row["case"]: row for row in rows}
        kinds = self._fit.simulated.kinds
        values = [
            kinds[one.kind].of(one, by_case[number]) for number, one in self._fit.observations
        ]
        return Run(point, "passed", np.concatenate(values))


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
        folder.seal("fit.toml", *write_table(folder.path, evaluate.rows))
    return fitted(fit, folder, runs, posterior)


def fitted(fit: Fit, folder: RunFolder, runs: Runs, posterior: Posterior) -> Fitted:
    """A posterior with all that is reported of it."""
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
