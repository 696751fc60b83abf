"""Counts of the efficiency in the tables of maps: walls' work, steady beds, steep points."""

import math

import pytest
from made_tables import made_table
from refusals import assert_refused
from small_damper import damper3d

from damper3d.reproduce import chapter, panels
from damper3d.reproduce import map as maps
from damper3d.reproduce.panels import counts
from damper3d.run import sweep
from damper3d.studies.map.grid import STEEP, MapResult
from granulab.campaign.claims.claim import claims_of
from granulab.campaign.output.results import read_results, write_results
from granulab.campaign.sweeps.sweep import beside_known

OPTIONS = {"workers": 1, "quiet": True}
GAMMAS = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 20.0)
LABELS = ["orientation", "height_mm", "diameter_mm", "frequency_hz", "gamma"]
JUDGED = (125.0, 160.0, 200.0, 320.0, 625.0, 1024.0)  # frequencies of the claims on counts


def grid_of(frequencies):
    """Two heights in both orientations."""
    return [
        panels.panel(o, h, 5, [(f, g) for f in frequencies for g in GAMMAS])
        for o in panels.ORIENTATIONS
        for h in (40, 55)
    ]


GRID = grid_of((80.0, 125.0, 320.0, 625.0))


def share(labels):
    """Of the walls in what is dissipated: less at low Gamma and at high frequency."""
    return 1 / (1 + labels["frequency_hz"] / 625 / labels["gamma"])


@pytest.fixture
def made(monkeypatch):
    """Rows of a table from made runs; the cases that were run are counted."""

    def rows(table=maps, *, known=(), grid=GRID, steady=True, seeds=(1,), **how):
        asked = []

        def run_cases(cases, *, known, **options):
            def make(lacking):
                chosen = [cases[k] for k in lacking]
                asked.extend(chosen)
                return made_table(**{"walls": share} | how)(chosen, **options)

            return beside_known([labels for labels, _ in cases], known, make)

        monkeypatch.setattr(sweep, "run_cases", run_cases)
        found = table.run(out=None, seeds=seeds, grid=grid, steady=steady, known=known, **OPTIONS)
        return found, asked

    return rows


def test_steep_points_are_both_ends_of_a_large_step_along_gamma():
    """Of one frequency at a time; where all runs failed there is none."""
    etas = {20.0: {1.0: 0.1, 2.0: 0.09 + STEEP, 3.0: 0.1 + 2 * STEEP, 4.0: 0.1 + 2 * STEEP},
            40.0: {1.0: 0.9, 2.0: 0.8}}  # fmt: skip
    rows = [
        {"frequency_hz": f, "gamma": g, "efficiency": eta, "state": "done"}
        for f, own in etas.items()
        for g, eta in own.items()
    ]
    rows += [{"frequency_hz": 80.0, "gamma": g, "efficiency": None, "state": "failed"}
             for g in (1.0, 2.0)]  # fmt: skip
    assert MapResult.of(rows).steep() == [(20.0, 2.0), (20.0, 3.0)]


def test_steep_points_have_three_packings_and_the_table_is_whole(made):
    rows, _ = made(steady=False)
    steep = {
        (*key, *point)
        for one in GRID
        for key in [tuple(one.labels.values())]
        for point in MapResult.of([row for row in one.of(rows) if row["seed"] == 1]).steep()
    }
    seeds = {}
    for row in rows:
        seeds.setdefault(tuple(row[name] for name in LABELS), set()).add(row["seed"])
    assert 0 < len(steep) < len(seeds)
    assert all(own == ({1, 2, 3} if key in steep else {1}) for key, own in seeds.items())
    words = counts.packings_words(rows, LABELS)
    number = len(steep)
    assert words.startswith(f"packings behind a verdict: 1 a point, 3 at {number} of the {number}")
    alone = [row for row in rows if row["seed"] == 1]
    assert f", 3 at 0 of the {number} points" in counts.packings_words(alone, LABELS)
    assert {row["seed"] for row in panels.first_packings(rows, LABELS)} == {1}
    points = panels.labels_of(GRID)
    whole = panels.completeness(panels.first_packings(rows, LABELS), points, maps.SEEDS)
    assert whole == f"complete: {len(points)} points, 1 packing each"
    everywhere, _ = made(steady=False, seeds=(1, 2, 3))
    assert len(everywhere) == 3 * len(seeds)
    assert counts.packings_words(everywhere, LABELS) == "packings behind a verdict: 3 a point"


def test_steady_beds_stand_beside_the_gentle_points_of_the_first_packing(made):
    """From 80 Hz and up to Gamma 6; their runs are those with run.steady, all else alike."""
    rows, asked = made()
    with_it = [row for row in rows if row.get(counts.STEADY_ETA) is not None]
    assert len(with_it) == 4 * 4 * 7
    assert all(row["gamma"] <= 6 and row["seed"] == 1 for row in with_it)
    for row in with_it:
        assert row[counts.STEADY_ETA] == pytest.approx(row["efficiency_wall_work"])
    steady = [case.settings for _, case in asked if case.settings.run.steady]
    assert len(steady) == len(with_it)
    words = counts.steady_words(rows)
    assert words.startswith(f"steady: {len(with_it)} points")
    assert f"{len(with_it)} became so within 24 cycles; in 0 the bed still gives" in words
    with_it[0]["steady.efficiency"] *= 1.2
    assert "in 1 the bed still gives" in counts.steady_words(rows)
    assert counts.steady_words(made(steady=False)[0]) == ""


def test_rows_that_are_known_are_not_run_again(made, tmp_path):
    """From the CSV: neither the points, nor their further packings, nor their steady beds."""
    rows, _ = made()
    kept, *_ = write_results(
        tmp_path, "map", rows, ["command: x"], "", lambda: maps.draw(rows), maps.COLUMNS
    )
    known = read_results(kept)[1]
    again, asked = made(known=known)
    assert asked == []
    assert maps.report(again) == maps.report(known) == maps.report(rows)
    without = [
        {name: value for name, value in row.items() if not name.startswith("steady.")}
        for row in known
    ]
    _, asked = made(known=without)
    assert all(case.settings.run.steady for _, case in asked)


def test_no_steady_bed_is_begun_after_an_interruption(made, monkeypatch):
    """The same command goes on: first the points, then their steady beds."""
    rows, _ = made(steady=False)
    cut_off = [row | {"state": "interrupted"} if k % 2 else row for k, row in enumerate(rows)]
    monkeypatch.setattr(counts, "run_panels", lambda *_, **options: cut_off)
    found, asked = made()
    assert (found, asked) == (cut_off, [])


def test_verdicts_are_given_by_each_count_and_those_that_turn_are_shown(made):
    """Eta rises with frequency as it is dissipated, and falls by what the walls give of it."""
    rows, _ = made(tilt=0.2, walls=lambda labels: (80 / labels["frequency_hz"]) ** 0.5)
    found = counts.by_count(rows)
    assert list(found) == list(counts.COUNTS)
    text = counts.judged_by_count(claims_of("damper_map"), found)
    head, *lines = text.splitlines()
    assert head.startswith("claims that hold by each count: dissipated ")
    at = lines.index("  turns: the efficiency there rises with frequency")
    verdicts = [line.split()[0] for line in lines[at + 1 : at + 5]]
    assert verdicts == ["PASS", "FAIL", "PASS", "FAIL"]
    only = {"dissipated": found["dissipated"]}
    assert counts.judged_by_count(claims_of("damper_map"), only) == ""


def test_walls_are_no_count_of_a_table_where_a_run_lacks_their_work(made):
    """Else a part of its maps would be judged as if it were all."""
    rows, _ = made(steady=False)
    rows[5] = {key: value for key, value in rows[5].items() if key != counts.WALL_WORK}
    assert list(counts.by_count(rows)) == ["dissipated"]


@pytest.mark.parametrize(("turned", "expected"), [(1, ["PASS"] * 3), (-1, ["FAIL"] * 3)])
def test_overestimate_is_judged_where_the_thesis_says_it_is(made, turned, expected):
    """Sec. 8.5.2: above 1, more at low Gamma and at high frequency; made shares, their inverse."""
    rows, _ = made(walls=lambda labels: share(labels) ** turned, grid=grid_of(JUDGED))
    report = maps.report(rows)
    lines = report[report.index("what is dissipated over the other counts") :].splitlines()
    walls = [line for line in lines if line.startswith("  ") and "walls" in line]
    assert [line.split()[0] for line in walls] == expected
    (shown,) = [line for line in lines if "steady" in line and "times" in line]
    least, most = (1 / share({"frequency_hz": f, "gamma": g}) for f, g in ((125, 6), (1024, 1)))
    if turned > 0:
        assert f"{least:.2f} to {most:.2f} times, 84 of 84 points" in shown
    assert math.isclose(most, 1 + 1024 / 625)


def test_chapter_has_the_counts_too(made):
    rows, _ = made(chapter)
    text = chapter.report(rows)
    assert "spheres of 5 mm, claims that hold by each count: dissipated" in text
    assert "of walls" in text
    chapter.draw(rows)


def test_only_tables_of_maps_take_steady():
    assert_refused(
        damper3d("reproduce", "optimum", "--steady"), "--steady: optimum does not take it",
        "chapter or map",
    )  # fmt: skip
