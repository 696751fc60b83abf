"""Grooves between sub-spheres: the limits of eqs 5.18-5.20, and what `damper3d shape` reports."""

import json
import math

import numpy as np
import pytest
from click.testing import CliRunner

from damper3d.commands.shape import shape
from damper3d.shapes.particle import parse_particle
from damper3d.shapes.surfaces.grooves import (
    groove_depth,
    limit_of_ring,
    most_sub_spheres,
    speed_to_groove,
)
from damper3d.studies.single_contact import find
from granulab.contact.hertz import HertzLaw


@pytest.mark.parametrize("text", ["toroid:0.2", "toroid:0.05", "prolate:1.5", "prolate:3"])
def test_groove_is_where_the_union_of_the_spheres_is_highest(text):
    """The underside of the spheres along the line of their centres, -sqrt(R^2 - (x - x_i)^2) of the
    lowest one at each x; between neighbours its highest point is the groove's bottom.
    To the raster, 1e-3 of a spacing, whose square stands in the depth."""
    cluster = parse_particle(text)
    if cluster.arrangement == "ring":
        apart = np.linalg.norm(cluster.offsets[1] - cluster.offsets[0])
        places, radii = np.array([0.0, apart]), cluster.radii[:2]
    else:
        middle = len(cluster.radii) // 2
        places = cluster.offsets[middle : middle + 2, 0]
        radii = cluster.radii[middle : middle + 2]
    x = np.linspace(*places, 2001)
    below = np.sqrt((radii[:, None] ** 2 - (x - places[:, None]) ** 2).clip(0.0)).max(axis=0)
    assert groove_depth(cluster) == pytest.approx(radii[0] - below.min(), rel=2e-3)


def test_eq_5_19_is_the_groove_of_many_sub_spheres_and_eq_5_20_its_inverse():
    """Eq. 5.18 takes the chord 2 a sin(pi/n) for its arc 2 pi a/n: (pi/n)^2/3 too deep at most, to
    first order. Eq. 5.20 solves 5.19 for n."""
    a, b = 3e-3, 1.15e-3
    hole = (a - b) / (a + b)
    for n in (50, 100, 200):
        made = parse_particle(f"toroid:{hole!r}", sub_spheres=n)
        depth = groove_depth(made.scaled(b / made.radii[0]))
        printed = limit_of_ring(a, b, n)
        assert printed / depth - 1 == pytest.approx((math.pi / n) ** 2 / 3, rel=0.1)
        assert most_sub_spheres(a, b, printed) == pytest.approx(n, rel=1e-9)
    assert math.isnan(limit_of_ring(a, b, 8))  # eq. 4.27: they do not touch


def test_printed_limit_is_that_of_a_toroid_of_3_mm_outer_radius():
    """Sec. 5.4.4: "about 2.5e-3" for 50 sub-spheres, over the tube's diameter: 6.8e-3 follows if
    3 mm are a, as eq. 4.28 has it, and 2.6e-3 if they are a + b."""
    module = find("contact-limit")
    found = module.compute()
    numbers = found.numbers
    as_defined, as_printed = (
        numbers[key]["eq_5_19_over_diameter"]
        for key in ("toroid of 50", "toroid of 50, 3 mm taken as its outer radius")
    )
    assert as_defined == pytest.approx(6.8e-3, abs=5e-5)
    assert as_printed == pytest.approx(2.56e-3, abs=1e-5)
    ours = numbers["toroid of 50"]
    assert ours["sum_is_smooth_at_m"] < ours["groove_depth_m"] / 3  # the sum departs much earlier
    figure = module.draw(found)
    assert all(axes.lines and axes.get_xlabel() and axes.get_ylabel() for axes in figure.axes)


def test_speed_to_the_groove_by_the_energy_of_a_hertz_contact():
    """(1/2) m v^2 = (2/5) K d^2.5."""
    toroid = parse_particle("toroid:0.2")
    law = HertzLaw(2.55e9, 1.0, 0.0, 0.0, 0.0, math.inf, True, False)
    speed = speed_to_groove(toroid, law, 2e-4)
    held = 0.4 * 2.55e9 * math.sqrt(toroid.radii[0]) * groove_depth(toroid) ** 2.5
    assert 0.5 * 2e-4 * speed**2 == pytest.approx(held, rel=1e-12)
    assert speed_to_groove(parse_particle("sphere:5mm"), law, 2e-4) is None


def test_shape_reports_the_limit():
    def reported(*arguments):
        result = CliRunner().invoke(shape, [*arguments, "--no-figures", "--json"])
        return json.loads(result.stdout)

    ring = reported("--toroid", "0.2")
    assert ring["groove_depth_m"] == pytest.approx(8.11e-6, rel=1e-3)
    assert ring["speed_to_groove_m_s"] == pytest.approx(0.276, rel=5e-3)
    assert reported("--sphere", "5mm")["groove_depth_m"] is None
