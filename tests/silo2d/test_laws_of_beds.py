"""Cohesion and measured curves of force: single contacts in closed form, and what is refused."""

import math

import numpy as np
import pytest
from refusals import assert_refuses
from scenes import (
    ELASTIC,
    LEVEL,
    SURFACE_DENSITY,
    G,
    launch,
    mass,
    position,
    simulation_of,
    velocity,
    wall,
)

from granulab.contact.laws import normal_energy, normal_force, slip_limit
from silo2d.case.case import SiloCase
from silo2d.case.shape import disc
from silo2d.engine.beds.laws import CohesiveLaw, CurveLaw, elastic_force

R, PULL, LENGTH = 5e-3, 3.0, 0.12
BASE = ELASTIC._replace(kn=1e6, kt=1e6)
COHESIVE = CohesiveLaw(*BASE, PULL)
STEP = 1e-6


def on_wall(law, overlap, upside_down=False, **settings):
    """A disc under or over a level wall, with an overlap; one contact."""
    height = (R - overlap) * (-1 if upside_down else 1)
    return simulation_of(
        [disc("a", 2 * R)], [(0.0, LEVEL + height, 0.0)], walls=[wall(math.pi * upside_down)],
        law=law, time_step=STEP, **settings,
    )  # fmt: skip


def test_a_cohesive_contact_rests_at_the_overlap_of_its_pull():
    """d = c/kn without load: force and velocity stay zero, to rounding."""
    sim = on_wall(COHESIVE, PULL / BASE.kn)
    sim.run(1000)
    assert position(sim)[1] == pytest.approx(LEVEL + R - PULL / BASE.kn, abs=1e-15)


@pytest.mark.parametrize("part", [0.99, 1.01])
def test_a_contact_takes_a_pull_up_to_its_cohesion(part):
    """A disc that hangs on a wall above it, damped: it stays with m g < c, and falls beyond."""
    weight = SURFACE_DENSITY * math.pi * R**2 * G
    law = CohesiveLaw(*BASE._replace(gamma_n=5000.0), weight / part)
    sim = on_wall(law, (weight / part - weight) / BASE.kn if part < 1 else 0.0,
                  upside_down=True, gravity=G)  # fmt: skip
    sim.run(20_000)
    assert (len(sim.contacts()["overlap"]) == 1) == (part < 1)


@pytest.mark.parametrize("part", [0.98, 1.02])
def test_work_of_pulling_off_is_the_square_of_the_pull(part):
    """From rest at d = c/kn it takes c^2/(2 kn) to part; the step leaves (w0 dt)^2/8 of that."""
    sim = on_wall(COHESIVE, PULL / BASE.kn)
    launch(sim, vy=math.sqrt(part * PULL**2 / BASE.kn / mass(sim)))
    sim.run(4000)
    assert (velocity(sim)[1] > 0 and not len(sim.contacts()["overlap"])) == (part > 1)


def test_friction_of_a_cohesive_contact_is_that_of_its_elastic_force():
    """At no load the slip limit is mu c: it holds a tangential force of less than that."""
    law = CohesiveLaw(*BASE._replace(mu=0.5, gamma_n=2000.0, gamma_t=2000.0), PULL)
    for part, holds in ((0.9, True), (1.1, False)):
        # A wall that stands upright: gravity is tangential, and 0.5 c of it just holds.
        gravity = part * 0.5 * PULL / (SURFACE_DENSITY * math.pi * R**2)
        block = simulation_of(
            [disc("a", 2 * R)], [(-(R - PULL / BASE.kn), LEVEL + 0.1, 0.0)],
            walls=[wall(math.pi / 2)], law=law, time_step=STEP, gravity=gravity,
        )  # fmt: skip
        block.world.bodies.row[0, 14] = 0.0  # it cannot rotate
        block.run(50_000)
        assert (abs(velocity(block)[1]) < 1e-3) == holds


def curve(overlap, force):
    even = np.linspace(0.0, overlap[-1], 501)
    found = np.interp(even, overlap, force)
    energy = np.append(0.0, np.cumsum(0.5 * even[1] * (found[1:] + found[:-1])))
    return CurveLaw(*BASE, even[1], found, energy)


def test_the_energy_of_a_curve_is_the_integral_of_its_force():
    """Both straight and, in between, quadratic: exact, also beyond the last point."""
    law = curve(np.array([0.0, 1e-5, 3e-5]), np.array([0.0, 20.0, 100.0]))
    law = law._replace(mu=0.4)
    for overlap, force, energy in ((5e-6, 10.0, 25e-6), (2e-5, 60.0, 5e-4), (4e-5, 140.0, 25e-4)):
        assert normal_force(law, 1.0, overlap, 0.0) == pytest.approx((force, 0.0), rel=1e-9)
        # 500 points have the bend between two of them: off by less than a spacing squared.
        assert normal_energy(law, overlap) == pytest.approx(energy, rel=1e-4)
        assert slip_limit(law, overlap) == pytest.approx(law.mu / law.kt * force, rel=1e-9)
    assert normal_force(law, 0.0, 0.0, 1.0) == (0.0, 0.0)  # of a pair that does not touch


@pytest.mark.validation  # compiles the kernels for the law
def test_a_straight_curve_is_the_linear_law():
    line = curve(np.array([0.0, 1e-4]), np.array([0.0, 1e-4 * BASE.kn]))
    found = []
    for law in (line, BASE):
        sim = on_wall(law, -1e-6)
        launch(sim, vy=-0.5)
        sim.run(300)
        found.append(position(sim)[1])
    assert found[0] == pytest.approx(found[1], rel=1e-12)


@pytest.mark.validation
def test_the_deepest_overlap_is_where_the_curve_has_taken_the_energy():
    """F = a d^2: a d^3/3 = m v^2/2.

    Up to there the curve has 36 straight parts, which take (1/36)^2/2 of the energy too much: a
    third of that, 1.3e-4, in the depth; the step, 1/100 of the contact's duration, as much again.
    """
    overlap = np.linspace(0.0, 2e-4, 401)
    law = curve(overlap, 1e11 * overlap**2)
    sim = on_wall(law, -1e-9)
    launch(sim, vy=-0.3)
    deepest, heights = (1.5 * mass(sim) * 0.3**2 / 1e11) ** (1 / 3), []
    for _ in range(1500):
        sim.run(1)
        heights.append(position(sim)[1])
    assert LEVEL + R - min(heights) == pytest.approx(deepest, rel=5e-4)
    assert velocity(sim)[1] == pytest.approx(0.3, rel=1e-4)  # elastic


def test_a_case_takes_its_curve_along(tmp_path):
    """The stiffest part decides on the step; the run folder's copy gives the same run."""
    (tmp_path / "curve.csv").write_text("overlap,force\n0.01 mm,50 N\n0.02 mm,150 N\n")
    (tmp_path / "a.toml").write_text(
        'schema = 1\n[silo]\npreset = "A4"\n[law]\nkn_curve = "curve.csv"\n'
    )
    case = SiloCase.load(tmp_path / "a.toml")
    assert case.particle_law.kn == pytest.approx(1e7)
    assert case.particle_law.energy[-1] == pytest.approx(0.25e-3 + 1e-3, rel=1e-5)
    copy = tmp_path / "run"
    copy.mkdir()
    for name, text in {**case.files, "case.toml": case.to_toml()}.items():
        (copy / name).write_text(text)
    again = SiloCase.load(copy / "case.toml")
    assert again.particle_law.force.tolist() == case.particle_law.force.tolist()


def test_cohesion_acts_over_the_length_of_the_prisms():
    case = SiloCase.load("A4", {"law.cohesion": "5 N/m"})
    assert case.particle_law.pull == pytest.approx(5 * LENGTH)
    assert case.label == "A4 (changed)"


def test_a_curve_keeps_its_foot(tmp_path):
    """Points a thousandth of the last and nearer: their forces within a hundredth."""
    foot = [(1e-6, 1.0), (2e-6, 4.0), (5e-6, 25.0), (1e-3, 2e4)]
    rows = "".join(f"{d} m,{f} N\n" for d, f in foot)
    (tmp_path / "curve.csv").write_text(f"overlap,force\n{rows}")
    law = SiloCase.load("A4", {"law.kn_curve": str(tmp_path / "curve.csv")}).wall_law
    for overlap, force in foot:
        assert elastic_force(law, overlap) == pytest.approx(force, rel=0.01)


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ("1e-4 mm,50 N\n10 mm,1e9 N\n", ["overlap = 0.0001 mm", "10 mm", "end the curve before"]),
        ("0.01 mm,5e-3 N\n0.02 mm,0.01 N\n", ["kn_curve: too soft", "J at an overlap of 1 mm"]),
        ("0.5 mm,10 N\n1 mm,1e3 N\n", ["kn_curve: too soft", "N at an overlap of 0.1 mm"]),
        ("0.02 mm,50 N\n0.01 mm,60 N\n", ["must rise"]),
        ("0.01 mm,50 N\n", ["two at least"]),
        ("0.01 mm,50\n0.02 mm,90\n", ["force = '50'", "unit is missing"]),
        (None, ["curve.csv", "no such file"]),
        ("0.01 mm,\xb5 N\n", ["curve.csv", "no CSV table"]),  # written as Latin-1
    ],
)
def test_a_curve_that_cannot_be(rows, words, tmp_path):
    if rows:
        (tmp_path / "curve.csv").write_text(f"overlap,force\n{rows}", "latin-1")
    changes = {"law.kn_curve": str(tmp_path / "curve.csv")}
    assert_refuses(words, SiloCase.load, "A4", changes)


def test_a_table_without_a_header_is_not_read_without_its_first_row(tmp_path):
    (tmp_path / "curve.csv").write_text("0.01 mm,50 N\n0.02 mm,150 N\n0.03 mm,260 N\n")
    changes = {"law.kn_curve": str(tmp_path / "curve.csv")}
    assert_refuses(["a line 'overlap,force' first"], SiloCase.load, "A4", changes)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"law.cohesion": "1e5 N/m"}, ["cohesion pulls particles", "a tenth of the spheroradius"]),
        ({"law.cohesion": "5 N"}, ["[law] cohesion = '5 N'", "unit is wrong"]),
        ({"law.cohesion": "-5 N/m"}, ["[law] cohesion", "greater than 0"]),
        ({"law.cohesion": "5 N/m", "disorder.per": "pair"}, ["linear law", "[law] cohesion"]),
        ({"law.cohesion": "5 N/m", "run.engine": "pymunk"}, ["[law] cohesion", "'dem'"]),
        ({"law.kn_curve": "a.csv", "law.kn": "1e4 N/mm"}, ["kn_curve does not go with kn"]),
    ],
)
def test_a_law_that_cannot_be(changes, words):
    assert_refuses(["A4", *words], SiloCase.load, "A4", changes)
