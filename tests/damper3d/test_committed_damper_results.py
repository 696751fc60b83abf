"""The damper's results that are shown: whole, of one piece, and a sample computed again."""

from pathlib import Path

import numpy as np
import pytest
from compare_results import body, checks, claims, numbers
from scipy.stats import t

from damper3d.case.case import DamperCase
from damper3d.reproduce import TABLES, find, panels
from damper3d.run.protocol import run
from granulab.campaign.output.results import read_results

RESULTS = Path(__file__).parents[2] / "docs" / "results" / "damper3d"
KEPT = sorted(path.stem.removeprefix("reproduce-") for path in RESULTS.glob("reproduce-*.csv"))


def committed(table):
    return read_results(RESULTS / f"reproduce-{table}.csv")


def test_every_table_has_its_results():
    assert sorted(TABLES) == KEPT


@pytest.mark.parametrize("table", KEPT)
def test_committed_results_are_whole_and_say_what_the_rows_say(table):
    """The report is made again from the rows: the same verdict on each claim, the same numbers."""
    head, rows = committed(table)
    assert head["command"].startswith(f"damper3d reproduce {table} --seeds ")
    text = (RESULTS / f"reproduce-{table}.txt").read_text(encoding="utf-8")
    again = find(table).report(rows)
    assert claims(again) == claims(text)
    assert checks(again) == checks(text)
    assert numbers(again) == numbers(text)
    words = "\n".join(body(text))
    assert "complete: " in words
    assert "INCOMPLETE: " not in words
    assert all(row["state"] == "done" for row in rows)


@pytest.mark.parametrize("gamma", [3.0, pytest.param(10.0, marks=pytest.mark.validation)])
def test_a_point_of_shares_computed_again_is_one_of_its_committed_kind(tmp_path, gamma):
    """Of 6 mm spheres, the fewest, at 160 Hz, seed 1: efficiency and shares of all mechanisms.

    The bits are the same only on the same type of processor with the same versions; elsewhere a
    last digit makes it another draw of the same kind. One more value lies within
    t s sqrt(1 + 1/n) of the mean of n packings, with the scatter s of a number over its mean pooled
    over the fluidised Gammas; t for 99.9 %, as seven numbers are looked at.
    """
    known = {
        one: [
            row
            for row in committed("shares")[1]
            if (row["diameter_mm"], row["frequency_hz"], row["gamma"]) == (6, 160.0, one)
        ]
        for one in (3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0)
    }
    motion = {"motion.frequency": 160.0, "motion.gamma": gamma, "output.keep": "summary"}
    spheres = {"particles.shape": "sphere:6mm", "particles.count": panels.SPHERES[6]}
    found = run(DamperCase.load("thesis", motion | spheres), out=tmp_path)
    numbers = {"efficiency": found.efficiency_with_settling} | {
        f"shares.{contacts}.{mechanism}": share
        for contacts, shares in found.shares.items()
        for mechanism, share in shares.items()
    }
    assert len(numbers) == 7
    for name, value in numbers.items():
        values = {one: np.array([row[name] for row in rows]) for one, rows in known.items()}
        off = np.concatenate([each / each.mean() - 1 for each in values.values()])
        freedom = len(off) - len(values)
        scatter = np.sqrt((off**2).sum() / freedom)
        mean, n = values[gamma].mean(), len(values[gamma])
        allowed = t.ppf(0.9995, freedom) * scatter * (1 + 1 / n) ** 0.5
        assert abs(value / mean - 1) <= allowed, (name, value, mean, scatter)
