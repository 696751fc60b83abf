"""How much of a table is there: the first lines of its report."""

from damper3d.reproduce.panels import completeness

POINTS = [{"size": size, "gamma": gamma} for size in (3, 5) for gamma in (1.0, 2.5, 20.0)]


def _done(seeds, points=POINTS):
    return [
        point | {"seed": seed, "state": "done", "reason": ""} for point in points for seed in seeds
    ]


def test_a_table_is_whole_with_its_own_number_of_packings_or_more():
    assert completeness(_done([1, 2]), POINTS, 2) == "complete: 6 points, 2 packings each"
    assert completeness(_done([1, 2, 3]), POINTS, 2) == "complete: 6 points, 3 packings each"
    assert completeness(_done([1]), POINTS, 1) == "complete: 6 points, 1 packing each"


def test_fewer_packings_than_by_default_are_reported():
    """As after --seeds 1: no point lacks against another."""
    assert completeness(_done([1]), POINTS, 3) == (
        "INCOMPLETE: 6 of 6 points are there, with 1 of 3 packings each"
    )


def test_points_that_lack_are_named_and_added_ones_do_not_count():
    """A packing that is in the rows twice counts once."""
    rows = [*_done([1, 2], POINTS[:4]), *_done([1, 1], POINTS[4:5])]
    rows += _done([1, 2], [{"size": 5, "gamma": 15.0}])
    rows.append(POINTS[5] | {"seed": 1, "state": "failed", "reason": "energy"})
    assert completeness(rows, POINTS, 2).splitlines() == [
        "INCOMPLETE: 5 of 6 points are there, with 2 packings at most",
        "  lacking: size 5: gamma 2.5 (1 of 2), 20",
        "failed: size 5, gamma 20.0, seed 1: energy",
    ]


def test_a_point_with_fewer_packings_than_others_lacks():
    rows = [*_done([1, 2, 3], POINTS[:5]), *_done([1, 2], POINTS[5:])]
    assert completeness(rows, POINTS, 2).splitlines() == [
        "INCOMPLETE: 6 of 6 points are there, with 3 packings at most",
        "  lacking: size 5: gamma 20 (2 of 3)",
    ]


def test_a_whole_table_reports_added_points_that_failed():
    rows = [*_done([1]), {"size": 5, "gamma": 15.0, "seed": 1, "state": "failed", "reason": "x"}]
    assert completeness(rows, POINTS, 1).splitlines() == [
        "complete: 6 points, 1 packing each",
        "failed: size 5, gamma 15.0, seed 1: x",
    ]


def test_long_lists_are_cut_short():
    points = [{"size": size, "gamma": 1.0} for size in range(20)]
    rows = [point | {"seed": 1, "state": "interrupted", "reason": ""} for point in points]
    lines = completeness(rows, points, 1).splitlines()
    assert lines[0] == "INCOMPLETE: 0 of 20 points are there"
    assert lines[13] == lines[26] == "  ... and 8 more such lines"
    assert len(lines) == 27
