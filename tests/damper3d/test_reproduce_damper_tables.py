"""Tables from the command line, runs of few spheres: shares, sensitivity, cycles, experiments."""

from functools import partial
from types import SimpleNamespace
from typing import Any

import pytest
from small_damper import CASE, damper3d

from damper3d.commands.main import app
from damper3d.reproduce import TABLES, cycles, experiments, find, sensitivity, shares
from damper3d.reproduce.panels import point_cases
from damper3d.reproduce.quantities import properties
from damper3d.reproduce.quantities.optima import Table63, exponent_of_frequency
from damper3d.run.sweep import DAMPER
from granulab.campaign.cli.reproduce import PublishedTable
from granulab.campaign.output.layout import on_screen
from granulab.campaign.output.results import read_results
from granulab.campaign.sweeps.overview import cost

# The motion is the table's own.
_SMALL = {key: value for key, value in CASE.items() if not key.startswith(("motion.", "run.c"))}
_SMALL |= {"run.cycles": 5, "run.discard": 1, "output.samples": 40}


def _few_points(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two or three points of each table, fast ones."""
    monkeypatch.setattr(shares, "SIZES", (5,))
    monkeypatch.setitem(shares.SPHERES, 5, 20)
    monkeypatch.setattr(shares, "FREQUENCIES", (160.0,))
    monkeypatch.setattr(shares, "GAMMAS", (5.0, 20.0))
    monkeypatch.setattr(properties, "GAMMAS", (20.0,))
    for name in properties.VALUES:
        one = (0.3,) if name == "friction" else ()
        monkeypatch.setitem(properties.VALUES, name, one)
    some = [{"orientation": o, "gamma": 20.0} for o in ("vertical", "horizontal")]
    monkeypatch.setattr(cycles, "points", lambda: some)
    both = [{"surface": s, "frequency_hz": 80.0, "gamma": 20.0} for s in ("smooth", "printed")]
    monkeypatch.setattr(experiments, "points", lambda: both)
    motion: dict[str, Any] = {"motion.frequency": 80.0}
    for table, changes in (
        (shares, {}), (sensitivity, motion), (cycles, motion), (experiments, motion),
    ):  # fmt: skip
        few = partial(point_cases, table.points, table._settings, changes=_SMALL | changes)
        monkeypatch.setattr(table, "cases", few)


@pytest.mark.usefixtures("in_this_process")
@pytest.mark.parametrize(
    ("name", "runs"), [("shares", 2), ("sensitivity", 2), ("cycles", 2), ("experiments", 2)]
)
def test_a_table_runs_once_and_its_rows_are_reported_again(tmp_path, monkeypatch, name, runs):
    """What is committed is enough for the text: the same from the CSV as from the runs."""
    _few_points(monkeypatch)
    command = ["reproduce", name, "--seeds", 1, "--workers", 1, "--out", tmp_path]
    first = damper3d(*command)
    assert first.code == 0, first.err
    standing = f"INCOMPLETE: {runs} of {runs} points are there, with 1 of 3 packings each"
    assert first.out.startswith(standing)
    again = damper3d(*command, "--write", tmp_path / "again")
    assert again.out == first.out
    assert f"{runs} runs," not in again.err.splitlines()[-1]
    origin, rows = read_results(tmp_path / "again" / f"reproduce-{name}.csv")
    assert origin["command"] == f"damper3d reproduce {name} --seeds 1"
    assert on_screen(find(name).report(rows)).strip() == first.out.strip()
    assert (tmp_path / f"reproduce-{name}.png").stat().st_size > 10_000


@pytest.mark.parametrize("name", ["shares", "sensitivity", "cycles", "experiments"])
def test_the_tables_are_in_the_registry(name):
    table: PublishedTable = find(name)
    assert table.SEEDS == 3
    assert callable(table.run)
    assert callable(table.draw)
    assert name in TABLES
    assert "reproduce" in app.commands


def test_a_table_that_is_whole_costs_nothing():
    """As `--add` of a table finds it that lacks no run."""
    assert cost(DAMPER, []).startswith("0 runs")


def test_exponents_that_share_an_optimum_are_one_line_of_the_scatter():
    """Of dampers with 1.8, 1.9 and 2.0 from 20 to 80 Hz, whatever those at 40 Hz: t = -sqrt(3)."""
    exponents = dict(zip((40, 45, 50), (1.8, 1.9, 2.0), strict=True))
    optima = {
        (height, f, "vertical"): SimpleNamespace(
            gamma=(f / 20.0) ** exponent * (1.3 if f == 40 else 1.0), error=lambda _: 0.1
        )
        for height, exponent in exponents.items()
        for f in (20.0, 40.0, 80.0)
    }
    found = exponent_of_frequency(Table63(optima, None))
    assert len(found) == 6
    assert {one["together"] for one in found} == {
        "; mean 1.90, away from 2 by t = -1.7 of the lines' scatter (p = 0.2)"
    }
