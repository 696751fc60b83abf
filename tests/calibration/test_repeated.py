"""Positions that repeat the one before: copies in fast flight, and none about an apex."""

import numpy as np

from calibration.statistics.repeated import pattern, repeated


def test_an_apex_seen_with_noise_has_no_copies():
    """y = a s^2/2, a = 0.15 px/frame^2: about the apex all steps are below the noise's three."""
    step = 0.15 * np.arange(-14.5, 15)
    rows, _ = repeated(step, np.abs(step) < 0.4, 0.1)
    assert len(rows) == 0


def test_a_copy_in_flight_is_found_and_so_is_whether_it_took_time():
    """A copy put in is followed by one step; a copy in the place of a lost frame by two."""
    for after, late in ((3.0, True), (6.0, False)):
        step = np.array([3.0] * 6 + [0.0, after] + [3.0] * 6)
        rows, took_none = repeated(step, np.abs(step) < 0.3, 0.1)
        assert rows.tolist() == [7]
        assert took_none.tolist() == [late]


def test_a_pattern_of_copies_is_found_where_a_part_of_the_track_is_missing():
    """Every fifth picture is a copy; thirty positions, far more than a window, are not known."""
    step = np.where(np.arange(1, 120) % 5 == 0, 0.0, 3.0)
    assert pattern(np.arange(120.0), step) == (5, 0)
    step[40:70] = np.nan
    assert pattern(np.arange(120.0), step) == (5, 0)
