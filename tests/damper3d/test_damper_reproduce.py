"""The thesis's tables from made rows of known optima, and the command on a small damper."""

import json
import math

import pytest
from made_tables import FLUIDISED, made_onset, made_table
from refusals import assert_refused
from small_damper import CASE, damper3d

from damper3d.reproduce import TABLES, chapter, find, optimum, panels, sizes
from damper3d.reproduce import map as maps
from damper3d.reproduce.optimum import optima, published
from damper3d.run import sweep
from damper3d.studies.predict.prediction import predict
from granulab.campaign.output.results import read_results, write_results
from granulab.campaign.output.statistics import mean_sd

OPTIONS = {"workers": 1, "quiet": True}
OF_PANELS = "map", "optimum", "sizes"
PART = {"map": maps.panels()[:2]}  # of 8 alike, where any will do
# A few Gammas of two frequencies: what a map needs for its two ridges at 40 mm.
FEW = [(f, g) for f in (20.0, 40.0, 80.0) for g in (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 15.0, 20.0,
                                                    30.0, 40.0, 60.0, 80.0, 100.0)]  # fmt: skip


def verdict(text, words):
    """PASS, FAIL or ---- of the claim with these words."""
    (line,) = [line for line in text.splitlines() if words in line and line[:4] in VERDICTS]
    return line[:4]


VERDICTS = "PASS", "FAIL", "----"


@pytest.fixture
def made(monkeypatch):
    """Rows of a table from made runs; keywords are those of made_table."""

    def rows(table, seeds=(1, 2, 3), grid=None, **how):
        monkeypatch.setattr(sweep, "run_cases", made_table(**how))
        return table.run(out=None, seeds=seeds, grid=grid, **OPTIONS)

    return rows


@pytest.mark.parametrize("height", panels.HEIGHTS)
def test_onset_of_close_packing_is_that_of_predict(height):
    """Eqs 6.11 and 6.13 for the thesis's cylinder, as damper3d predict has them."""
    (case,) = {case for _, case in panels.panel("vertical", height, 5, [(40.0, 20.0)]).cases([1])}
    assert panels.close_onset(height, 40.0) == pytest.approx(predict(case).best.onset(40.0))


def test_sizes_have_the_same_volume():
    """Table 6.1: the numbers of 3, 4, 5 and 6 mm fill the same part, to the last particle."""
    volumes = {d: n * d**3 for d, n in panels.SPHERES.items()}
    assert all(abs(v - volumes[5]) <= max(d, 5) ** 3 for d, v in volumes.items())


def test_published_optima_are_those_of_table_6_3():
    assert published(40, "vertical") == {20.0: 5.2, 40.0: 19.6, 80.0: 79.9}
    assert published(55, "horizontal") == {20.0: 13.9, 40.0: 51.6, 80.0: None}


def test_optimum_finds_known_onsets_and_the_square_of_frequency(made):
    """The made peak is a cusp: it lies in each bracket, and the brackets are those of the grid.

    Three halvings of the thesis's Gammas leave at most (40/30)^(1/8), 4 %, to either side; noise
    and scatter widen that, so 10 % are allowed.
    """
    rows = made(optimum)
    found = optima(rows)
    assert len(found) == 18  # four heights, two frequencies, two orientations; 80 Hz at 40 mm
    for (height, frequency, _), one in found.items():
        truth = made_onset({"height_mm": height, "frequency_hz": frequency})
        low, high = one.mean.bracket
        assert low <= truth <= high
        assert one.gamma == pytest.approx(truth, rel=0.1)
    text = optimum.report(rows)
    assert text.startswith("complete: 108 points, 3 packings each")
    for words in ("rises with the clearance", "square of the frequency", "orientation", "close"):
        assert verdict(text, words) == "PASS"


def test_a_bed_that_packs_loosely_fails_the_claim_on_packing(made):
    assert verdict(optimum.report(made(optimum, packing=0.57)), "close packing") == "FAIL"


def test_difference_from_the_thesis_counts_the_scatter(made):
    """19.6 against a made 22.3 or more: beyond a scatter of 0.5 %, within one of 20 %."""
    one = optima(made(optimum))[40, 40.0, "vertical"]
    assert optimum.difference(one, 19.6, (0.005, 30)).startswith("high")
    assert optimum.difference(one, 19.6, (0.2, 30)).startswith("agrees")
    assert optimum.difference(one, 2 * one.gamma, (0.005, 30)).startswith("low")


def test_incomplete_table_says_first_what_lacks_and_still_judges_what_is_there(made):
    rows = [row for row in made(optimum) if row["height_mm"] != 50]
    rows[0] |= {"state": "interrupted", "reason": ""}
    first, *rest = optimum.report(rows).splitlines()
    assert first.startswith("INCOMPLETE: ")
    start = "  lacking: orientation vertical, height_mm 50, diameter_mm 5, frequency_hz 20: gamma "
    assert any(line.startswith(start) for line in rest)
    assert any(line.startswith("interrupted: orientation vertical") for line in rest)
    assert verdict("\n".join(rest), "rises with the clearance") == "PASS"


@pytest.mark.parametrize("table", OF_PANELS)
def test_table_without_any_run_done_can_be_reported_and_drawn(made, table):
    rows = [
        row | {"state": "interrupted"} for row in made(find(table), seeds=[1], grid=PART.get(table))
    ]
    text = find(table).report(rows)
    assert text.startswith("INCOMPLETE: 0 of ")
    assert "PASS" not in text
    assert "FAIL" not in text
    find(table).draw(rows)


def test_map_finds_both_ridges(made):
    grid = [panels.panel(o, 40, 5, FEW) for o in panels.ORIENTATIONS]
    text = maps.report(made(maps, seeds=[1], grid=grid))
    assert text.startswith("INCOMPLETE: ")
    for words in (
        "on the ridge of the bouncing bed", "on the ridge of fluidisation", "near Gamma 3",
        "hardly depends", "follows f^2", "alike in both",
    ):  # fmt: skip
        assert verdict(text, words) == "PASS", text


def test_a_weak_fluidisation_ridge_fails(made):
    grid = [panels.panel("vertical", 40, 5, FEW)]
    text = maps.report(made(maps, seeds=[1], grid=grid, ridge=0.2))
    assert verdict(text, "on the ridge of fluidisation") == "FAIL"
    assert verdict(text, "on the ridge of the bouncing bed") == "PASS"
    assert verdict(text, "alike in both") == "----"


@pytest.mark.parametrize(("how", "expected"), [
    ({"tilt": 0.2, "lying": 0.8}, ["PASS", "PASS", "PASS", "PASS"]),
    ({"tilt": -0.2, "lying": 1.1}, ["FAIL", "FAIL", "FAIL", "PASS"]),
])  # fmt: skip
def test_fluidisation_optimum_over_frequency_orientation_and_fill(made, how, expected):
    """Sec. 6.4.3: it falls with frequency, its eta rises, lying dampers have less, fill is nothing.

    The steps of FEW, up to Gamma 6, are at most a factor of 2; the shift from 80 to 320 Hz is
    4^0.2 = 1.3, between 3 and 2, so that more frequencies are run.
    """
    points = [(f, g) for f in (80.0, 160.0, 320.0, 625.0) for _, g in FEW[:14]]
    grid = [panels.panel(o, h, 5, points) for o in panels.ORIENTATIONS for h in (40, 55)]
    text = maps.report(made(maps, seeds=[1], grid=grid, **how))
    words = "falls with frequency", "rises with frequency", "smaller in the horiz", "insensitive to"
    assert [verdict(text, one) for one in words] == expected, text


def test_chapter_judges_each_size_and_compares_it_with_5_mm(made, tmp_path):
    """The made optima go as d^exponent, so that a map of 3 mm is shifted against that of 5 mm."""
    grid = [panels.panel(o, 40, d, FEW) for d in (3, 5) for o in panels.ORIENTATIONS]
    rows = made(chapter, seeds=[1], grid=grid, size_exponent=-0.3)
    text = chapter.report(rows)
    assert text.startswith("INCOMPLETE: ")
    start = (
        "  lacking: orientation vertical, height_mm 40, diameter_mm 6, frequency_hz 20: gamma 1, "
    )
    assert any(line.startswith(start) for line in text.splitlines())
    of_3, of_5 = ([line.split() for line in text.splitlines() if line.startswith(f"{d} mm  ")]
                  for d in (3, 5))  # fmt: skip
    assert [line[2] for line in of_3] == [line[2] for line in of_5] == list(panels.ORIENTATIONS)
    assert all(0.5 < float(line[-2]) < 1 and float(line[-1]) > 0.01 for line in of_3)
    assert all(line[-2:] == ["-", "-"] for line in of_5)
    assert text.count("spheres of 3 mm, claims: ") == 1
    assert text.count("PASS  eta > 0.3 on the ridge of fluidisation") == 2
    kept, *_ = write_results(
        tmp_path, "chapter", rows, ["command: x"], text, lambda: chapter.draw(rows)
    )
    assert chapter.report(read_results(kept)[1]) == text
    nothing = [row | {"state": "interrupted"} for row in rows]
    assert chapter.report(nothing).startswith("INCOMPLETE: 0 of 5472 points")
    chapter.draw(nothing)


@pytest.mark.parametrize(("exponent", "expected"), [(-0.2, "PASS"), (0.2, "FAIL")])
def test_trend_of_the_optimum_with_size(made, exponent, expected):
    """Gamma goes as d^exponent: a factor of 2^0.2 = 1.15 from 3 to 6 mm, a small effect."""
    rows = made(sizes, size_exponent=exponent)
    text = sizes.report(rows)
    assert verdict(text, "generally falls with size") == expected
    assert verdict(text, "small effect on the bouncing bed") == "PASS"
    for one in sizes.optima(rows)["vertical", 160.0].values():
        assert one.gamma == pytest.approx(FLUIDISED, rel=0.1)


def test_a_large_effect_of_size_is_reported(made):
    """2^0.9 = 1.87 from 3 to 6 mm is above 1.5."""
    text = sizes.report(made(sizes, size_exponent=-0.9))
    assert verdict(text, "small effect on the bouncing bed") == "FAIL"


@pytest.mark.parametrize("table", OF_PANELS)
def test_report_is_made_again_from_the_rows_that_are_kept(made, tmp_path, table):
    """From CSV and back: the same words."""
    module = find(table)
    rows = made(module, seeds=[1, 2], grid=PART.get(table))
    text = module.report(rows)
    kept, *_ = write_results(tmp_path, table, rows, ["command: x"], text, lambda: module.draw(rows))
    assert module.report(read_results(kept)[1]) == text


def test_scatter_of_an_optimum_is_that_over_packings(made):
    """Each packing alone has a peak; its ln Gamma scatters as it was made, 3 packings: 1 %."""
    one = optima(made(optimum, seeds=range(1, 9), scatter=0.05))[40, 40.0, "vertical"]
    assert one.logarithms.n == 8
    # s of 8 values is within 0.48 and 1.52 of sigma by 95 %; grid and noise add some 4 %.
    assert 0.02 < one.logarithms.sd < 0.1
    assert one.logarithms == mean_sd(one.alone)
    pooled = (0.05, 100)
    assert one.allowance(pooled) > one.error(pooled) > one.resolution
    assert one.error(None) == pytest.approx(one.resolution)
    assert math.exp(one.logarithms.mean) == one.gamma


def test_command_computes_a_small_damper_and_goes_on_where_it_was(monkeypatch, tmp_path):
    """Thirty spheres on two points: two runs of one packing, then none is done again."""
    small = {key.replace(".", "__"): value for key, value in CASE.items()}
    small |= {"particles__count": 30}
    points = [(80.0, 5.0), (80.0, 10.0)]
    grid = [panels.panel("vertical", 25, 5, points, **small)]
    monkeypatch.setattr(optimum, "panels", lambda: grid)
    words = ["reproduce", "optimum", "--seeds", 1, "--workers", 1, "--out", tmp_path]
    result = damper3d(*words)
    assert result.code == 0, result.err
    assert "2 runs of 1 packings, about" in result.err
    assert "INCOMPLETE: 2 of 2 points are there, with 1 of 3 packings each" in result.out
    head, rows = read_results(tmp_path / "reproduce-optimum.csv")
    assert head["command"] == "damper3d reproduce optimum --seeds 1"
    assert [row["gamma"] for row in rows] == [5.0, 10.0]
    _, whole = read_results(tmp_path / "reproduce-optimum.parquet")
    assert all(row["n_particles"] == 30 for row in whole)
    assert [row["efficiency"] for row in whole] == [row["efficiency"] for row in rows]
    again = damper3d(*words, "--json")
    assert all(row["reused"] for row in json.loads(again.out)["rows"])


def test_command_refuses_a_folder_that_cannot_be_made_before_anything_is_run(monkeypatch, tmp_path):
    """In one line: no word of what the runs will cost."""
    monkeypatch.setattr(sweep, "run_cases", None)
    (tmp_path / "file").write_text("in the way")
    result = damper3d("reproduce", "optimum", "--write", tmp_path / "file", "--out", tmp_path / "x")
    assert_refused(result, "file: cannot be written")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_command_without_a_table_lists_them_and_refuses_another():
    assert [line.split()[0] for line in damper3d("reproduce").out.splitlines()] == list(TABLES)
    result = damper3d("reproduce", "optimm")
    assert result.code == 2
    assert "optimum" in result.err
