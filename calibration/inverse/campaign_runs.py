"""The runs of a fit on a campaign's engine: each in its folder, read again where it is there."""

from pathlib import Path
from typing import Any

import numpy as np

from calibration.inverse.fit_file import Fit
from calibration.inverse.observation import Row
from calibration.inverse.statistics.data import Run
from calibration.inverse.statistics.prior import Array
from granulab.campaign.sweeps.sweep import Labelled, over_seeds, run_labelled
from granulab.errors import InputError


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
        if any(row["state"] == "interrupted" for row in rows):
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
