"""Harmonic balance with a field: closed forms, all solutions, jumps, several modes, refusals."""

import math
from dataclasses import replace

import numpy as np
import pytest
from analytic import harmonic_motion
from hypothesis import given
from hypothesis import strategies as st
from refusals import assert_refuses

from damper3d.case.case import DamperCase
from damper3d.case.parts import GRAVITY
from damper3d.studies.field.balance import respond, spaced, swept, with_peaks
from damper3d.studies.field.origin import check_origin, head
from damper3d.studies.field.report import in_words, of_response
from damper3d.studies.field.structure import Structure, structure_of
from damper3d.studies.field.table import Field

MASS, FREQUENCY, RATIO, FORCE = 2.0, 40.0, 0.005, 3.0
OMEGA0 = 2 * math.pi * FREQUENCY
STIFFNESS, DASHPOT = MASS * OMEGA0**2, 2 * RATIO * OMEGA0 * MASS
HOST = Structure.single(MASS, FREQUENCY, RATIO, force=FORCE)
TABLE = (20.0, 35.0, 40.0, 45.0, 80.0)  # Hz
ROUNDING = 1e-11


def constant(mass_of_frequency, gammas=(0.5, 3.0, 50.0)):
    """A field whose mass does not depend on the amplitude."""
    f, g = (axis.ravel() for axis in np.meshgrid(TABLE, gammas))
    return Field.of(f, g, [mass_of_frequency(x) for x in f], 0.1)


def test_a_rigid_mass_shifts_the_resonance_exactly():
    frequency = spaced(HOST, 30.0, 60.0)
    found = respond(HOST, constant(lambda f: 0.1), frequency)
    w = 2 * math.pi * frequency
    wanted = FORCE / np.abs(STIFFNESS - w**2 * (MASS + 0.1) + 1j * w * DASHPOT)
    assert found.count.tolist() == [[1] * len(frequency)]
    assert found.amplitude[0, :, 0] == pytest.approx(wanted, rel=ROUNDING)
    assert found.bare[0] == pytest.approx(
        FORCE / np.abs(STIFFNESS - w**2 * MASS + 1j * w * DASHPOT), rel=ROUNDING
    )


@pytest.mark.parametrize("ratio", [0.005, 1e-3, 1e-4, 1e-6])
def test_the_peak_of_a_lightly_damped_structure_is_met_beside_its_own_frequency(ratio):
    """F/(2 zeta' k sqrt(1 - zeta'^2)) of M + m, zeta' = zeta sqrt(M/(M + m)); to 0.2 %, see spaced.

    And so are the ends of its interval.
    """
    host = Structure.single(MASS, FREQUENCY, ratio, force=FORCE)
    wide = 0.02 * np.ones(2 * len(TABLE))
    field = replace(constant(lambda f: 0.1, (0.5, 1e9)),
                    in_phase_half_width=wide, out_of_phase_half_width=0.0 * wide)  # fmt: skip
    found = with_peaks(lambda f: [respond(host, field, f)], spaced(host, 30.0, 60.0), ratio)
    (level,) = of_response(host, field, found[0])

    def peak(mass):
        own = ratio * math.sqrt(MASS / (MASS + mass))
        return FORCE / (2 * own * STIFFNESS * math.sqrt(1 - own**2))

    assert level["peak_amplitude_m"] == pytest.approx(peak(0.1), rel=2e-3)
    assert level["peak_interval_m"] == pytest.approx([peak(0.08), peak(0.12)], rel=2e-3)


def test_a_dashpot_damps_exactly():
    c = 8.0
    found = respond(HOST, constant(lambda f: -1j * c / (2 * math.pi * f)), TABLE)
    w = 2 * math.pi * np.array(TABLE)
    wanted = FORCE / np.abs(STIFFNESS - w**2 * MASS + 1j * w * (DASHPOT + c))
    assert found.amplitude[0, :, 0] == pytest.approx(wanted, rel=ROUNDING)


@pytest.mark.parametrize("name", ["base_displacement", "base_acceleration"])
def test_under_base_motion_the_displacement_is_absolute(name):
    """(k + i w c) B over (k - w^2 (M + m) + i w c); of an acceleration a, B = a/w^2."""
    host = Structure.single(MASS, FREQUENCY, RATIO, **{name: 1e-4})
    w = 2 * math.pi * np.array(TABLE)
    base = 1e-4 / (w**2 if name == "base_acceleration" else 1.0)
    wanted = base * np.abs(
        (STIFFNESS + 1j * w * DASHPOT) / (STIFFNESS - w**2 * (MASS + 0.1) + 1j * w * DASHPOT)
    )
    found = respond(host, constant(lambda f: 0.1), TABLE)
    assert found.amplitude[0, :, 0] == pytest.approx(wanted, rel=ROUNDING)


def test_on_a_base_of_constant_acceleration_the_peak_is_that_of_the_transmissibility():
    """|X|/B of M + m at its resonance, sqrt(1 + 4 zeta'^2)/(2 zeta' sqrt(...)) to 2 zeta'^2.

    Its base moves by a/w^2, more at 20 Hz than anything at 40 Hz where the damping is 30 %.
    """
    host = Structure.single(MASS, FREQUENCY, 0.3, base_acceleration=1.0)
    found = respond(host, constant(lambda f: 0.1), spaced(host, 20.0, 80.0))
    (level,) = of_response(host, constant(lambda f: 0.1), found)

    def transmissibility(mass):
        w = 2 * math.pi * np.linspace(20.0, 80.0, 20_001)
        dashpot = 0.3 / RATIO * DASHPOT
        pulled = STIFFNESS + 1j * w * dashpot
        return np.abs(pulled / (STIFFNESS - w**2 * (MASS + mass) + 1j * w * dashpot)).max()

    assert level["reduction_of"] == "transmissibility"
    assert level["reduction"] == pytest.approx(
        transmissibility(0.1) / transmissibility(0.0), rel=1e-4
    )
    assert 30.0 < level["peak_frequency_hz"] < 40.0
    assert level["largest_at_end"] == []


def test_a_largest_response_at_the_end_of_the_frequencies_is_no_peak_and_is_said_so():
    """The structure's peak, with 5 % of mass riding, lies at 39.0 Hz: below 39.5 to 60 Hz."""
    field = constant(lambda f: 0.1)
    ends = {}
    for low in (39.5, 30.0):
        (level,) = of_response(HOST, field, respond(HOST, field, spaced(HOST, low, 60.0)))
        ends[low] = level["largest_at_end"]
        said = "warning: largest response with the bed at an end of 39.5 to 60 Hz"
        assert (said in in_words([level])) == (low == 39.5)
    assert ends == {39.5: ["bed"], 30.0: []}


def test_two_modes_and_a_rigid_mass_are_those_of_the_matrices():
    """Two masses on springs, the bed's mass on the second, the force on the first."""
    m, k = np.diag([2.0, 1.0]), np.array([[3e5, -1e5], [-1e5, 1e5]])
    squares, shapes = np.linalg.eigh(np.diag(m.diagonal() ** -0.5) @ k @ np.diag(
        m.diagonal() ** -0.5))  # fmt: skip
    shapes = np.diag(m.diagonal() ** -0.5) @ shapes
    none = np.zeros(2)
    host = Structure(np.sqrt(squares), none, shapes[1], shapes[0], none, force=1.0)
    found = respond(host, constant(lambda f: 0.1, (1e-3, 1e3)), TABLE)
    for f, amplitude in zip(TABLE, found.amplitude[0, :, 0], strict=True):
        wanted = abs(harmonic_motion(k, m + np.diag([0.0, 0.1]), [1.0, 0.0], 2 * math.pi * f)[1])
        assert amplitude == pytest.approx(wanted, rel=1e-9)


def test_an_undamped_host_at_its_own_frequency_moves_as_the_bed_lets_it():
    """The springs take the inertia of the host, so the bed's mass alone holds F = w^2 m A."""
    host = Structure.single(MASS, FREQUENCY, 0.0, force=FORCE)
    found = respond(host, constant(lambda f: 0.1), [FREQUENCY])
    assert found.bare.tolist() == [[math.inf]]
    assert found.amplitude[0, 0, 0] == pytest.approx(FORCE / (OMEGA0**2 * 0.1), rel=1e-9)


def zigzag(left, unit=1e-3):
    """A field that makes the balance's left side these values at 1, 2, ... mm, linear between.

    At FREQUENCY of an undamped host: w^2 m A = -left.
    """
    amplitude = unit * np.arange(1, len(left) + 1)
    gamma = amplitude * OMEGA0**2 / GRAVITY
    mass = -np.asarray(left) / (OMEGA0**2 * amplitude)
    return Field.of([FREQUENCY] * len(left), gamma, mass, 0.1)


def undamped(force):
    return Structure.single(MASS, FREQUENCY, 0.0, force=force)


def test_all_three_solutions_of_a_bent_resonance_are_found_and_the_middle_is_unstable():
    """Left side 3, 1, 4 N at 1, 2, 3 mm; at 2 N: 2/3, 3/2 and 7/3 mm."""
    found = respond(undamped(2.0), zigzag([3.0, 1.0, 4.0]), [FREQUENCY], [0.25, 1.0, 1.75, 3.0])
    assert found.amplitude[1, 0] == pytest.approx([2e-3 / 3, 1.5e-3, 7e-3 / 3])
    assert np.isfinite(found.stable[1, 0]).tolist() == [True, False, True]
    assert found.count[:, 0].tolist() == [1, 3, 1, 0]
    assert found.beyond[:, 0].tolist() == [False, False, False, True]


@given(
    left=st.lists(st.complex_numbers(min_magnitude=0.1, max_magnitude=5.0), min_size=2, max_size=8),
    force=st.floats(0.05, 6.0),
)
def test_no_solution_is_missed(left, force):
    """Against a scan of |left side| - F along every interval, in which no pair is closer."""
    found = respond(undamped(force), zigzag(left), [FREQUENCY])
    knots = np.concatenate([[0.0], np.asarray(left)])
    part = np.linspace(0.0, 1.0, 4001)
    values = np.abs(knots[:-1, None] * (1 - part) + knots[1:, None] * part)
    above = values >= force
    close = np.abs(values - force).min() < 1e-6  # a turning point between two places of the scan
    scanned = int((above[:, 1:] != above[:, :-1]).sum())
    assert found.count[0, 0] == scanned or close
    amplitudes = found.amplitude[0, 0][: found.count[0, 0]]
    assert (np.diff(amplitudes) >= 0).all()
    reached = np.abs(np.interp(amplitudes, 1e-3 * np.arange(len(knots)), knots))
    assert reached == pytest.approx(force, rel=1e-6)


def softening():
    """A bed whose mass falls with the amplitude: the resonance bends to higher frequencies.

    It is bent by 3 % at 30 Gamma. A shift that goes with A folds from 2.6 times the damping ratio
    on: the least of 1/(a^2 sqrt(1 - a^2)).
    """
    gammas = np.concatenate([[0.1], np.linspace(0.5, 40.0, 80)])
    f, g = (axis.ravel() for axis in np.meshgrid((30.0, 60.0), gammas))
    return Field.of(f, g, 0.2 - 0.004 * g - 0.001j, 0.2)


def test_a_swept_sine_jumps_down_going_up_and_up_going_down():
    host = Structure.single(MASS, FREQUENCY, RATIO, force=1.0)
    frequency = spaced(host, 30.0, 50.0)
    found = respond(host, softening(), frequency, [1.0, 6.0])
    assert found.count[0].max() == 1
    assert swept(found, 0)[1] == swept(found, 0, down=True)[1] == []
    assert found.count[1].max() == 3
    assert not found.beyond.any()
    (up,), (down,) = (swept(found, 1, down)[1] for down in (False, True))
    assert up.after < up.before
    assert down.after > down.before
    bent = frequency[found.count[1] == 3]  # both jumps are where the number of solutions changes
    step = frequency[1] / frequency[0]
    assert up.frequency == pytest.approx(bent[-1], rel=step - 1)
    assert down.frequency == pytest.approx(bent[0], rel=step - 1)
    peak = found.largest(1)
    assert up.before <= peak[1] < 1.02 * up.before  # the fold is a little beyond the peak


def test_a_response_beyond_the_field_has_no_peak_and_says_where():
    found = respond(HOST, constant(lambda f: 0.1, (0.5, 1.0)), spaced(HOST, 30.0, 60.0))
    (level,) = of_response(HOST, constant(lambda f: 0.1, (0.5, 1.0)), found)
    assert level["peak_amplitude_m"] is None
    low, high = level["beyond_field_hz"]
    assert low < FREQUENCY / math.sqrt(1 + 0.1 / MASS) < high


def test_the_interval_of_the_peak_is_that_of_the_mass():
    """A half width of m'' moves the damped peak F/(w (c + w m'')) by what the formula says."""
    plain = constant(lambda f: 0.1 - 0.05j)
    width = np.full(len(plain.gamma), 0.01)
    field = Field(plain.frequency, plain.gamma, plain.in_phase, plain.out_of_phase, 0 * width,
                  width, plain.seeds, plain.bed_mass)  # fmt: skip
    found = respond(HOST, field, spaced(HOST, 36.0, 42.0))
    (level,) = of_response(HOST, field, found)
    w = 2 * math.pi * level["peak_frequency_hz"]
    wanted = [FORCE / (w * (DASHPOT + w * loss)) for loss in (0.06, 0.05, 0.04)]
    low, high = level["peak_interval_m"]
    assert [low, level["peak_amplitude_m"], high] == pytest.approx(wanted, rel=5e-3)


@pytest.mark.parametrize(("gamma", "is_known"), [(0.5, False), (3.0, False), (50.0, True)])
def test_a_peak_has_an_interval_where_all_points_have_one_that_it_comes_of(gamma, is_known):
    """It lies at 39 Hz and a Gamma of 1.7 with a level of 0.4, so that the points of Gamma 0.5
    and 3 at 35 and 40 Hz make its mass; those of Gamma 50 do not.
    """
    plain = constant(lambda f: 0.1 - 0.05j)
    width = np.where(plain.gamma == gamma, math.nan, 0.01)
    field = replace(plain, in_phase_half_width=width, out_of_phase_half_width=width)
    found = respond(HOST, field, spaced(HOST, 36.0, 42.0), (0.4,))
    (level,) = of_response(HOST, field, found)
    motion = level["peak_amplitude_m"] * (2 * math.pi * level["peak_frequency_hz"]) ** 2
    assert 0.5 < motion / GRAVITY < 3.0
    assert (level["peak_interval_m"] is not None) == is_known
    assert field.has_interval(35.0, 4.0 * GRAVITY / (2 * math.pi * 35.0) ** 2) == (gamma == 0.5)


HOSTED = {"host.mass": "2 kg", "host.frequency": 40.0, "host.damping_ratio": 0.005}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({}, ["it has no [host]", "one of force"]),
        ({**HOSTED, "host.start_displacement": "1 mm"}, ["its host is let go", "one of force"]),
    ],
)
def test_cases_without_a_steady_response_are_refused_in_one_line(changes, words):
    assert_refuses(words, structure_of, DamperCase.load("thesis", changes))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({}, None),
        ({"particles.count": 358, "motion.orientation": "vertical"}, None),
        ({"motion.orientation": "horizontal"}, ["field of vertical", "gives horizontal"]),
        ({"motion.gravity": [1, 0, 0]}, ["field of vertical", "gives horizontal", "[motion]"]),
        ({"particles.count": 300}, ["field of 358 particles sphere:5mm", "gives 300 particles"]),
        (
            {"particles.count": 358, "law.density": "8 g/cm3"},
            ["0.0278", "kg", "leave [particles] out"],
        ),
        ({"enclosure.height": "45 mm"}, ["a height of 40 mm", "gives 45 mm"]),
        ({"enclosure.diameter": "80 mm"}, ["0.04 m", "gives", "0.08 m", "leave [enclosure] out"]),
        ({"enclosure.diameter": "40 mm"}, None),
        ({"law.restitution": 0.3}, ["restitution 0.86", "gives", "restitution 0.3"]),
        ({"law.friction": 0.05}, ["mu 0.05", "leave [law] out"]),
        ({"particles.material": "acrylic"}, None),
        ({"law.yielding": True}, ["yielding true", "leave [law] out"]),
        ({"law.contact_end": "force"}, ["contact_end force"]),
        ({"law.tangential": "force"}, ["tangential force"]),
        ({"law.wall_curvature": True}, ["wall_curvature true"]),
        ({"law.contact_end": "overlap", "law.contact_treatment": "deepest"}, None),  # spheres
        (
            {"law.rolling_friction": 0.1, "law.rolling_stiffness": "1e4 N/m"},
            ["rolling_friction 0.1; rolling_stiffness 10000.0"],
        ),
        ({"motion.gravity": [0, 0, 1]}, ["gravity 0 0 -9.81", "gravity 0 0 9.81", "[motion]"]),
        ({"motion.gravity": [0, 0, -1]}, None),
    ],
)
def test_a_field_of_another_bed_than_the_case_gives_is_refused(changes, words):
    """Of what the case leaves out, and of a table without a head, nothing is said."""
    lines = head(DamperCase.load("thesis"))
    case = DamperCase.load("thesis", {**HOSTED, "host.force": "1 N", **changes})
    if words is None:
        check_origin("field.csv", lines, case)
    else:
        assert_refuses(["field.csv", *words], check_origin, "field.csv", lines, case)
    check_origin("field.csv", (), case)


def test_a_field_of_another_multi_contact_model_is_refused():
    changes = {"particles.shape": "prolate:1.5"}
    lines = head(DamperCase.load("thesis", changes))
    case = DamperCase.load("thesis", {**changes, "law.contact_treatment": "scaled"})
    assert_refuses(["contact_treatment scaled"], check_origin, "field.csv", lines, case)


@pytest.mark.parametrize(
    ("key", "value"),
    [("force", "3 N"), ("base_displacement", "1 mm"), ("base_acceleration", "0.1 g")],
)
def test_a_host_and_a_table_of_its_one_mode_are_the_same(tmp_path, key, value):
    """From cases, at frequencies that are not the motion's own."""
    (tmp_path / "modes.csv").write_text(
        "frequency [Hz],damping_ratio,shape [kg^-0.5],participation [kg^0.5]\n"
        "40,0.005,0.7071067811865476,1.414213562373095\n", "utf-8",
    )  # fmt: skip
    ways = ({"host.modes": str(tmp_path / "modes.csv")}, HOSTED)
    found = [
        respond(
            structure_of(DamperCase.load("thesis", {**way, f"host.{key}": value})),
            softening(), [35.0, 45.0],
        ).amplitude
        for way in ways
    ]  # fmt: skip
    assert found[0] == pytest.approx(found[1], rel=1e-12)
