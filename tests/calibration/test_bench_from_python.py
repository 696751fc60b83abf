"""Functions of calibration's own name: the numbers of the commands, as results that show them."""

import json
from functools import partial

import numpy as np
import pytest
from bench_calls import write
from calibrating import calibrate

import calibration
from granulab.contact.files.datafile import data_root
from granulab.errors import InputError

WOOD = data_root().parent / "docs" / "examples" / "wood"
MARKERS = data_root() / "published" / "interface_markers.csv"
CALLS = {
    "density": (
        partial(calibration.measure_density, WOOD / "weighed.csv",
                instruments={"mass": "0.01 g"}),
        ["density", WOOD / "weighed.csv", "--instrument", "mass=0.01 g"],
    ),
    "incline": (
        partial(calibration.measure_incline, [WOOD / "tilt_wood.csv"], group="pairing",
                instruments={"angle": "0.2 deg"}),
        ["incline", WOOD / "tilt_wood.csv", "--group", "pairing", "--instrument", "angle=0.2 deg"],
    ),
    "slide": (
        partial(calibration.measure_slide, WOOD / "slide.csv",
                constants=["incline=30 deg +- 0.5 deg"]),
        ["slide", WOOD / "slide.csv", "--constant", "incline=30 deg +- 0.5 deg"],
    ),
    "compression": (
        partial(calibration.measure_compression, constants={
            "modulus": "242 MPa +- 15 %", "contact_area": "1200 mm2", "contact_length": "20 mm"}),
        ["compression", "--constant", "modulus=242 MPa +- 15 %", "--constant",
         "contact_area=1200 mm2", "--constant", "contact_length=20 mm"],
    ),
    "interface": (
        partial(calibration.measure_interface, MARKERS, readings={"dx_t": "0.003 mm"}),
        ["interface", MARKERS, "--reading", "dx_t=0.003 mm"],
    ),
    "damping": (
        partial(calibration.damping, restitution="0.53 +- 0.02", kn="1e4 N/mm", mass="10.8 g",
                wall=True),
        ["damping", "--restitution", "0.53 +- 0.02", "--kn", "1e4 N/mm", "--mass", "10.8 g",
         "--wall"],
    ),
    "report": (partial(calibration.report, "wood"), ["report", "wood"]),
    "pendulum": (
        partial(calibration.measure_pendulum, data_root() / "media" / "pendulum.mp4"),
        ["pendulum", data_root() / "media" / "pendulum.mp4"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CALLS)
def test_a_function_has_the_numbers_of_its_command_and_shows_its_text(name):
    """To the bit: the command calls the function. Its files come in other keys, and no others."""
    call, command = CALLS[name]
    result = call()
    said = calibrate(*command, "--json").json
    written = {key: value for key, value in said.items() if key in result.to_dict()}
    assert written == json.loads(json.dumps(result.to_dict()))
    assert all(said[key] is None for key in said.keys() - written)
    assert repr(result) == calibrate(*command).out.rstrip("\n")


def test_heights_of_a_table_give_the_restitution_that_they_were_made_from(tmp_path):
    """e = sqrt(H1/H0) (eq. 3.5): 0.6 of 100 mm and 36 mm, to round-off."""
    drops = write(tmp_path / "drops.csv", "H0_mm;H1_mm", [[100.0, 100.0], [36.0, 36.0]])
    found = calibration.measure_heights(drops, readings={"h1": "1 mm"})
    (restitution,) = found.quantities
    assert restitution.pooled.all.value == pytest.approx(0.6, rel=1e-14)
    said = calibrate("heights", drops, "--reading", "h1=1 mm", "--json").json
    assert found.to_dict() | {"sheet": None} == said


def test_roughness_of_a_triangle_is_half_its_height(tmp_path):
    """|z| of a zigzag from -1 to 1 mm is 1/2 mm in the mean (thesis, eq. 7.1), to round-off."""
    x = np.arange(101) / 25  # the corners, at 1 and 3 mm, and the zeros are among the points
    z = np.interp(x, [0, 1, 3, 4], [0, 1, -1, 0])
    profile = write(tmp_path / "profile.csv", "x_mm;z_mm", [x.tolist(), z.tolist()])
    (found,) = calibration.measure_roughness(profile, form="mean").quantities
    assert found.pooled.all.value == pytest.approx(0.5e-3, rel=1e-12)


def test_a_function_refuses_an_input_that_its_method_does_not_know():
    with pytest.raises(InputError, match="no input 'weight'"):
        calibration.measure_density(WOOD / "weighed.csv", instruments={"weight": "1 g"})
