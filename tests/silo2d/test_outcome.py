"""How a discharge can end, on small silos in which it must end so."""

import numpy as np
import pytest
from small_silo import silo2d, write_case

from granulab.campaign.runs.trajectory import read_trajectory


def run_of(tmp_path, changes: dict) -> dict:
    case = write_case(tmp_path, {"silo.height": "60 mm", "fill.level": "40 mm", **changes})
    return silo2d("run", case, "-o", tmp_path / "runs", "--no-figures", "--quiet", "--json").json


def test_a_wide_hopper_empties(reference):
    """Every particle leaves, the last one at the discharge time, and no energy is left inside."""
    frames, table = read_trajectory(reference.path), reference.read_summary()
    assert table["outcome"] == "empty"
    out_time = frames["out_time"][-1]
    assert not np.isnan(out_time).any()
    assert table["discharge_time_s"] == out_time.max()
    assert (np.diff(frames["n_out"]) >= 0).all()


def test_a_flat_floor_keeps_dead_zones(tmp_path):
    """Next to an outlet in a flat floor particles lie on the floor; none lies over its middle."""
    flat = {"silo.angle": "0 deg", "silo.width": "120 mm", "fill.level": "30 mm"}
    table = run_of(tmp_path, {**flat, "law.mu_particle": 0.4, "law.mu_wall": 0.4})
    assert table["outcome"] == "dead_zones"
    assert 0 < table["n_out"] < table["n_particles"]
    assert table["discharge_time_s"] is not None
    frames = read_trajectory(table["run_folder"])
    inside = frames["inside"][-1]
    # Nothing moves: a particle of 7 mm that has fallen 1 um would have 4 mm/s.
    assert np.abs(frames["vy"][-1][inside]).max() < 4e-3
    assert np.abs(frames["x"][-1][inside]).min() > 2.5e-3


@pytest.mark.parametrize(
    ("outlet", "opening_count", "outcome"),
    [("12 mm", 5, "clogged_at_opening"), ("30 mm", 1, "clogged")],
)
def test_a_narrow_outlet_clogs(tmp_path, outlet, opening_count, outcome):
    """Particles of 5 mm to 10 mm with friction make an arch over 12 mm at once, over 30 mm soon.

    With fewer out than opening_count it is said to clog at the opening. Times there are none.
    """
    rough = {"law.mu_particle": 0.4, "law.mu_wall": 0.4}
    narrow = {"silo.outlet": outlet, "silo.width": "70 mm", "run.opening_count": opening_count}
    table = run_of(tmp_path, {**rough, **narrow})
    assert table["outcome"] == outcome
    assert table["n_out"] < table["n_particles"] / 2
    assert table["discharge_time_s"] is None
    assert table["t90_s"] is None


def test_the_time_limit_ends_a_run_and_gives_no_discharge_time(runs, tmp_path):
    """After 0.15 s some particles are out and most are not: nothing has been discharged yet."""
    case = write_case(tmp_path, {"run.max_time": "0.15 s"})
    table = silo2d("run", case, "-o", runs, "--no-figures", "--quiet", "--json").json
    assert table["outcome"] == "time_limit"
    assert table["simulated_s"] == pytest.approx(0.15, abs=1e-12)
    assert 0 < table["n_out"] < table["n_particles"]
    assert table["discharge_time_s"] is None
