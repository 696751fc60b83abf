"""The efficiency map on made runs: its points, refinement, ridges, table, words, picture."""

import csv
import json
import math

import h5py
import numpy as np
import pytest
from made_map import made_row, made_runs

from damper3d.case.case import DamperCase
from damper3d.studies.map import grid as mapping
from damper3d.studies.map.chart import draw_map, gridded
from damper3d.studies.map.grid import (
    FREQUENCIES,
    GAMMAS,
    Grid,
    MapResult,
    efficiency_map,
    map_so_far,
)
from damper3d.studies.map.report import as_text, points, summary, write_map
from damper3d.studies.map.ridges import ridges
from damper3d.studies.predict.prediction import predict
from granulab.campaign.output.figure import write_figure
from granulab.campaign.runs.folder import RunFolder
from granulab.errors import InputError

SMALL = Grid((20, 40, 160), GAMMAS, packings=3)


@pytest.fixture
def requested(monkeypatch):
    """Made runs in place of computed ones; the labels of each call."""
    calls = []

    def run_cases(cases, **options):
        calls.append([labels for labels, _ in cases])
        return made_runs(cases, **options)

    monkeypatch.setattr(mapping, "run_cases", run_cases)
    return calls


def made_map(tmp_path, grid=SMALL, changes=None):
    return efficiency_map("thesis", changes or {}, grid, out=tmp_path)


def test_default_grid_is_that_of_the_thesis():
    """Table 6.1: nine frequencies, nineteen amplitudes."""
    grid = Grid()
    assert len(grid.points) == len(FREQUENCIES) * len(GAMMAS) == 171
    assert (grid.packings, grid.refine) == (1, 0)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"frequencies": ()}, "frequencies: empty"),
        ({"gammas": ()}, "gammas: empty"),
        ({"gammas": (1.0, 0.0)}, "gammas: 0: must be above 0"),
        ({"frequencies": (-5.0,)}, "frequencies: -5"),
        ({"gammas": (math.nan,)}, "gammas: nan"),
        ({"frequencies": (math.inf,)}, "frequencies: inf"),
        ({"packings": 0}, "packings = 0"),
        ({"refine": -1}, "refine = -1"),
    ],
)
def test_grid_refuses_what_is_empty_or_not_above_zero_in_one_line(given, words):
    with pytest.raises(InputError, match=words) as error:
        Grid(**given)
    assert "\n" not in str(error.value)


def test_runs_are_the_case_at_each_point_and_keep_only_their_results(monkeypatch, tmp_path):
    seen = []

    def run_cases(cases, **options):
        seen.extend(case for _, case in cases)
        return made_runs(cases, **options)

    monkeypatch.setattr(mapping, "run_cases", run_cases)
    grid = Grid((40.0, 20.0, 40.0), (3.0, 1.0), packings=2, seed=5)
    made_map(tmp_path, grid, {"motion.orientation": "horizontal"})
    requested = [(c.settings.motion.frequency, c.settings.motion.gamma, c.settings.run.seed)
             for c in seen]  # fmt: skip
    assert requested == [(f, g, s) for f in (20.0, 40.0) for g in (1.0, 3.0) for s in (5, 6)]
    assert {c.settings.output.keep for c in seen} == {"summary"}
    assert {c.settings.motion.orientation for c in seen} == {"horizontal"}
    assert {c.period for c in seen} == {1 / 20, 1 / 40}


def test_scatter_over_packings_is_the_half_width_of_three_and_the_cycles_that_of_one():
    """Three values: t(0.975, 2) = 4.3027 times sd/sqrt(3). One: half its interval over cycles."""
    labels = {"frequency_hz": 40.0, "gamma": 10.0}
    three = [made_row({**labels, "seed": k}, efficiency=e) for k, e in enumerate((0.2, 0.3, 0.4))]
    result = MapResult.of(three)
    assert result.efficiency == pytest.approx([0.3])
    assert result.half_width == pytest.approx([4.30265 * 0.1 / math.sqrt(3)], rel=1e-5)
    one = MapResult.of([made_row({**labels, "seed": 1}, efficiency_interval=[0.1, 0.4])])
    assert one.half_width == pytest.approx([0.15])
    none = MapResult.of([made_row({**labels, "seed": 1}, efficiency_interval=None)])
    assert np.isnan(none.half_width).all()


def test_point_whose_runs_failed_is_missing_and_the_rest_is_mapped(requested, tmp_path):
    result = made_map(tmp_path)
    bad = [{**row, "state": "failed", "reason": "NaN"} if row["gamma"] == 5.0 else row
           for row in result.rows]  # fmt: skip
    result = MapResult.of(bad)
    assert np.isnan(result.efficiency[result.gamma == 5.0]).all()
    assert len(result.at(40.0)) == len(GAMMAS) - 1
    results = summary(SMALL, result, predict(DamperCase.load("thesis")), [], tmp_path)
    assert results["failed"] == 9
    assert results["failures"] == ["9 runs from 20 Hz, Gamma 5, seed 1 on: NaN"]
    assert "failed: 9 runs" in as_text(results)


def test_a_map_is_a_frame_with_a_row_a_point(requested, tmp_path):
    found = made_map(tmp_path)
    frame = found.frame()
    assert len(frame) == len(SMALL.points)
    assert list(frame["efficiency"]) == list(found.efficiency)
    assert set(frame["packings"]) == {3}


def test_unknown_column_is_refused_with_those_there_are(requested, tmp_path):
    result = made_map(tmp_path)
    assert result.mean("law_term") == pytest.approx(0.01 * result.gamma)
    with pytest.raises(InputError, match=r"column 'law_terms'.*did you mean 'law_term'"):
        result.mean("law_terms")


def test_refinement_computes_around_the_peaks_only_and_again_the_same(requested, tmp_path):
    refined = Grid(SMALL.frequencies, SMALL.gammas, packings=3, refine=3)
    first = made_map(tmp_path, refined)
    calls = [list(call) for call in requested]
    assert len(calls) == 4
    # The 160 Hz of this map has one peak (Gamma 3); 20 and 40 Hz have two: 2 points each.
    assert [len(call) for call in calls[1:]] == [30, 30, 30]
    requested.clear()
    assert made_map(tmp_path, refined).rows == first.rows
    assert requested == calls


def test_refined_peaks_are_where_they_were_planted(requested, tmp_path):
    """Gamma 3 on the fluidised ridge and eq. 6.11 on the other lie in their brackets, which three
    halvings leave as wide as noise allows; the made noise is 1 % of the peaks."""
    result = made_map(tmp_path, Grid(SMALL.frequencies, GAMMAS, packings=3, refine=3))
    case = predict(DamperCase.load("thesis"))
    found = {(item.ridge, item.frequency): item.peak for item in ridges(result, case)}
    assert set(found) == {("fluidisation", 20.0), ("fluidisation", 40.0), ("fluidisation", 160.0),
                          ("bouncing_bed", 20.0), ("bouncing_bed", 40.0)}  # fmt: skip
    for (ridge, frequency), peak in found.items():
        planted = 3.0 if ridge == "fluidisation" else case.clearances[1].onset(frequency)
        assert peak.bracket[0] < planted < peak.bracket[1]
        assert peak.gamma == pytest.approx(planted, rel=0.05)


def test_refinement_stops_where_runs_were_interrupted(monkeypatch, tmp_path):
    def interrupted(cases, **_):
        return [{**labels, "state": "interrupted", "reason": ""} for labels, _ in cases]

    monkeypatch.setattr(mapping, "run_cases", interrupted)
    result = map_so_far("thesis", {}, Grid((40.0,), GAMMAS, refine=2), out=tmp_path)
    assert len(result.rows) == len(GAMMAS)
    assert result.columns == ["frequency_hz", "gamma", "seed"]
    with pytest.raises(KeyboardInterrupt, match="19 of 19 runs are not finished"):
        made_map(tmp_path, Grid((40.0,), GAMMAS, refine=2))


def test_commonest_phase_stands_for_a_point():
    labels = {"frequency_hz": 40.0, "gamma": 10.0}
    phases = ["bouncing_bed", "transition", "transition"]
    rows = [made_row({**labels, "seed": k}, phase=phase) for k, phase in enumerate(phases)]
    rows.append(made_row({**labels, "gamma": 12.0, "seed": 0}))
    assert MapResult.of(rows).phases == ["transition", None]


def test_contours_go_through_the_points_and_are_linear_in_ln_gamma_between(requested, tmp_path):
    result = made_map(tmp_path, Grid((20, 40), (1, 4, 16)))
    frequency, gamma, eta = gridded(result)
    assert frequency.tolist() == [20, 40]
    chosen = result.at(40)
    wanted = np.interp(np.log(2.0), np.log(result.gamma[chosen]), result.efficiency[chosen])
    found = np.interp(np.log(2.0), np.log(gamma), eta[:, 1])
    assert found == pytest.approx(wanted, abs=1e-3)  # 400 points over the range
    assert np.isfinite(eta).all()


def test_table_and_summary_hold_every_point_and_are_read_back(requested, tmp_path):
    result = made_map(tmp_path)
    prediction = predict(DamperCase.load("thesis"))
    folder = RunFolder(tmp_path / "map")
    results = summary(SMALL, result, prediction, ridges(result, prediction), folder.path)
    write_map(folder, result, results)
    with (folder.path / "table.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["efficiency"]) for row in rows] == result.efficiency.tolist()
    with h5py.File(folder.path / "runs" / "table.h5") as file:
        assert len(file["efficiency"]) == len(result.rows) == 171
    assert folder.read_summary()["best"]["frequency_hz"] in (20.0, 40.0)
    assert json.loads(json.dumps(results)) == results
    text = as_text(results)
    assert "20 Hz  bouncing bed" in text
    assert "close 22.3" in text
    assert len(points(result)) == 57


@pytest.mark.parametrize("walls", [False, True])
@pytest.mark.parametrize("grid", [SMALL, Grid((40,), (1, 3, 10)), Grid((40, 80), (3,))])
def test_picture_is_made_of_any_grid(requested, tmp_path, grid, walls):
    """With the work of the walls beside what is dissipated, where runs have it."""
    result = made_map(tmp_path, grid)
    if walls:
        of_walls = [row | {"efficiency_wall_work": row["efficiency"] / 2} for row in result.rows]
        result = MapResult.of(of_walls)
    prediction = predict(DamperCase.load("thesis"))
    found = ridges(result, prediction)
    figure = draw_map(result, prediction, found)
    panels = [axes for axes in figure.axes if axes.get_xlabel()]
    curves = [one.get_label() for axes in panels for one in axes.containers]
    whole = min(len(grid.frequencies), len(grid.gammas)) > 1
    assert len(panels) == (2 if walls and whole else 1)
    assert ("work of the walls" in curves) == (walls and not whole)
    picture = write_figure(tmp_path / "map.png", lambda: figure)
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("grid", "lacking", "title"),
    [
        (Grid((20, 80), (1, 3, 10)), ("frequency_hz", 20), "80 Hz"),
        (Grid((20, 40, 80), (1, 3)), ("gamma", 1), "Γ = 3"),
    ],
)
def test_curves_are_named_by_the_points_that_have_an_efficiency(
    requested, tmp_path, grid, lacking, title
):
    """And the onsets are those at their frequency."""
    column, value = lacking
    rows = [
        row | ({"efficiency": None} if row[column] == value else {})
        for row in made_map(tmp_path, grid).rows
    ]
    prediction = predict(DamperCase.load("thesis"))
    axes = draw_map(MapResult.of(rows), prediction, []).axes[0]
    assert axes.get_title(loc="left") == title
    if column == "frequency_hz":
        onsets = [one.onset(80.0) for one in prediction.clearances]
        drawn = [line.get_xdata()[0] for line in axes.lines if len(set(line.get_xdata())) == 1]
        assert drawn == [pytest.approx(onset) for onset in onsets if onset is not None]


def test_where_most_beds_settle_the_map_is_that_of_the_walls(requested, tmp_path):
    """Runs whose bed settles have no efficiency; the work of their walls is a map all the same."""
    result = made_map(tmp_path, Grid((20, 40, 80), (1, 3, 10)))
    rows = [
        row | {"efficiency_wall_work": row["efficiency"], "efficiency": None}
        if (row["frequency_hz"], row["gamma"]) != (80, 3)
        else row | {"efficiency_wall_work": row["efficiency"]}
        for row in result.rows
    ]
    figure = draw_map(MapResult.of(rows), predict(DamperCase.load("thesis")), [])
    titles = [axes.get_title(loc="left") for axes in figure.axes if axes.get_xlabel()]
    assert titles == ["work of the walls"]
