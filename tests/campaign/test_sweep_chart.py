"""Pictures of sweeps: what is handed to the drawing, for each kind of what was varied."""

import math

import numpy as np
import pytest
from analytic import students_t, wilson_interval
from made_sweeps import CASE, DRAWN, SPEED, STUCK, A, B, compared, lost, run, seeds

from granulab.campaign.output.figure import as_png
from granulab.campaign.sweeps.report.chart import draw_sweep
from granulab.campaign.sweeps.report.heat_map import heat_map


def drawn(varied, rows):
    """The picture of a study, not yet made into pixels."""
    return draw_sweep(compared(varied, rows))


def panels(figure):
    """The panels of a picture by what they show."""
    return {axes.get_ylabel() or axes.get_xlabel(): axes for axes in figure.axes}


def bars(axes):
    """Positions and means of each series of a panel, and the ends of its bars."""
    series = []
    for container in axes.containers:
        line, _, (lines,) = container
        ends = [segment[:, 1] for segment in lines.get_segments()]
        series.append((*line.get_data(), np.array(ends)))
    return series


def marks(axes):
    """Positions of the marks of runs without a value, by how they ended."""
    return {line.get_label(): list(line.get_xdata()) for line in axes.get_lines()
            if not line.get_label().startswith("_")}  # fmt: skip


def test_one_number_makes_curves_with_intervals_and_marks_those_without_a_value():
    """Means 1.5 and 5 with Student's bars of two and three runs; the share of stuck runs with
    Wilson's; the failed run at 20 mm stands at the edge, once."""
    rows = [*seeds([1.0, 2.0], **{"a.width_m": 0.01}), lost("failed", 3, **{"a.width_m": 0.02}),
            *seeds([4.0, 5.0, 6.0], **{"a.width_m": 0.02}),
            *seeds([7.0, 9.0], **{"a.width_m": 0.03})]  # fmt: skip
    figure = drawn([A], rows)
    speed = panels(figure)["speed [m/s]"]
    ((x, mean, ends),) = bars(speed)
    assert list(x) == [10.0, 20.0, 30.0]
    assert mean == pytest.approx([1.5, 5.0, 8.0])
    half = [students_t(1) * math.sqrt(0.5) / math.sqrt(2), students_t(2) / math.sqrt(3)]
    assert ends[1] == pytest.approx([5.0 - half[1], 5.0 + half[1]])
    assert ends[0] == pytest.approx([1.5 - half[0], 1.5 + half[0]])
    assert marks(speed) == {"failed": [20.0]}
    assert "a.width [mm]" in speed.get_xlabel()
    ((_, shares, share_ends),) = bars(panels(figure)["share stuck"])
    assert list(shares) == [0.0, 0.0, 0.0]
    assert share_ends[1] == pytest.approx([0.0, wilson_interval(0, 3)[1]], abs=1e-12)
    legend = figure.legends[0]
    assert "2 to 4 seeds" in legend.get_title().get_text()


def test_single_runs_stand_behind_their_mean():
    axes = panels(drawn([A], seeds([1.0, 4.0], **{"a.width_m": 0.01}) +
                        seeds([2.0, 3.0], **{"a.width_m": 0.02})))["speed [m/s]"]  # fmt: skip
    dots = next(line for line in axes.get_lines() if line.get_linestyle() == "None")
    assert sorted(dots.get_ydata()) == [1.0, 2.0, 3.0, 4.0]


def test_an_interval_far_wider_than_the_values_leaves_the_panel():
    """Of two runs it is nine times their distance."""
    rows = [*seeds([4.0, 6.0], **{"a.width_m": 0.01}), *seeds([5.0, 5.0], **{"a.width_m": 0.02})]
    low, high = panels(drawn([A], rows))["speed [m/s]"].get_ylim()
    assert (low, high) == (2.0, 8.0)


def test_two_numbers_make_a_heat_map_whose_cells_say_mean_interval_and_ends():
    """Rows go up with the second number; a cell whose runs all got stuck has no time."""
    cells = {(0.01, 1): [1.0, 1.2], (0.02, 1): [3.0, 3.4], (0.01, 5): [2.0, 2.2]}
    rows = [row for (width, count), speeds in cells.items()
            for row in seeds(speeds, **{"a.width_m": width, "b.count": count})]  # fmt: skip
    rows += [run(9.0, k, stuck=True, **{"a.width_m": 0.02, "b.count": 5}) for k in (1, 2)]
    rows.append(lost("failed", 3, **{"a.width_m": 0.01, "b.count": 1}))
    comparison = compared([A, B], rows)
    across, up = comparison.axes
    found, words, best = heat_map(SPEED, across, up, comparison)
    assert found == pytest.approx(np.array([[1.1, 3.2], [2.1, 9.0]]))
    assert best == (1, 1)
    assert words[0, 0] == "1.1\n±1.3\n2 of 3"
    time, time_words, fastest = heat_map(comparison.offered.numbers[1], across, up, comparison)
    assert np.isnan(time[1, 1])
    assert time_words[1, 1] == "2 stuck"
    assert fastest == (0, 1)
    assert heat_map(STUCK, across, up, comparison)[1][1, 1] == "2 of 2\n34 to 100 %"
    figure = drawn([A, B], rows)
    panel = next(axes for axes in figure.axes if axes.get_ylabel() == "b.count")
    assert [text.get_text() for text in panel.get_xticklabels()] == ["10", "20"]
    assert {text.get_text() for text in panel.texts} >= {"2 of 2\n34 to 100 %"}


def test_words_make_lying_dots_and_a_number_by_words_a_curve_for_each():
    rows = [row for case in ("flat", "steep") for width in (0.01, 0.02)
            for row in seeds([1.0, 3.0], **{"case": case, "a.width_m": width})]  # fmt: skip
    figure = drawn([CASE, A], rows)
    series = bars(panels(figure)["speed [m/s]"])
    assert len(series) == 2
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["flat", "steep"]
    assert np.abs(series[0][0] - [10.0, 20.0]).max() < 1.0  # moved apart a little
    words = drawn([CASE], [row for row in rows if row["a.width_m"] == 0.01])
    panel = next(axes for axes in words.axes if axes.get_xlabel() == "speed [m/s]")
    (container,) = panel.containers
    assert list(container[0].get_xdata()) == [2.0, 2.0]
    assert list(container[0].get_ydata()) == [0.0, 1.0]


def test_a_number_that_was_drawn_makes_a_scatter_with_its_rank_correlation():
    rows = [run(value**2, 1, **{"c.mu": value}) for value in (0.3, 0.1, 0.5, 0.4)]
    panel = panels(drawn([DRAWN], rows))["speed [m/s]"]
    (points,) = [line for line in panel.get_lines() if len(line.get_xdata()) == 4]
    assert dict(zip(*points.get_data(), strict=True)) == {v: v**2 for v in (0.3, 0.1, 0.5, 0.4)}
    assert panel.get_title(loc="right") == "ρ +1.00 [\u22120.85, +1.00], n = 4"


def test_more_keys_make_main_effects_over_all_combinations():
    """A panel a key: at each of its values the mean of the others' means, with the interval of an
    analysis of variance: of four combinations of two runs, s^2 = 1/2 and t of four degrees."""
    rows = [
        row
        for case, more in (("flat", 0.0), ("steep", 10.0))
        for width in (0.01, 0.02)
        for count in (1, 2)
        for row in seeds([1.0 + more + count, 2.0 + more + count],
                         **{"case": case, "a.width_m": width, "b.count": count})
    ]  # fmt: skip
    figure = drawn([CASE, A, B], rows)
    assert as_png(lambda: figure)
    effects = [axes for axes in figure.axes if axes.containers]
    assert len(effects) == 9  # three keys times share, speed and time
    of_speed = effects[3:6]
    means = [bars(axes)[0][1] for axes in of_speed]
    assert [m.tolist() for m in means] == [[3.0, 13.0], [8.0, 8.0], [7.5, 8.5]]
    (low, high), _ = bars(of_speed[1])[0][2]
    sd, t4 = math.sqrt(0.5), 2.7764451
    assert high - low == pytest.approx(2 * t4 * sd * math.sqrt(4 / 2) / 4, rel=1e-6)


def test_a_study_of_seeds_alone_has_its_one_combination():
    panel = next(axes for axes in drawn([CASE], seeds([1.0, 3.0], case="x")).axes
                 if axes.get_xlabel() == "speed [m/s]")  # fmt: skip
    assert list(panel.containers[0][0].get_xdata()) == [2.0]


def test_nothing_is_drawn_where_no_run_is_done():
    assert draw_sweep(compared([A], [lost("failed", **{"a.width_m": 0.01})])) is None


def test_a_large_map_has_no_words_in_its_cells_and_few_names_at_its_edges():
    rows = [run(1.0 + i * k, **{"a.width_m": 0.01 * i, "b.count": k})
            for i in range(1, 81) for k in range(1, 61)]  # fmt: skip
    figure = drawn([A, B], rows)
    panel = next(axes for axes in figure.axes if axes.get_ylabel() == "b.count")
    assert len(panel.texts) == 0
    assert sum(text.get_visible() for text in panel.get_yticklabels()) <= 24
