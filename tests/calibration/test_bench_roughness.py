"""Ra of profiles with closed forms, what removing the form does, and the sigma of a path."""

import math

import numpy as np
import pytest
from bench_calls import write
from calibrating import calibrate

from calibration.bench.roughness import of_profile, without_form

X = np.linspace(0, 2e-3, 2001)


def test_a_sine_has_two_over_pi_of_its_amplitude():
    """Thesis eq. 7.1: 2 a/pi; straight pieces of 1/100 wave miss (2 pi/100)^2/12 = 3.3e-4."""
    z = 5e-6 * np.sin(2 * np.pi * X / 1e-4)
    assert of_profile(X, z).value == pytest.approx(2 / math.pi * 5e-6, rel=3.4e-4)


def test_straight_pieces_are_integrated_exactly_across_zero():
    """A zigzag between +a and -a has a/2, wherever its corners are the only points."""
    x = np.linspace(0, 1e-3, 101)
    z = np.where(np.arange(101) % 2, 1e-6, -1e-6)
    assert of_profile(x, z).value == pytest.approx(0.5e-6, rel=1e-12)


@pytest.mark.parametrize(
    ("form", "shape"),
    [
        ("mean", 7e-6 + 0 * X),
        ("line", 3e-6 + 0.02 * X),
        ("parabola", 3e-6 + 0.02 * X - 40 * X**2),
        ("circle", np.sqrt(2.5e-3**2 - (X - 0.7e-3) ** 2)),
        ("circle", -np.sqrt(2.5e-3**2 - (X - 1e-3) ** 2)),
        ("circle", 0.1 * X),
    ],
)
def test_the_form_is_taken_off(form, shape):
    """What is left of a form alone is rounding: 1e-12 m against micrometres.

    The circle is that of the thesis's 5 mm spheres, its top off the middle of the path.
    """
    assert np.abs(without_form(X, shape, form)).max() < 1e-12


def test_taking_the_form_off_takes_little_of_the_roughness():
    """20 waves of 5 um on the sphere: the circle follows them by less than 1 %."""
    z = np.sqrt(2.5e-3**2 - (X - 0.7e-3) ** 2) + 5e-6 * np.sin(2 * np.pi * X / 1e-4)
    exact = 2 / math.pi * 5e-6
    assert of_profile(X, without_form(X, z, "circle")).value == pytest.approx(exact, rel=0.01)
    assert of_profile(X, without_form(X, z, "line")).value > 5 * exact


def test_sigma_of_a_path_covers_the_ra_of_its_surface():
    """Gaussian heights of correlation length 10 um: Ra = s sqrt(2/pi) of the surface.

    Five lengths of 40 correlation lengths each; 300 paths: 60 to 76 %. Taking a line off costs
    1/200 of the variance, far below sigma.
    """
    rng = np.random.default_rng(8)
    kernel = np.exp(-(np.linspace(-4e-5, 4e-5, 81) ** 2) / 1e-5**2)
    kernel /= math.sqrt(kernel @ kernel)
    covered = 0
    for _ in range(300):
        z = 1e-6 * np.convolve(rng.normal(size=len(X) + 80), kernel, "valid")
        one = of_profile(X, without_form(X, z, "line"))
        covered += abs(one.value - 1e-6 * math.sqrt(2 / math.pi)) <= one.sigma
    assert 0.60 <= covered / 300 <= 0.76


def test_paths_by_particle_and_in_any_order(tmp_path):
    """Two particles of two paths each in one table: trials by path, groups by particle."""
    x = np.tile(X[::-1], 4)
    particle = np.repeat(["smooth", "rough"], 2 * len(X))
    path = np.repeat([1, 2, 1, 2], len(X))
    z = np.where(particle == "smooth", 1.0, 9.0) * np.sin(2 * np.pi * x / 1e-4)
    table = write(tmp_path / "p.csv", "x_mm;z_um;particle;path", [1e3 * x, z, particle, path])
    found = calibrate("roughness", table, "--trial", "path", "--group", "particle", "--json").json
    groups = found["ra_m"]["groups"]
    assert groups["smooth"]["value"] == pytest.approx(2e-6 / math.pi, rel=0.01)
    assert groups["rough"]["value"] == pytest.approx(18e-6 / math.pi, rel=0.01)
    assert [one["trials"] for one in groups.values()] == [2, 2]


@pytest.mark.parametrize(
    ("columns", "line"),
    [
        ([[0, 1, 2], [0, 1, 2]], "3 points of a profile: at least 50"),
        ([[1] * 60, [1] * 60], "no two at the same x"),
    ],
)
def test_what_is_no_profile_is_one_line(tmp_path, columns, line):
    result = calibrate("roughness", write(tmp_path / "t.csv", "x_mm;z_um", columns))
    assert result.code == 2
    assert line in result.err
