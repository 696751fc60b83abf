"""Tables and pictures that no laboratory makes: one line that names the field and a cure."""

import cv2
import numpy as np
import pytest
from bench_calls import write
from calibrating import calibrate
from refusals import assert_refused

TIME = [0.05 * k for k in range(40)]
PATH = [0.01 * k for k in range(200)]
LOAD = [25.0 * k for k in range(40)] + [25.0 * (39 - k) for k in range(40)]
CURVE = "time [s];velocity [m/s]"
PROFILE = "x [mm];z [um]"
RECORD = "displacement [mm];load [N]"
SPECIMEN = ("--constant", "area=100 mm2", "--constant", "length=10 mm")

TABLES = {
    "slide at rest": ("slide", CURVE, [TIME, [0.0] * 40], (), "gamma_t"),
    "slide at one speed": ("slide", CURVE, [TIME, [0.4] * 40], (), "gamma_t"),
    "slide, a spike": ("slide", CURVE, [TIME, [0.0] * 39 + [1e9]], (), "measure longer"),
    "slide at one time": ("slide", CURVE, [[1.0] * 40, TIME], (), "at unlike times"),
    "slide, no velocity": ("slide", CURVE, [TIME, [""] * 40], (), "no row"),
    "slide, huge": ("slide", CURVE, [TIME, [1e300] * 40], (), "velocity = 1e+300"),
    "roughness, huge": ("roughness", PROFILE, [PATH, [1e200] * 200], (), "z = 1e+194"),
    "roughness, one x": ("roughness", PROFILE, [[1.0] * 200, PATH], (), "no two at the same x"),
    "roughness, tiny": ("roughness", PROFILE, [[1e-320 * x for x in PATH], PATH], (), "line"),
    "compression, no load": ("compression", RECORD, [LOAD, [0.0] * 80], SPECIMEN, "least-cycle"),
    "compression, stiff": ("compression", RECORD, [[0.1] * 80, LOAD], SPECIMEN, "--range"),
    "compression, two rows": ("compression", RECORD, [[0, 1], [0, 1]], SPECIMEN, "least-cycle"),
    "compression, huge": (
        "compression", RECORD, [LOAD, [1e300 * v for v in LOAD]], SPECIMEN, "check the value",
    ),
    "incline, no row": ("incline", "angle_deg", [[]], (), "t.csv"),
    "incline, upright": ("incline", "angle_deg", [[20, 90]], (), "below 90 deg"),
    "density, no volume": ("density", "mass [g];volume [mm3]", [[1, 1], [900, 0]], (), "above 0"),
    "density, huge": ("density", "mass [g];diameter [mm]", [[1], [1e150]], (), "diameter = 1e+147"),
    "interface, no slip": (
        "interface", "dx_t [mm];dx_n [mm];sigma_t [MPa];sigma_n [MPa]", [[0], [1], [1], [1]], (),
        "dx_t = 0",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", TABLES)
def test_a_table_that_nothing_follows_from_is_refused(tmp_path, name):
    command, head, columns, options, words = TABLES[name]
    table = write(tmp_path / "t.csv", head, columns)
    assert_refused(calibrate(command, table, *options), words)


NOISE = np.random.default_rng(0).integers(0, 255, (64, 64)).astype(np.uint8)
OTHER = np.random.default_rng(1).integers(0, 255, (64, 64)).astype(np.uint8)
BLACK = np.zeros((64, 64), np.uint8)
PICTURES = {
    "one grey level": (BLACK, BLACK, (), "no texture"),
    "nothing found again": (NOISE, BLACK, (), "nothing is found"),
    "no flow of one grey level": (BLACK, BLACK, ("--method", "flow"), "nothing is found"),
    "too small for flow": (
        NOISE[:8, :8], NOISE[:8, :8], ("--method", "flow", "--window", 8), "method 'piv'",
    ),
    "black mask": (NOISE, OTHER, ("--mask", "black"), "leaves nothing to measure"),
    "scale beyond numbers": (NOISE, NOISE, ("--scale", "1e300 mm/px"), "check their units"),
}  # fmt: skip


@pytest.mark.parametrize("name", PICTURES)
def test_pictures_that_nothing_follows_from_are_refused(tmp_path, name):
    first, second, options, words = PICTURES[name]
    files = {"a": first, "b": second, "black": BLACK}
    for stem, picture in files.items():
        cv2.imwrite(str(tmp_path / f"{stem}.png"), picture)
    given = [tmp_path / "black.png" if word == "black" else word for word in options]
    assert_refused(calibrate("piv", tmp_path / "a.png", tmp_path / "b.png", *given), words)


def test_identical_pictures_have_not_moved(tmp_path):
    cv2.imwrite(str(tmp_path / "a.png"), NOISE)
    cv2.imwrite(str(tmp_path / "b.png"), NOISE)
    found = calibrate("piv", tmp_path / "a.png", tmp_path / "b.png", "--json").json
    assert abs(found["u_px"]["highest"]) < 1e-6
    assert found["sigma_px"]["largest"] < 1e-6
