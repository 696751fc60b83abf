"""Loads on silos in closed form: Janssen, EN 1991-4:2006, Jenike; worked cases and limits."""

import math

import analytic
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from refusals import assert_refuses
from scipy.integrate import solve_ivp

from silo2d.loads import bottom, jenike, walls
from silo2d.loads.assess import Loads, closed_forms
from silo2d.loads.design import load_design
from silo2d.loads.janssen import janssen_stress
from silo2d.loads.solid import Values, characteristic, lateral_ratio_of, table_e1
from silo2d.loads.spec import commented_spec
from silo2d.loads.vessel import Vessel
from silo2d.loads.walls import Wall
from silo2d.view.loads.tables import bottom_parts, jenike_facts

DEG = math.pi / 180
CIRCULAR = Vessel("circular", 5.0, 5.0, 8.0)
WHEAT = """
schema = 1
[silo]
width = "5 m"
height = "15 m"
half_angle = "20 deg"
outlet = "0.6 m"
[solid]
name = "wheat"
"""


def wall(vessel, mu=0.4, ratio=0.5, repose=0.6, heap=True, gamma=9e3):
    """Loads on a vessel's walls."""
    highest = vessel.highest_contact(repose, heap)
    return Wall(vessel, Values(mu, ratio, 0.6), gamma, highest, repose)


@pytest.fixture
def wheat(tmp_path):
    path = tmp_path / "wheat.toml"
    path.write_text(WHEAT)
    return load_design(path)


# Walls


def test_worked_case_of_intermediate_slenderness():
    """gamma 16 kN/m3, d_c 5 m, K 0.450, mu 0.458, phi_r 36 deg, z 8 m: z_o 6.07 m, h_o 0.61 m,
    p_vf 69.3 kPa, as printed to three digits."""
    own = wall(CIRCULAR, 0.458, 0.450, 36 * DEG, gamma=16e3)
    assert CIRCULAR.slenderness_class == "intermediate"
    assert own.length == pytest.approx(6.07, rel=2e-3)
    assert own.highest == pytest.approx(0.61, rel=1e-2)
    assert float(own.vertical(np.array(8.0))) == pytest.approx(69.3e3, rel=2e-3)


def test_slender_pressure_is_janssens_and_saturates():
    """p_h = gamma A/(mu U) (1 - exp(-z/z_o)), whatever K far down; by the law written out."""
    vessel = Vessel("circular", 4.0, 4.0, 40.0)
    own, z = wall(vessel, 0.5, 0.45), np.linspace(0, 40, 9)
    expected = analytic.janssen_pressure(z, 9e3, 0.5, 0.45, math.pi * 4, math.pi * 4)
    np.testing.assert_allclose(own.horizontal(z), expected, rtol=1e-12)
    assert float(own.horizontal(np.array(1e4))) == pytest.approx(9e3 * 1.0 / 0.5, rel=1e-12)


@pytest.mark.parametrize("height", [4.0, 7.0, 20.0])
def test_frictionless_walls_carry_nothing(height):
    """mu -> 0: p_v = gamma z, p_h = K gamma z of a slender silo; small mu comes near it."""
    vessel, z = Vessel("circular", 5.0, 5.0, height), np.linspace(1.0, height, 5)
    none, little = wall(vessel, 0.0), wall(vessel, 1e-7)
    np.testing.assert_allclose(none.vertical(z), 9e3 * z, rtol=1e-12)
    np.testing.assert_allclose(little.horizontal(z), none.horizontal(z), rtol=1e-5)
    assert not none.carried(z).any()
    if vessel.slenderness_class == "slender":
        np.testing.assert_allclose(none.horizontal(z), 0.5 * 9e3 * z, rtol=1e-12)


def test_shallow_stress_is_hydrostatic_and_the_walls_come_with_the_square_of_depth():
    """Janssen: gamma z (1 - z/(2 z_o) + ...): to first order at z = z_o/1000 within 1e-6."""
    z_o, z = 2.0 / (2 * 0.2), 5e-3
    expected = 9e3 * z * (1 - z / (2 * z_o))
    assert float(janssen_stress(z, 9e3, 0.2, 2.0)) == pytest.approx(expected, rel=1e-6)


@given(
    slenderness=st.floats(0.45, 6.0), mu=st.floats(0.01, 0.8), ratio=st.floats(0.3, 0.9),
    repose=st.floats(0.3, 0.75), plan=st.sampled_from(["circular", "rectangular", "slot"]),
    heap=st.booleans(), part=st.floats(0.3, 1.0),
)  # fmt: skip
def test_weight_is_carried_by_walls_and_what_is_below(
    slenderness, mu, ratio, repose, plan, heap, part
):
    """A gamma z = A p_v + U n_z at every depth below the heap, and dn_z/dz = p_w: balance of a
    slice, in every class but that of retaining silos; derivative by differences of 1e-5 of z."""
    vessel = Vessel(plan, 5.0, 7.0, 5.0 * slenderness, 0.5)
    own = wall(vessel, mu, ratio, repose, heap)
    z = np.array(max(part * vessel.height, 1.01 * own.highest))
    borne = vessel.area * own.vertical(z) + vessel.perimeter * own.carried(z)
    assert float(borne) == pytest.approx(vessel.area * 9e3 * float(z), rel=1e-9)
    step = 1e-5 * float(z)
    gained = (own.carried(z + step) - own.carried(z - step)) / (2 * step)
    assert float(gained) == pytest.approx(float(own.friction(z)), rel=1e-4, abs=1e-3)


def test_reimberts_pressure_begins_at_the_highest_contact():
    """Nothing above h_o; there it rises with gamma K (1 + tan phi_r) z, whatever mu."""
    own = wall(Vessel("circular", 5.0, 5.0, 6.0), 0.3, 0.5, 0.6)
    assert not own.horizontal(np.array([0.0, own.highest])).any()
    z = own.highest + 1e-6
    slope = float(own.horizontal(np.array(z))) / 1e-6
    assert slope == pytest.approx(9e3 * 0.5 * (1 + math.tan(0.6)), rel=1e-3)


def test_retaining_silo_has_no_silo_action():
    """p_h = gamma K (1 + sin phi_r)(z - h_o), n_z its integral times mu."""
    vessel = Vessel("circular", 10.0, 10.0, 3.9)
    own = wall(vessel, 0.4, 0.5, 0.6)
    assert vessel.slenderness_class == "retaining"
    z = np.array(3.0)
    below = 3.0 - own.highest
    pressure = 9e3 * 0.5 * (1 + math.sin(0.6)) * below
    assert float(own.horizontal(z)) == pytest.approx(pressure)
    assert float(own.carried(z)) == pytest.approx(0.4 * pressure * below / 2)


@pytest.mark.parametrize(
    ("ratio", "flat", "expected"),
    [(0.4, True, "retaining"), (0.4, False, "squat"), (1.0, True, "squat"),
     (1.01, True, "intermediate"), (1.99, False, "intermediate"), (2.0, True, "slender")],
)  # fmt: skip
def test_slenderness_classes(ratio, flat, expected):
    """Limits 0.4 (flat bottoms), 1.0 and 2.0 (5.1)."""
    vessel = Vessel("circular", 5.0, 5.0, 5.0 * ratio, None if flat else 0.4)
    assert vessel.slenderness_class == expected


@pytest.mark.parametrize("assessment_class", [1, 2, 3])
def test_discharge_factors_are_continuous_from_squat_to_slender(assessment_class):
    """C_S = h_c/d_c - 1 goes from 0 to 1: C_h meets both ends, for classes 2 and 3 C_w as well
    (1.0, then 1.15 and 1.10); none from the top."""

    def factors(slenderness, from_top=False):
        vessel = Vessel("circular", 5.0, 5.0, 5.0 * slenderness)
        return walls.discharge_factors(vessel, 0.5, assessment_class, 0.0, from_top)

    assert factors(1.0) == (1.0, 1.0) == factors(3.0, from_top=True)
    assert factors(1.0 + 1e-9) == pytest.approx((1.0, 1.0), abs=1e-8)
    assert factors(2.0 - 1e-9).horizontal == pytest.approx(factors(2.0).horizontal, abs=1e-8)
    if assessment_class > 1:
        assert factors(2.0) == pytest.approx((1.15, 1.10))
    else:
        assert factors(2.0) == pytest.approx((1.15 + 1.5 * 0.5, 1.4))


def test_patch_of_wheat_by_hand(wheat):
    """h_c/d_c = 3, C_op 0.5: C_pf = 0.21 x 0.5 (1 - e^-3), C_pe twice that, on s = pi d_c/16 at z_o
    (below h_c/2), where p_h = gamma K z_o (1 - 1/e); resultant pi/2 s d_c p of a thin wall."""
    found = Loads(wheat).patches()
    rise = 1 - math.exp(-3)
    assert found["filling"].factor == pytest.approx(0.105 * rise)
    assert found["discharge"].factor == pytest.approx(0.21 * rise)
    ratio, mu, side = 0.54 * 1.11, 0.38 / 1.16, math.pi * 5 / 16
    z_o = 1.25 / (ratio * mu)
    pressure = 0.105 * rise * 9e3 * ratio * z_o * (1 - math.exp(-1))
    own = found["filling"]
    assert (own.depth, own.side) == pytest.approx((z_o, side))
    assert own.pressure == pytest.approx(pressure)
    assert own.force == pytest.approx(math.pi / 2 * side * 5 * pressure)
    assert found["discharge"].pressure == pytest.approx(2 * 1.15 * pressure)


def test_patches_of_other_walls():
    """Thick circular walls: p outwards and p/7 inwards, no resultant; rectangular ones 0.36 p."""
    thin, thick = (Vessel("circular", 5.0, 5.0, 15.0, thin=t) for t in (True, False))
    box = Vessel("rectangular", 5.0, 5.0, 15.0)
    loads = {v: walls.patch_load(v, 0.1, wall(v), 1.0) for v in (thin, thick, box)}
    assert loads[thick].inward == pytest.approx(loads[thin].pressure / 7)
    assert loads[thick].force == 0.0 == loads[box].force
    # The box and the circle have the same A/U, so the same pressure.
    assert loads[box].pressure == pytest.approx(0.36 * loads[thin].pressure)


def test_eccentricity_raises_patches():
    """1 + 2 E^2, E = 2 e/d_c; and squat silos need none up to e = 0.1 d_c."""
    slender, squat = Vessel("circular", 5.0, 5.0, 15.0), Vessel("circular", 5.0, 5.0, 4.0, 0.4)
    ratio = walls.discharge_patch(slender, 0.5, 1.0) / walls.discharge_patch(slender, 0.5, 0.0)
    assert ratio == pytest.approx(1 + 2 * 0.4**2)
    assert walls.discharge_patch(squat, 0.5, 0.5) == 0.0
    assert walls.discharge_patch(squat, 0.5, 1.0) == pytest.approx(0.272 * 0.5 * (0.8 - 1 + 0.4))


# Solids


def test_characteristic_values_of_wheat(wheat):
    """Table E.1 (phi_i 30 deg x 1.12, K 0.54 x 1.11, mu 0.38 x 1.16) by table 3.1."""
    low, high = 0.38 / 1.16, 0.38 * 1.16
    k_low, k_high = 0.54 / 1.11, 0.54 * 1.11
    expected = {
        "wall_pressure": (low, k_high, 30 / 1.12), "wall_friction": (high, k_high, 30 / 1.12),
        "bottom": (low, k_low, 30 * 1.12), "hopper_filling": (low, k_low, 30 / 1.12),
        "hopper_discharge": (low, k_high, 30 * 1.12),
    }  # fmt: skip
    for load_case, values in expected.items():
        mu, ratio, phi = characteristic(wheat.solid, load_case)
        assert (mu, ratio, phi / DEG) == pytest.approx(values)
    assert characteristic(wheat.solid, "bottom", means=True) == pytest.approx(
        (0.38, 0.54, 30 * DEG)
    )


def test_walls_are_no_rougher_than_the_solid(tmp_path):
    """mu <= tan phi_i: wheat on a rough wall, mu 0.57 x 1.16, slides in itself at 26.8 deg."""
    path = tmp_path / "rough.toml"
    path.write_text(WHEAT + 'wall_type = "D3"\n')
    mu, _, phi = characteristic(load_design(path).solid, "wall_friction")
    assert mu == pytest.approx(math.tan(phi)) == pytest.approx(math.tan(30 / 1.12 * DEG))


def test_lateral_ratios_of_table_e1_follow_from_the_friction():
    """K_m = 1.1 (1 - sin phi_im) to 0.025 (loose coal and lime are set lower); "default" is meant
    to be wide. Walls D1, D2, D3 grow rougher."""
    assert len(table_e1()) == 25
    for name, row in table_e1().items():
        if name != "default":
            expected = lateral_ratio_of(row.internal_friction)
            assert row.lateral_ratio == pytest.approx(expected, abs=0.025), name
        assert row.wall_friction[0] < row.wall_friction[1] < row.wall_friction[2]


# Bottoms and hoppers


@pytest.mark.parametrize("shape", ["cone", "wedge"])
@pytest.mark.parametrize(
    ("make", "beta"),
    [(bottom.hopper_filling, 15.0), (bottom.hopper_filling, 50.0), (bottom.hopper_discharge, 15.0)],
)
def test_slice_of_a_hopper_is_in_balance(shape, make, beta):
    """x dp_v/dx = n p_v - gamma x, n = S (F (mu cot beta + 1) - 1) with the very F and mu_eff that
    the pressures on the wall have, and p_v is p_vft at the transition. By differences on 2001
    points: 1e-6."""
    vessel = Vessel("circular", 5.0, 5.0, 15.0, beta * DEG, 0.5, shape)
    values = Values(0.35, 0.5, 32 * DEG)
    own = make(vessel, 9e3, 60e3, values, 2001)
    assert (beta * DEG < bottom.steep_up_to(values)) == (beta == 15.0)
    surface = 2 if shape == "cone" else 1
    n = surface * (own.factor * (own.effective_friction / math.tan(beta * DEG) + 1) - 1)
    slope = np.gradient(own.vertical, own.height, edge_order=2)
    left, right = own.height * slope, n * own.vertical - 9e3 * own.height
    np.testing.assert_allclose(left[1:-1], right[1:-1], rtol=0, atol=1e-5 * np.abs(right).max())
    assert own.vertical[-1] == pytest.approx(60e3)
    np.testing.assert_allclose(own.friction, own.effective_friction * own.normal)
    np.testing.assert_allclose(own.normal, own.factor * own.vertical)


@pytest.mark.parametrize("length", [5.0, 8.0, 20.0])
@pytest.mark.parametrize("make", [bottom.hopper_filling, bottom.hopper_discharge])
def test_slices_of_a_rectangular_pyramid_hang_on_its_four_walls(length, make):
    """EN 1991-4, 6.1.2, S = 1 + b/a: d(A p_v)/dx = the walls' lift - gamma A, integrated down from
    the transition over two walls of width a x/h_h at tan beta = b/(2 h_h) and two of b x/h_h at
    a/(2 h_h): pressure F p_v on their plan, friction mu F p_v along them. Tolerance: the
    integration's 1e-10 a step, summed."""
    vessel = Vessel("rectangular", 5.0, length, 15.0, 20 * DEG, 1.0, "pyramid")
    own = make(vessel, 9e3, 60e3, Values(0.35, 0.5, 32 * DEG))
    high = 2.5 / math.tan(20 * DEG)

    def slope(x, carried):  # carried: A p_v [N]
        area = 5.0 * length * (x / high) ** 2
        pressure = own.factor * carried / area
        walls = ((length * x / high, 2.5 / high), (5.0 * x / high, length / 2 / high))
        lift = sum(2 * wide * pressure * (tan + own.effective_friction) for wide, tan in walls)
        return lift - 9e3 * area

    down = own.height[::-1]
    found = solve_ivp(slope, down[[0, -1]], [5.0 * length * 60e3], t_eval=down, rtol=1e-10)
    expected = found.y[0] / (5.0 * length * (down / high) ** 2)
    np.testing.assert_allclose(own.vertical[::-1], expected, rtol=1e-6)


@pytest.mark.parametrize("past", [-0.1, 0.1])
def test_hopper_is_steep_or_shallow_once_for_filling_and_discharge(tmp_path, past):
    """EN 1991-4, 6.1.1: by the lower values of K and mu_h. Wheat: tan beta = (1 - 0.54/1.11)/(2 x
    0.38/1.16). Up to there discharge has F_e, beyond it is filling, whose mu_eff meets mu_h: 1 %
    from a limit to 0.1 deg beyond."""
    limit = math.atan((1 - 0.54 / 1.11) / (2 * 0.38 / 1.16)) / DEG
    path = tmp_path / "wheat.toml"
    path.write_text(WHEAT.replace("20 deg", f"{limit + past} deg"))
    own = closed_forms(load_design(path))["bottom"]
    assert own["steep_up_to_deg"] == pytest.approx(limit)
    assert own["kind"] == ("steep" if past < 0 else "shallow")
    assert own["filling"]["effective_friction"] == pytest.approx(0.38 / 1.16, rel=0.01)
    if past < 0:
        assert own["discharge"]["F"] > 1.05 * own["filling"]["F"]
    else:
        assert own["discharge"] == own["filling"]


@pytest.mark.parametrize(("half_angle", "said"), [(20, False), (31.4, True), (50, False)])
def test_report_says_where_the_scatter_decides_what_a_hopper_is(tmp_path, half_angle, said):
    """Steep up to 38.1 deg by the lower values of wheat, up to 24.4 deg by the upper ones (1 - 0.54
    x 1.11 over 2 x 0.38 x 1.16); without scatter, in class 1, nothing differs."""
    path = tmp_path / "wheat.toml"
    path.write_text(WHEAT.replace("20 deg", f"{half_angle} deg"))
    for changes, expected in (({}, said), ({"rules.assessment_class": 1}, False)):
        parts = bottom_parts(closed_forms(load_design(path, changes)))
        words = [part.words for part in parts if getattr(part, "name", "") == "steep hopper"]
        assert bool(words) == expected
        for line in words:
            assert "38.1 deg" in line
            assert "24.4 deg" in line


def test_smooth_upright_hopper_is_passive():
    """F_e without wall friction at beta -> 0: (1 + sin phi)/(1 - sin phi), Rankine passive."""
    vessel = Vessel("circular", 5.0, 5.0, 15.0, 1e-6, 0.0)
    own = bottom.hopper_discharge(vessel, 9e3, 60e3, Values(0.0, 0.5, 30 * DEG))
    assert own.factor == pytest.approx(3.0, rel=1e-5)


def test_hopper_whose_exponent_is_one():
    """p_v/(gamma h_h) = -y ln y + ... is the limit of (y - y^n)/(n - 1)."""
    vessel = Vessel("circular", 5.0, 5.0, 15.0, 0.3, 0.5)
    near, at = (bottom._pressures(vessel, 9e3, 6e4, 0.3, 1.0, n, 9) for n in (1 + 1e-7, 1.0))
    np.testing.assert_allclose(near.vertical, at.vertical, rtol=1e-6)


def test_bottom_magnifiers_and_squat_bottoms():
    """C_b 1.0, 1.3 (class 1), 1.2 and 1.6 dynamic. Under a squat heap gamma (h_tp - h_o) is added
    at h_c = h_tp, where the share is 1, and less with height until 2 d_c."""
    found = [bottom.bottom_magnifier(c, d) for c in (1, 2, 3) for d in (False, True)]
    assert found == [1.3, 1.6, 1.0, 1.2, 1.0, 1.2]
    shares = []
    for height in (5 * math.tan(0.6) / 2, 7.5, 10 - 1e-9):
        own = wall(Vessel("circular", 5.0, 5.0, height, 1.55), 0.4, 0.5, 0.6)
        pile = own.vessel.pile_height(0.6, True)
        added = bottom.flat_bottom(own, 1.0, pile) - float(own.vertical(np.array(height)))
        shares.append(added / (9e3 * (pile - own.highest)))
    assert shares == pytest.approx([1.0, 0.5 / (2 - math.tan(0.6) / 2), 0.0], abs=1e-8)


def test_weight_of_a_full_silo_is_that_of_its_volume(wheat):
    """A cylinder and a truncated cone, by the formula of solids."""
    big, small = 2.5, 0.3
    high = (big - small) / math.tan(20 * DEG)
    cone = math.pi * high / 3 * (big**2 + big * small + small**2)
    expected = 9e3 * (math.pi * big**2 * 15 + cone)
    assert closed_forms(wheat)["silo"]["weight_n"] == pytest.approx(expected)


def test_plates_of_a_slot_count_where_they_rub():
    """A/U = W/2 between frictionless plates, W L/(2 (W + L)) between rough ones."""
    smooth, rough = (Vessel("slot", 0.3, 0.12, 0.4, rough_plates=r) for r in (False, True))
    assert smooth.area / smooth.perimeter == pytest.approx(0.15)
    assert rough.area / rough.perimeter == pytest.approx(0.3 * 0.12 / 0.84)


@pytest.mark.parametrize("rough", [False, True])
def test_hopper_between_plates_closer_than_its_outlet_reaches_from_it_to_the_walls(rough):
    """A wedge of 30 deg under walls 0.3 m apart, plates 0.05 m, outlet 0.1 m: up to 0.15/tan 30 deg
    over its apex from 0.05/tan 30 deg, area (0.3^2 - 0.1^2)/(4 tan 30 deg), whatever the plates."""
    vessel = Vessel("slot", 0.3, 0.05, 0.4, 30 * DEG, 0.1, "wedge", rough_plates=rough)
    own = bottom.hopper_filling(vessel, 9e3, 1e3, Values(0.3, 0.5, 32 * DEG))
    tan = math.tan(30 * DEG)
    assert own.height[[0, -1]] == pytest.approx([0.05 / tan, 0.15 / tan])
    assert np.all(np.diff(own.height) > 0)
    assert vessel.volume == pytest.approx(0.05 * (0.3 * 0.4 + 0.08 / (4 * tan)))
    assert vessel.characteristic_width == (0.05 if rough else 0.3)


# Flow


@pytest.mark.parametrize("delta", [30, 40, 50, 60])
def test_two_fits_to_jenikes_chart_for_wedges_agree(delta):
    """Ter Borg's and Arnold, McLean and Roberts's: within 2 deg wherever a wedge of 10 deg still
    flows in mass, and the first falls with the roughness of the wall."""
    limits = []
    for friction in range(0, delta - 3, 4):
        own = jenike.mass_flow_limit(delta * DEG, friction * DEG, plane=True) / DEG
        other = min(analytic.wedge_limit(delta, friction), 60.0)
        if other > 10:
            assert own == pytest.approx(other, abs=2.0)
        limits.append(own)
    assert np.all(np.diff(limits) <= 0)


def test_smooth_cone_of_thirty_degrees_flows_in_mass_up_to_sixty():
    """sin delta = 1/2: 90 - acos(1/2)/2 = 60 deg; a wedge is never the steeper one."""
    assert jenike.mass_flow_limit(30 * DEG, 0.0, plane=False) / DEG == pytest.approx(60)
    for friction in (10, 20):
        limits = [jenike.mass_flow_limit(40 * DEG, friction * DEG, plane=p) for p in (True, False)]
        assert limits[0] > limits[1] + 5 * DEG


@pytest.mark.parametrize(
    ("half_angle", "pattern"),
    [(26.0, "mass flow"), (28.0, "at the limit"), (30.1, "funnel flow"), (90.0, "funnel flow")],
)
def test_flow_patterns_about_a_limit_of_thirty_degrees(half_angle, pattern):
    """Three degrees below the limit count as at it."""
    assert jenike.flow_pattern(half_angle * DEG, 30 * DEG) == pattern


@pytest.mark.parametrize(
    ("delta", "friction", "half_angle"), [(50, 20, 15), (40, 10, 15), (60, 25, 20), (50, 20, 25)]
)
def test_enstads_stress_is_the_radial_fields(delta, friction, half_angle):
    """Enstad's circular arcs against Jenike's radial stress field, integrated: within 3 % at half
    angles up to 25 deg (Arnold and McLean 1976 report some per cent)."""
    own = jenike.converging(delta * DEG, friction * DEG, half_angle * DEG, plane=True)
    exact = analytic.radial_field(delta * DEG, friction * DEG, half_angle * DEG)
    assert own is not None
    assert own.stress == pytest.approx(exact, rel=0.03)
    expected = own.arch * (1 + math.sin(delta * DEG)) * own.stress
    assert own.flow_factor == pytest.approx(expected / (2 * math.sin(half_angle * DEG)))


def test_outlet_of_a_solid_of_constant_strength():
    """f_c = 2 kPa: arches up to H f_c/gamma, H = 1 + theta/200 in the plane; ratholes up to 4.3
    tan(phi) f_c/gamma."""
    points = ((0.0, 2e3), (1e5, 2e3))
    strong = jenike.arching_stress(points, 1.3, 1e6)
    assert strong == pytest.approx(2e3)
    assert jenike.rathole(40 * DEG, 2e3, 9e3) == pytest.approx(4.3 * math.tan(40 * DEG) * 2e3 / 9e3)
    own = jenike.converging(40 * DEG, 20 * DEG, 20 * DEG, plane=True)
    assert own is not None
    assert own.arch == pytest.approx(1.1)


@pytest.mark.parametrize("phi", [30, 40, 50, 60])
def test_rathole_factor_follows_jenikes_curve(phi):
    """Two fits to it: 4.3 tan phi within 4 % of the polynomial."""
    assert jenike.rathole(phi * DEG, 1.0, 1.0) == pytest.approx(
        analytic.rathole_factor(phi), rel=0.04
    )


def test_solid_that_is_stronger_than_any_arch_arches_at_any_width():
    """f_c = 0.9 sigma against sigma/ff with ff = 1.3: no crossing."""
    assert jenike.arching_stress(((0.0, 10.0), (1e5, 9e4)), 1.3, 1e7) is None


def test_cohesionless_solid_neither_arches_nor_ratholes(wheat):
    """No flow function: both are zero, and the report says so."""
    own = closed_forms(wheat)["jenike"]
    assert own["cohesionless"]
    assert own["arch_up_to_m"] == 0.0 == own["rathole_up_to_m"]


@pytest.mark.parametrize(("strength", "verdict"), [(1.0, "wide enough"), (5.0, "too narrow")])
def test_outlet_is_compared_with_the_widest_arch(tmp_path, strength, verdict):
    """f_c constant, in kPa: a cone of 20 deg arches up to (2 + 20/65) f_c/gamma_l, 0.31 and 1.54 m,
    by wheat's lower 7.5 kN/m3; the outlet is 0.6 m."""
    path = tmp_path / "cohesive.toml"
    path.write_text(f"{WHEAT}flow_function = [[0, {strength}], [100, {strength}]]\n")
    forms = closed_forms(load_design(path))
    expected = (2 + 20 / 65) * 1e3 * strength / 7.5e3
    assert forms["jenike"]["arch_up_to_m"] == pytest.approx(expected)
    words = " ".join(fact.words for fact in jenike_facts(forms))
    assert verdict in words
    assert "0.6 m" in words


@pytest.mark.parametrize(
    ("keys", "lower", "said"),
    [('unit_weight = "8 kN/m3"', 8e3, True), ('unit_weight_lower = "6 kN/m3"', 6e3, False),
     ('unit_weight = "9 kN/m3"', 7.5e3, False)],
)  # fmt: skip
def test_outlets_go_by_the_lower_unit_weight(tmp_path, keys, lower, said):
    """D = 4.3 tan(phi) f_c/gamma_l, f_c 1 kPa: that of table E.1 goes with its upper one; where one
    other than that is given alone it counts as both, and the report says so."""
    path = tmp_path / "cohesive.toml"
    path.write_text(f"{WHEAT}{keys}\nflow_function = [[0, 1], [100, 1]]\n")
    forms = closed_forms(load_design(path))
    expected = 4.3 * math.tan(30 * DEG) * 1e3 / lower
    assert forms["jenike"]["rathole_up_to_m"] == pytest.approx(expected)
    assert any("no lower one" in line for line in forms["assumptions"]) == said


def jenike_words(tmp_path, half_angle, points, outlet="0.6 m"):
    """Jenike's facts on wheat that coheres, by name; half angle in degrees, None: a flat bottom."""
    own = "" if half_angle is None else f'half_angle = "{half_angle} deg"'
    silo = WHEAT.replace('half_angle = "20 deg"', own).replace("0.6 m", outlet)
    path = tmp_path / "cohesive.toml"
    path.write_text(f"{silo}flow_function = {points}\n")
    return {fact.name: fact.words for fact in jenike_facts(closed_forms(load_design(path)))}


def test_mass_flow_is_judged_by_the_arch_alone(tmp_path):
    """20 deg: arches up to 0.31 m; ratholes do not stand where all of the solid moves."""
    found = jenike_words(tmp_path, 20, [[0, 1], [100, 1]])
    assert "arches up to 0.308 m: 0.6 m is wide enough" in found["outlet"]
    assert "rathole" not in found


@pytest.mark.parametrize(("half_angle", "reason"), [(None, "flat bottom"), (40, "funnel flow")])
@pytest.mark.parametrize(("outlet", "verdict"), [("0.3 m", "too narrow"), ("0.4 m", "wide enough")])
def test_funnel_flow_is_judged_by_the_rathole(tmp_path, half_angle, reason, outlet, verdict):
    """D = 4.3 tan(30 deg) x 1 kPa/7.5 kN/m3 = 0.331 m; arches are those of converging walls, along
    which nothing flows: they are not computed, and not said to stand at any width."""
    found = jenike_words(tmp_path, half_angle, [[0, 1], [100, 1]], outlet)
    assert f"arches not computed: {reason}" in found["outlet"]
    assert "any width" not in found["outlet"]
    assert "up to 0.331 m" in found["rathole"]
    assert verdict in found["rathole"]


def test_solid_stronger_than_any_arch_is_said_to_arch_at_any_width(tmp_path):
    """f_c = 0.9 sigma exceeds sigma/ff, ff = 1.80: no outlet is wide enough, as far as a strength
    beyond the last point may be told."""
    found = jenike_words(tmp_path, 20, [[0, 0.01], [100, 90]])
    assert "arches at any width: 0.6 m is too narrow" in found["outlet"]
    assert "extrapolated beyond its last point, 100 kPa" in found["outlet"]


@pytest.mark.parametrize(("last", "said"), [(1.0, True), (2.0, False)])
def test_strength_beyond_the_last_point_is_said_to_be_extrapolated(tmp_path, last, said):
    """f_c 1 kPa meets sigma/1.80 at 1.80 kPa, and a rathole stands after 50.2 kPa."""
    points = [[0, 1], [last, 1]]
    arch = jenike_words(tmp_path, 20, points)["outlet"]
    assert ("strength at 1.80 kPa extrapolated" in arch) == said
    assert "extrapolated" in jenike_words(tmp_path, 40, points)["rathole"]
    assert "extrapolated" not in jenike_words(tmp_path, 40, [[0, 1], [60, 1]])["rathole"]


def test_rathole_is_compared_with_the_diagonal_of_a_slot():
    """A slot of 0.3 m x 4 m is 4.01 m across, a round outlet as wide as it is, none is 0 m."""
    slot = Vessel("rectangular", 3.0, 4.0, 9.0, 0.5, 0.3, "wedge")
    assert slot.outlet_across == pytest.approx(math.hypot(0.3, 4.0))
    assert Vessel("circular", 3.0, 3.0, 9.0, 0.5, 0.3).outlet_across == 0.3
    assert Vessel("rectangular", 3.0, 4.0, 9.0, 0.5, 0.0, "wedge").outlet_across == 0.0


def test_large_silo_of_class_one_says_that_it_is_none(tmp_path):
    """Class 1 is for up to 100 t; wheat in 5 m x 15 m weighs 311 t."""
    path = tmp_path / "wheat.toml"
    path.write_text(WHEAT)
    for changes, said in (({"rules.assessment_class": 1}, True), ({}, False)):
        words = closed_forms(load_design(path, changes))["assumptions"]
        assert any("311 t" in line for line in words) == said


def test_commented_file_is_a_silo_that_is_taken(tmp_path):
    path = tmp_path / "silo.toml"
    path.write_text(commented_spec())
    design = load_design(path)
    assert (design.vessel.width, design.vessel.height, design.solid.name) == (5.0, 15.0, "wheat")


REFUSALS = [
    ('width = "5 m"', 'width = "5"', ["width = '5'", "the unit is missing", "475 mm"]),
    ('width = "5 m"', 'width = "-5 m"', ["[silo] width", "greater than 0"]),
    ('"wheat"', '"wheet"', ["name = 'wheet'", "did you mean 'wheat'?"]),
    ('name = "wheat"', "", ["unit_weight is missing", "'9 kN/m3'"]),
    ('outlet = "0.6 m"', 'outlet = "6 m"', ["outlet = 6 m", "narrower than the silo, 5 m"]),
    ('half_angle = "20 deg"', 'half_angle = "95 deg"', ["half_angle", "less than"]),
    ('name = "wheat"', 'name = "wheat"\nrepose = "2 deg"', ["repose = 2 deg", "5 to 75 deg"]),
    ('name = "wheat"', 'name = "wheat"\nunit_weight_lower = "10 kN/m3"',
     ["unit_weight_lower = 10 kN/m3", "at most unit_weight = 9 kN/m3"]),
    ('name = "wheat"', 'name = "wheat"\nlateral_ratio = 0.95\nlateral_ratio_factor = 1.2',
     ["lateral_ratio = 0.95", "lateral_ratio_factor = 1.2", "1.14", "less than 0.8333"]),
    ('name = "wheat"',
     'unit_weight = "9 kN/m3"\nwall_friction = 0.1\ninternal_friction = "5.1 deg"',
     ["lateral_ratio = 1.002 by eq. 4.7", "less than 1"]),
    ('name = "wheat"',
     'name = "wheat"\ninternal_friction = "70 deg"\ninternal_friction_factor = 1.3',
     ["internal_friction = 70 deg", "internal_friction_factor = 1.3", "less than 69.23 deg"]),
    ('name = "wheat"', 'name = "wheat"\nflow_function = [[1, 2, 3]]', ["pairs", "kPa"]),
    ('name = "wheat"', 'name = "wheat"\nflow_function = [[2, 1], [1, 1]]', ["ascend"]),
    ('name = "wheat"', 'name = "wheat"\n[rules]\nassessment_class = 4', ["assessment_class = 4"]),
    ('name = "wheat"', 'name = "wheat"\n[rules]\noutlet_eccentricity = "3 m"',
     ["outlet_eccentricity = 3 m", "at most 2.5 m"]),
    ('[silo]', '[silo]\nplan = "rectangular"\nlength = "4 m"', ["width = 5 m", "at most length"]),
    ('[silo]', '[silos]', ["unknown key 'silos'", "did you mean 'silo'?"]),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "words"), REFUSALS)
def test_wrong_silo_is_refused_in_one_line(tmp_path, old, new, words):
    path = tmp_path / "silo.toml"
    path.write_text(WHEAT.replace(old, new))
    assert_refuses(words, load_design, path)


def test_file_without_a_silo_says_what_it_takes(tmp_path):
    path = tmp_path / "silo.toml"
    path.write_text("schema = 1\n")
    assert_refuses(["[silo] is missing", "width and height"], load_design, path)
    assert_refuses(["no such file", "--loads"], load_design, tmp_path / "none.toml")
