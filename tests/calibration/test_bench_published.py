"""The sources' printed measurements compared with what follows from their own parts."""

import numpy as np
import pytest
from calibrating import calibrate
from refusals import assert_refused
from scipy.stats import f_oneway

from calibration.statistics.uncertainty import Estimate, of_trials, pooled, pooled_summaries


def rows(table: str) -> dict[str, dict]:
    return {one["what"]: one for one in calibrate("published", table, "--json").json[table]}


def test_groups_known_by_mean_and_scatter_alone_are_as_good_as_their_trials():
    """Oracle: scipy's analysis of variance of the trials themselves; to rounding."""
    rng = np.random.default_rng(9)
    made = (("a", 1, 5), ("b", 1.1, 8), ("c", 1, 3))
    groups = {name: list(rng.normal(mean, 0.1, n)) for name, mean, n in made}
    whole = [value for values in groups.values() for value in values]
    known = {
        k: Estimate(float(np.mean(v)), None, len(v), float(np.std(v, ddof=1)))
        for k, v in groups.items()
    }
    found = pooled_summaries(known)
    assert found.p == pytest.approx(f_oneway(*groups.values()).pvalue, rel=1e-9)
    assert found.all.scatter == pytest.approx(np.std(whole, ddof=1), rel=1e-12)
    assert found.all.value == pytest.approx(pooled(groups).all.value, rel=1e-12)


def test_friction_of_sec_3_1():
    """0.46, 0.47, 0.40: 0.443, printed 0.44. 0.38, 0.40, 0.33: 0.370, printed 0.38 (errata)."""
    found = rows("friction")
    assert found["friction particle-wall"]["found"] == pytest.approx(0.4433, abs=1e-4)
    assert found["friction particle-particle"]["found"] == pytest.approx(0.37, abs=1e-12)


def test_restitution_of_tables_2_and_3():
    """The means of the printed means are those of Table 4, to its last digit."""
    found = rows("restitution")
    assert round(found["restitution particle-wall"]["found"], 2) == 0.53
    assert round(found["restitution particle-particle"]["found"], 2) == 0.45
    assert found["restitution particle-wall"]["groups_p"] < 1e-10


def test_table_2_has_the_sigma_of_three_particles_not_of_nine_means():
    """Particles' means 0.680, 0.430, 0.483, alike within: at least Student's t s/sqrt(3), 0.100."""
    of_particles = of_trials([0.68, 0.43, 1.45 / 3]).sigma
    found = rows("restitution")["restitution particle-wall"]["sigma"]
    assert found == pytest.approx(of_particles, rel=0.02)


def test_averages_of_thesis_table_7_1():
    """Printed 0.16, 11.97 and 0.35 um."""
    found = [round(one["found"], 2) for one in rows("roughness").values()]
    assert found == [0.16, 11.97, 0.35]


def test_gamma_t_needs_30_degrees_and_kn_is_14520():
    assert "3.0 needs 30.2 deg" in next(iter(rows("damping").values()))["remark"]
    found = [one["found"] for one in rows("stiffness").values()]
    assert found == pytest.approx([14520, 39000], rel=1e-12)


def test_surface_density_is_density_times_length():
    """0.45e-3 g/mm3 x 120 mm = 0.054 g/mm2, sec. 3.5."""
    assert next(iter(rows("density").values()))["found"] == pytest.approx(0.054, rel=1e-12)


def test_all_tables_are_shown_and_an_unknown_one_is_reported():
    said = calibrate("published").out
    for name in ("friction", "restitution", "interface", "stiffness", "damping", "roughness"):
        assert f"\n{name}\n" in said
    result = calibrate("published", "frictoin")
    assert_refused(result, "did you mean 'friction'")
