"""Residence times by starting level and place, against motions that are known."""

import json

import numpy as np
import pytest
from moved_run import falling, write_moved_run

from granulab.campaign.output.figure import write_figure
from granulab.errors import InputError
from silo2d.case.outline import hopper
from silo2d.measures import find, residence

SILO = hopper(0.0, 0.15, name="flat")
SPEED = 1.25  # m/s: the highest of 475 mm leaves before 0.4 s


def test_first_in_first_out(tmp_path):
    """Plug flow at v: a particle leaves after y/v, so its order is that of the heights.

    A layer's mean is its mean height over v; tolerance: single precision, 3e-8 m over v.
    """
    start = write_moved_run(
        tmp_path, lambda s, t: falling(s, t, SPEED), silo=SILO, out_time=lambda s: s[:, 1] / SPEED
    )
    numbers = residence.measure(tmp_path)
    assert numbers["order_by_height"] == pytest.approx(1.0)
    assert numbers["n_staying"] == 0
    layer = (start[:, 1] // 0.045).astype(int)
    for row in numbers["by_layer"]:
        times = start[layer == row["layer"], 1] / SPEED
        assert row["mean_s"] == pytest.approx(times.mean(), abs=1e-7)
        assert row["sd_s"] == pytest.approx(times.std(ddof=1), abs=1e-7)


def test_last_in_first_out_and_those_that_stay(tmp_path):
    """The highest leave first and the lowest third stays: order -1, and each is counted once."""

    def leave(start):
        return np.where(start[:, 1] > 0.15, (0.5 - start[:, 1]) / SPEED, np.nan)

    start = write_moved_run(tmp_path, lambda s, t: falling(s, t, 0.0), silo=SILO, out_time=leave)
    numbers = residence.measure(tmp_path)
    assert numbers["order_by_height"] == pytest.approx(-1.0)
    assert numbers["n_staying"] == (start[:, 1] <= 0.15).sum()
    for rows in (numbers["by_layer"], numbers["by_column"]):
        assert sum(row["n_out"] for row in rows) == numbers["n_out"]
        assert sum(row["n_staying"] for row in rows) == numbers["n_staying"]
    assert numbers["by_layer"][0]["mean_s"] is None


def test_columns_show_where_particles_wait(tmp_path):
    """Leaving after 0.1 s + |x| s/m: a column's mean lies within its edges' times."""
    write_moved_run(
        tmp_path, lambda s, t: falling(s, t, 0.0), silo=SILO,
        out_time=lambda s: 0.1 + np.abs(s[:, 0]),
    )  # fmt: skip
    for row in residence.measure(tmp_path)["by_column"]:
        nearest, furthest = sorted(abs(row[key]) for key in ("left_m", "right_m"))
        nearest = 0.0 if row["left_m"] < 0 < row["right_m"] else nearest
        assert 0.1 + nearest <= row["mean_s"] <= 0.1 + furthest


def test_nobody_leaves(tmp_path):
    """There is no residence time, which one line says."""
    write_moved_run(tmp_path, lambda s, t: falling(s, t, 0.0), silo=SILO)
    for ask in (residence.measure, residence.draw):
        with pytest.raises(
            InputError, match="0 particles left: a residence time needs one at least"
        ):
            ask(tmp_path)


def test_residence_of_a_run_is_json_and_a_picture(reference, tmp_path):
    """A real run."""
    found = find("residence")
    json.dumps(found.measure(reference.path), allow_nan=False)
    assert write_figure(tmp_path / "r.png", lambda: found.draw(reference.path)).stat().st_size
