"""Figures of the bench's methods show what was read and fitted; heads of machines are known."""

import math
from pathlib import Path

import numpy as np
import pytest
from bench_calls import write
from calibrating import calibrate

from calibration.bench.compression import INPUTS, stiffness
from calibration.bench.figure import draw
from calibration.bench.sections import Request

ROOT = Path(__file__).parents[2]
WOOD = ROOT / "docs" / "examples" / "wood"


@pytest.mark.parametrize(
    ("command", "table", "options"),
    [
        ("incline", "tilt_wood.csv", []),
        ("slide", "slide.csv", []),
        ("compression", "cubes.csv", ["--constant", "area=1 cm2", "--constant", "length=1 cm"]),
        ("density", "weighed.csv", []),
    ],
)
def test_every_method_draws_a_figure(tmp_path, command, table, options):
    found = calibrate(command, WOOD / table, *options, "--json", "-o", tmp_path).json
    sheet = Path(found["sheet"])
    assert sheet.parent == tmp_path
    assert sheet.read_bytes().startswith(b"\x89PNG")


def test_the_figure_holds_the_record_and_the_points_that_were_fitted(tmp_path):
    """Two cycles of 1 kN/mm, 1e6 N/m: 50 to 95 % of a fall of 100 N are the loads 50 to 95 N."""
    load = np.concatenate([np.linspace(0, 100, 50), np.linspace(100, 0, 50)] * 2)
    table = write(tmp_path / "t.csv", "displacement_mm;load_N", [load / 1e3, load])
    (found,) = stiffness([table], Request())
    figure = draw([found], "compression")
    (record, *fits) = figure.axes[0].lines
    np.testing.assert_allclose(record.get_ydata(), load)
    assert len(fits) == 2
    for fit in fits:
        assert 50 <= fit.get_ydata().min() < fit.get_ydata().max() <= 95
        np.testing.assert_allclose(fit.get_xdata() * 1e3, fit.get_ydata(), rtol=1e-12)


def test_a_figure_of_a_profile_is_in_units_that_people_read(tmp_path):
    x = np.linspace(0, 4e-3, 400)
    z = 2e-6 * np.sin(x / 1e-4)
    table = write(tmp_path / "t.csv", "Weg [m];Profil [m]", [x, z])
    found = calibrate("roughness", table, "--json", "-o", tmp_path).json
    assert found["ra_m"]["value"] == pytest.approx(4e-6 / math.pi, rel=0.02)  # of whole waves
    assert any("z is read from 'Profil'" in words for words in found["ra_m"]["remarks"])


@pytest.mark.parametrize("head", ["Extension [mm];Force [N]", "Standardweg [mm];Standardkraft [N]"])
def test_heads_of_testing_machines_are_known_and_said(tmp_path, head):
    load = np.concatenate([np.linspace(0, 100, 50), np.linspace(100, 0, 50)])
    table = write(tmp_path / "t.csv", head, [load / 1e3, load])
    found = calibrate("compression", table, "--json").json["unloading_stiffness_n_per_m"]
    assert found["value"] == pytest.approx(1e6, rel=1e-9)
    first = head.split(" ")[0]
    assert any(f"displacement is read from {first!r}" in words for words in found["remarks"])


def test_usual_heads_are_of_inputs_that_there_are():
    import importlib

    from calibration.bench.sections import _usual_heads
    from calibration.methods import METHODS

    modules = [importlib.import_module(f"calibration.bench.{name}") for name in METHODS]
    names = {one.name for module in modules for one in module.INPUTS}
    assert set(_usual_heads()) <= names
    assert INPUTS[0].name in names
