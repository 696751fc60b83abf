"""Numbers from a run: definitions of the times, the energy balance, the published tables."""

import math

import numpy as np
import pytest
from fake_run import write_fake_run
from hypothesis import given
from hypothesis import strategies as st

from granulab.campaign.runs.trajectory import read_trajectory
from granulab.contact.attraction import Attraction
from granulab.contact.files.datafile import data_file
from silo2d.case.outline import PRESETS
from silo2d.case.shapefile import load_shapes
from silo2d.run.ending import crosses_line
from silo2d.run.numbers import (
    MECHANISMS,
    discharge_curve,
    discharge_measures,
    energy_closure,
    published_times,
)
from silo2d.run.summary import write_records

NAN = math.nan
SHAPES = load_shapes("wood19").shapes


def test_t90_and_mean_rate_of_ten_particles():
    """T90: the ceil(0.9 n)-th leaver; rate 0.8 n/(t90 - t10). Ten leave at 1 ... 10 s: 9 s, 1/s."""
    out_time = np.array([7, NAN, 2, 10, 3, 1, 9, NAN, 5, 4, 8, 6.0])
    mass = np.full(12, 0.25)
    assert discharge_measures(out_time, mass) == {
        "n_out": 10,
        "t90_s": 9.0,
        "mean_rate_per_s": 1.0,
        "mean_mass_flow_kg_per_s": 0.25,
        "last_out_s": 10.0,
    }


@given(st.lists(st.integers(0, 50), min_size=1, max_size=40))
def test_t90_is_the_first_time_by_which_nine_tenths_are_out(times):
    """Its definition, counted in whole numbers; ties included."""
    t90 = discharge_measures(times, np.ones(len(times)))["t90_s"]
    assert 10 * sum(t <= t90 for t in times) >= 9 * len(times)
    assert 10 * sum(t < t90 for t in times) < 9 * len(times)


@pytest.mark.parametrize(("out_time", "n"), [([NAN, NAN], 0), ([NAN, 0.3], 1), ([0.3, 0.3], 2)])
def test_no_rate_where_nothing_leaves_or_all_at_once(out_time, n):
    """A value that does not exist is None, not infinity."""
    measures = discharge_measures(out_time, [1.0, 1.0])
    assert measures["n_out"] == n
    assert measures["t90_s"] == measures["last_out_s"] == (0.3 if n else None)
    assert measures["mean_rate_per_s"] is measures["mean_mass_flow_kg_per_s"] is None


def test_attraction_is_counted_along_the_normal_and_in_particle_weights():
    """Three press or only shear, one pulls with 0.3 N: a quarter, and three weights of 0.1 N."""
    normal = np.array([[0.0, 1.0], [1.0, 0.0], [0.0, 1.0], [0.6, 0.8]])
    force = np.array([[0.1, 2.0], [0.0, -5.0], [0.0, -0.3], [0.6, 0.8]])
    found = Attraction()
    found.look({"normal": normal, "force": force})
    assert found.numbers(0.1) == pytest.approx({"share": 0.25, "particle_weights": 3.0})
    found.look({"normal": np.zeros((0, 2)), "force": np.zeros((0, 2))})
    found.look({"normal": normal[:2], "force": force[:2]})
    assert found.numbers(0.1)["share"] == pytest.approx(1 / 6)
    assert Attraction().numbers(0.1) == {"share": 0.0, "particle_weights": 0.0}


def test_columns_of_the_records_end_with_their_unit(tmp_path):
    """Counts have none; energies are in J, forces in N; the numbers are those of the frames."""
    run = write_fake_run(tmp_path)
    write_records(run)
    head, *rows = (run.path / "records.csv").read_text().splitlines()
    bare = [name for name in head.split(",") if not name.endswith(("_s", "_j", "_n"))]
    assert bare == ["n_out", "steps"] or bare == ["n_out"]
    assert "time_s" in head
    assert len(rows) == len(read_trajectory(run.path)["time"])


def test_discharge_curve_agrees_with_the_counts_of_the_frames(tmp_path):
    """Particles out at a frame are those whose time has come, whoever counts."""
    write_fake_run(tmp_path)
    trajectory = read_trajectory(tmp_path)
    times, count = discharge_curve(trajectory)
    assert (np.diff(times) >= 0).all()
    counted = [count[times <= t].max(initial=0) for t in trajectory["time"]]
    np.testing.assert_array_equal(counted, trajectory["n_out"])


def balance(dissipated: float, lost: float) -> dict[str, np.ndarray]:
    """Two frames: `dissipated` J become heat, 10 J are carried out and `lost` J vanish."""
    share = dissipated / len(MECHANISMS)
    return {
        "kinetic": np.array([1.0, 5.0]),
        "potential": np.array([40.0 + dissipated + lost, 30.0]),
        "elastic_normal": np.array([3.0, 1.0]),
        "elastic_tangential": np.array([2.0, 0.0]),
        "carried_out": np.array([7.0, 17.0]),  # of the filling, before the first frame, 7 J
        **{name: np.array([4.0, 4.0 + share]) for name in MECHANISMS},
    }


@pytest.mark.parametrize("lost", [0.0, 2.0, -3.0])
def test_energy_closure_is_what_the_balance_lacks(lost):
    """E(0) - E(t) - carried out - dissipated, over the dissipated; tolerance: rounding of 100 J."""
    unaccounted, closure = energy_closure(balance(50.0, lost))
    np.testing.assert_allclose(unaccounted, [0.0, lost], atol=1e-13)
    assert closure == pytest.approx(lost / 50.0, abs=1e-14)


def test_no_energy_closure_where_nothing_is_dissipated():
    """There is nothing to compare with."""
    assert energy_closure(balance(0.0, 1.0))[1] is None


@given(
    st.lists(st.tuples(st.integers(0, 18), st.floats(-0.02, 0.02), st.floats(-9, 9)), max_size=9)
)
def test_centre_line_is_crossed_where_the_swept_core_meets_it(particles):
    """Oracle: shapely's distance of the core from the line, less the spheroradius.

    Particles that touch the line within 0.1 um are left to rounding.
    """
    from shapely import LineString, Polygon
    from shapely.affinity import rotate, translate

    empty = np.empty(0, int), np.empty(0), np.empty(0)
    columns = zip(*particles, strict=True) if particles else empty
    kind, x, angle = (np.array(column) for column in columns)
    centre = 0.003
    line = LineString([(centre, -1), (centre, 1)])
    found = crosses_line(x, angle, kind, SHAPES, centre)
    assert found.shape == (len(particles),)
    for k, shape in enumerate(SHAPES[i] for i in kind):
        rotated = rotate(Polygon(shape.core), angle[k], origin=(0, 0), use_radians=True)
        gap = translate(rotated, x[k]).distance(line) - shape.spheroradius
        if abs(gap) > 1e-7:
            assert found[k] == (gap < 0)


def test_published_times_of_a3():
    """Journal Table 5: 2.15, C, 2.1, 2.05, 2.07 s; mean 2.0925, sd 0.0435. SPOLY printed none."""
    assert published_times("A3") == {
        "experiment_mean_s": pytest.approx(2.0925),
        "experiment_sd_s": pytest.approx(0.04349, abs=1e-5),
        "experiment_n": 5,
        "experiment_clogged": 1,
        "simulation_s": None,
        "simulation_clogged": None,
    }


def test_published_times_of_a_silo_that_always_clogged():
    """A clogged trial counts, and has no time."""
    assert published_times("B2") == {
        "experiment_mean_s": None,
        "experiment_sd_s": None,
        "experiment_n": 1,
        "experiment_clogged": 1,
        "simulation_s": None,
        "simulation_clogged": True,
    }


@pytest.mark.parametrize(
    ("silo", "time"), [("A4", 1.00), ("B4", 1.19), ("C3", 3.05), ("C4", 1.64), ("D4", 1.78)]
)
def test_published_times_of_spoly(silo, time):
    """Journal Table 6 and the caption of Fig. 13."""
    known = published_times(silo)
    assert (known["simulation_s"], known["simulation_clogged"]) == (time, False)


def test_every_published_trial_belongs_to_a_preset():
    """No line of the table is lost between its outlet in mm and a silo's number."""
    table = data_file("published", "silo_discharge_experiment").read_text(encoding="utf-8")
    lines = [line for line in table.splitlines() if not line.startswith("#")]
    assert sum(published_times(silo)["experiment_n"] for silo in PRESETS) == len(lines) - 1


def test_nothing_is_published_about_other_silos():
    """Nor is the name taken apart: A40 is not A4."""
    for name in ("my silo", "A40", "a4", ""):
        assert set(published_times(name).values()) == {None}
