"""Single impacts: restitution, contact time, deepest overlap, friction and spin."""

import math

import numpy as np
import pytest
from analytic import (
    ENDING_AT_ZERO_FORCE,
    angular_frequency,
    contact_time,
    damping_of_restitution,
    deepest_overlap,
    disc_after_gross_sliding,
    restitution_at_zero_overlap,
)
from numpy.testing import assert_allclose
from scenes import (
    DISC_CONTACTS,
    ELASTIC,
    LEVEL,
    WOOD,
    block,
    block_on_wall,
    corner_on_face,
    corner_on_wall,
    disc,
    disc_on_wall,
    face_to_face,
    inertia,
    launch,
    mass,
    position,
    simulation_of,
    velocity,
)
from scipy.integrate import solve_ivp

STEPS = 2000  # of a contact
RADIUS = 5e-3  # of the disc [m]


def collide(scene, law, speed, contacts=1):
    """Drop particle 0 head-on; (restitution, time in contact, deepest overlap, most pairs)."""
    simulation, step = in_steps(scene, law, contacts)
    launch(simulation, vy=-speed)
    start = position(simulation)[1] - other_height(simulation)
    deepest, touching, most_pairs, pairs = 0.0, 0, 0, 1
    while pairs or not touching:
        simulation.run(1)
        pairs = len(simulation.touching())
        touching += pairs > 0
        most_pairs = max(most_pairs, pairs)
        deepest = max(deepest, start - position(simulation)[1] + other_height(simulation))
    simulation.run(1)
    rebound = velocity(simulation)[1]
    if simulation.n_particles == 2:
        rebound -= velocity(simulation, 1)[1]
    return rebound / speed, touching * step, deepest, most_pairs


def other_height(simulation):
    return position(simulation, 1)[1] if simulation.n_particles == 2 else 0.0


def in_steps(scene, law, contacts=1):
    """The scene with STEPS steps to a contact, and the step [s]."""
    m = reduced(scene(law, 1.0))
    omega0 = angular_frequency(law.kn, m, contacts)
    step = contact_time(omega0, contacts * law.gamma_n) / STEPS
    return scene(law, step), step


def reduced(simulation):
    m = mass(simulation)
    return m if simulation.n_particles == 1 else 1 / (1 / m + 1 / mass(simulation, 1))


def lying_on_wall(law, step):
    return block_on_wall(block(20e-3, 10e-3), law, step)


def tolerance(omega0, gamma):
    """Of a result that is relative to the impact speed. The dashpot's force jumps at both ends
    of a contact, where a sum over steps may miss half a step: gamma dt/2 each. What is left of
    the leapfrog's error is (omega0 dt)^2."""
    step = contact_time(omega0, gamma) / STEPS
    return gamma * step + (omega0 * step) ** 2


@pytest.mark.parametrize("e", [0.2, 0.45, 0.53, 0.80, 0.95])
@pytest.mark.parametrize("scene", [corner_on_wall, corner_on_face])
@pytest.mark.parametrize("speed", [0.05, 2.0])
def test_what_goes_in_comes_out(scene, speed, e):
    """Wood-silo paper, eq. 3.8: gamma_n from e gives e at any speed, for one contact with the
    reduced mass, where the contact may pull until the overlap is zero."""
    omega0 = angular_frequency(WOOD.kn, reduced(scene(WOOD, 1.0)))
    gamma = damping_of_restitution(omega0, e)
    out, _, _, pairs = collide(scene, WOOD._replace(gamma_n=gamma), speed)
    assert pairs == 1
    assert out == pytest.approx(e, abs=tolerance(omega0, gamma))


@pytest.mark.parametrize(("e", "higher"), ENDING_AT_ZERO_FORCE.items())
def test_contact_that_may_not_pull_bounces_higher(e, higher):
    """Schwager and Poeschel 2007. Tolerance: theirs in the third digit, and the steps'."""
    omega0 = angular_frequency(WOOD.kn, reduced(corner_on_face(WOOD, 1.0)))
    gamma = damping_of_restitution(omega0, e)
    law = WOOD._replace(gamma_n=gamma, pulls=False)
    out, _, _, _ = collide(corner_on_face, law, 1.0)
    assert out == pytest.approx(higher, abs=5e-4 + tolerance(omega0, gamma))


@pytest.mark.parametrize("e", [1.0, 0.8, 0.45])
@pytest.mark.parametrize("scene", [corner_on_wall, corner_on_face])
def test_contact_time_and_deepest_overlap(scene, e):
    """Restitution says nothing of kn and the reduced mass themselves; pi/w and
    (v/omega0) exp(-(b/w) atan(w/b)) do. Tolerance: two steps; as in tolerance()."""
    omega0 = angular_frequency(WOOD.kn, reduced(scene(WOOD, 1.0)))
    gamma = damping_of_restitution(omega0, e)
    _, time, deepest, _ = collide(scene, WOOD._replace(gamma_n=gamma), 1.0)
    assert time == pytest.approx(contact_time(omega0, gamma), rel=2 / STEPS)
    expected = deepest_overlap(omega0, gamma, 1.0)
    assert deepest == pytest.approx(expected, rel=tolerance(omega0, gamma))


@pytest.mark.parametrize(
    ("scene", "gamma_n", "contacts", "published"),
    [(face_to_face, 6085.0, 8, (0.52, 0.53)), (lying_on_wall, 4303.0, 2, (0.725, 0.735))],
)
def test_faces_bounce_less_than_corners(scene, gamma_n, contacts, published):
    """Every vertex-edge pair has its own spring and dashpot: n pairs are one contact with n kn
    and n gamma_n. With the paper's gamma_n aligned 10 mm x 20 mm blocks give 0.52-0.53, a face
    on a wall 0.73."""
    law = WOOD._replace(gamma_n=gamma_n)
    omega0 = angular_frequency(law.kn, reduced(scene(law, 1.0)), contacts)
    gamma = contacts * gamma_n
    e, time, _, pairs = collide(scene, law, 0.5, contacts)
    assert pairs == contacts
    expected = restitution_at_zero_overlap(omega0, gamma)
    assert e == pytest.approx(expected, abs=tolerance(omega0, gamma))
    assert time == pytest.approx(contact_time(omega0, gamma), rel=2 / STEPS)
    assert published[0] < e < published[1]


def hit_wall(law, v_n, v_t, spin=0.0):
    """A disc hits a wall; (v_n', v_t', spin') and the constants of the impact."""

    def scene(law, step):
        return disc_on_wall(RADIUS, law, step)

    simulation, step = in_steps(scene, law, DISC_CONTACTS)
    launch(simulation, vx=v_t, vy=-v_n, spin=spin)
    simulation.run(round(1.05 * STEPS))
    assert len(simulation.touching()) == 0
    v_t, v_n, spin = velocity(simulation)
    return (v_n, v_t, spin), simulation, step


def oblique(angle_deg, speed=1.0):
    angle = math.radians(angle_deg)
    return speed * math.cos(angle), speed * math.sin(angle)


def disc_law(e, mu, kt_over_kn, gamma_t=0.0):
    """A law with which the disc, DISC_CONTACTS contacts in parallel, has restitution e."""
    m = reduced(disc_on_wall(RADIUS, WOOD, 1.0))
    omega0 = angular_frequency(WOOD.kn, m, DISC_CONTACTS)
    gamma_n = damping_of_restitution(omega0, e) / DISC_CONTACTS
    return WOOD._replace(kt=kt_over_kn * WOOD.kn, mu=mu, gamma_n=gamma_n, gamma_t=gamma_t), omega0


@pytest.mark.parametrize("angle_deg", [60, 70, 80, 88])
@pytest.mark.parametrize(("e", "mu"), [(0.8, 0.25), (1.0, 0.1)])
def test_gross_sliding(angle_deg, e, mu):
    """v_t' = v_t - mu (1 + e) v_n, spin 2 mu (1 + e) v_n/r, the contact point leaves at
    atan((v_t - 3 mu (1 + e) v_n)/(e v_n)). Exact for this law where the contact may pull: the
    dashpot's impulse m gamma_n (d(end) - d(start)) is zero, so the springs' is all of it. It
    slides from the start since v_t > mu (kn/kt) v_n. Tolerance: tolerance(); for the spin also
    the arm, which is r - d/2."""
    law, omega0 = disc_law(e, mu, 2 / 7)
    v_n, v_t = oblique(angle_deg)
    assert v_t > max(3 * mu * (1 + e), mu * 7 / 2) * v_n
    (v_n_out, v_t_out, spin), _, _ = hit_wall(law, v_n, v_t)
    v_t_expected, spin_expected = disc_after_gross_sliding(v_n, v_t, e, mu, RADIUS)
    allowed = tolerance(omega0, DISC_CONTACTS * law.gamma_n)
    arm = deepest_overlap(omega0, DISC_CONTACTS * law.gamma_n, v_n) / (2 * RADIUS)
    assert v_n_out == pytest.approx(e * v_n, abs=allowed * v_n)
    assert v_t_out == pytest.approx(v_t_expected, abs=mu * allowed * v_n)
    # Forwards is clockwise.
    assert -spin == pytest.approx(spin_expected, rel=allowed + arm)
    slides = math.atan2(v_t_out + spin * RADIUS, v_n_out)
    expected = math.atan2(v_t - 3 * mu * (1 + e) * v_n, e * v_n)
    assert slides == pytest.approx(expected, abs=3 * (allowed + arm))


@pytest.mark.parametrize("angle_deg", [45, 60, 68, 72, 74, 76, 78, 80, 84, 88, 89])
@pytest.mark.parametrize("e", [1.0, 0.9, 0.5, 0.2])
@pytest.mark.parametrize(("kt_over_kn", "damped"), [(2 / 7, 0.0), (2 / 7, 0.5), (1.0, 0.5)])
def test_grazing_impact_of_linear_springs_gains_nothing(angle_deg, e, kt_over_kn, damped):
    """LAMMPS's pull request 5007 (2026): its wall of linear springs gave a grazing sphere up to
    34 % of its energy at mu = 0.5 and 76 degrees from the normal. Here a disc, with LAMMPS's own
    gamma_t = gamma_n/2 too. It arrives without spin, so friction can only slow it. Tolerance:
    tolerance() of the normal energy, and as much of friction's, mu v_n v_t."""
    law, omega0 = disc_law(e, 0.5, kt_over_kn)
    law = law._replace(gamma_t=damped * law.gamma_n)
    v_n, v_t = oblique(angle_deg)
    (v_n_out, v_t_out, spin), simulation, _ = hit_wall(law, v_n, v_t)
    rotation = inertia(simulation) / mass(simulation) * spin**2
    allowed = tolerance(omega0, DISC_CONTACTS * law.gamma_n)
    after = v_n_out**2 + v_t_out**2 + rotation
    assert after < 1.0 + allowed * (v_n**2 + 0.5 * v_n * v_t)
    assert v_t_out < v_t


@pytest.mark.parametrize("e", [1.0, 0.8, 0.5])
def test_angular_velocity_at_an_impact_on_a_wall(e):
    """A spinning disc that hits a wall head-on and slides throughout loses the spin
    2 mu (1 + e) v_n/r and leaves sideways with mu (1 + e) v_n. Tolerances as in gross sliding."""
    mu, v_n, spin = 0.2, 0.5, 1000.0
    law, omega0 = disc_law(e, mu, 2 / 7)
    (_, v_t, spin_out), _, _ = hit_wall(law, v_n, 0.0, spin)
    v_t_lost, spin_lost = disc_after_gross_sliding(v_n, 0.0, e, mu, RADIUS)
    allowed = tolerance(omega0, DISC_CONTACTS * law.gamma_n)
    arm = deepest_overlap(omega0, DISC_CONTACTS * law.gamma_n, v_n) / (2 * RADIUS)
    assert v_t == pytest.approx(v_t_lost, abs=mu * allowed * v_n)
    assert spin - spin_out == pytest.approx(spin_lost, rel=allowed + arm)


def by_runge_kutta(law, v_n, v_t, n, m, i, r):
    """(v_t', spin') of a disc on a wall: the law's equations solved tightly, phase by phase.

    d'' + n gamma_n d' + n kn/m d = 0; v_t' = n f/m; spin' = n f (r - d/2)/I, with
    f = -kt s - m gamma_t u and the contact point's velocity u = v_t + (r - d/2) spin. While the
    spring holds, s' = u; while it slides, s = +-mu kn d/kt, until u no longer keeps it there.
    """
    at_limit = law.mu * law.kn / law.kt

    def rates(_, y, side):
        d, d_rate, v, spin, s = y
        arm = r - d / 2
        u = v + arm * spin
        f = -law.kt * (side * at_limit * d if side else s) - m * law.gamma_t * u
        pull = -n * (law.kn / m * d + law.gamma_n * d_rate)
        return d_rate, pull, n * f / m, n * f * arm / i, side * at_limit * d_rate if side else u

    def leaves(_, y, side):
        return y[0] if y[1] < 0 else 1.0

    def starts_to_slide(_, y, side):
        return abs(y[4]) - at_limit * y[0]

    def starts_to_hold(_, y, side):
        return side * (y[2] + (r - y[0] / 2) * y[3]) - at_limit * y[1]

    leaves.terminal = starts_to_slide.terminal = starts_to_hold.terminal = True
    starts_to_slide.direction, starts_to_hold.direction = 1, -1
    y, t = [0.0, v_n, v_t, 0.0, 0.0], 0.0
    side = 1 if v_t > at_limit * v_n else 0
    while True:
        events = [leaves, starts_to_hold if side else starts_to_slide]
        phase = solve_ivp(
            rates, (t, t + 1.0), y, args=(side,), events=events, method="DOP853",
            rtol=1e-10, atol=1e-16, max_step=1e-6,
        )  # fmt: skip
        y, t = phase.y[:, -1], phase.t[-1]
        if phase.t_events[0].size:
            return y[2], y[3]
        side = 0 if side else int(np.sign(y[4]))


@pytest.mark.parametrize("angle_deg", [5, 20, 35, 50, 65, 80])
@pytest.mark.parametrize(("e", "mu", "gamma_t"), [(0.8, 0.38, 0.0), (0.53, 0.38, 4000.0)])
def test_oblique_impact_of_soft_tangential_springs(angle_deg, e, mu, gamma_t):
    """With wood's kt/kn = 0.065 the springs wind up and unwind within the impact and there is no
    closed form: the same law, solved by Runge-Kutta. Tolerance: the leapfrog's (omega0 dt)^2,
    ten times for its sum over an impact; here the contact starts at a whole step."""
    law, omega0 = disc_law(e, mu, 0.065, gamma_t)
    v_n, v_t = oblique(angle_deg)
    (_, v_t_out, spin), simulation, step = hit_wall(law, v_n, v_t)
    expected = by_runge_kutta(
        law, v_n, v_t, DISC_CONTACTS, mass(simulation), inertia(simulation), RADIUS
    )
    allowed = 10 * (omega0 * step) ** 2
    assert v_t_out == pytest.approx(expected[0], abs=allowed)
    assert spin * RADIUS == pytest.approx(expected[1] * RADIUS, abs=2 * allowed)


@pytest.mark.parametrize("mu", [0.05, 0.38, 1.0, 5.0])
@pytest.mark.parametrize("kt_over_kn", [0.065, 2 / 7, 1.0])
def test_no_impact_gains_energy(mu, kt_over_kn):
    """Kinetic and rotational energy do not rise at any angle, with friction alone to take it.
    Tolerance: the leapfrog's (omega0 dt)^2."""
    law, omega0 = disc_law(1.0, mu, kt_over_kn)
    for angle_deg in range(0, 90, 3):
        (v_n, v_t, spin), simulation, step = hit_wall(law, *oblique(angle_deg))
        after = v_n**2 + v_t**2 + inertia(simulation) / mass(simulation) * spin**2
        assert after < 1 + (omega0 * step) ** 2, f"at {angle_deg} deg"


def test_discs_that_roll_on_each_other_keep_their_angular_velocities():
    """Equal discs with opposite spins move alike at their contact point: no slip, no friction.
    Tolerance: the leapfrog's (omega0 dt)^2 for the 18 pairs of two cores, 1e-5."""
    law = ELASTIC._replace(mu=1.0, gamma_t=100.0)
    distance = 2 * RADIUS + 1e-6
    simulation = simulation_of(
        [disc(RADIUS), disc(RADIUS)],
        [(0.0, LEVEL, 0.0), (distance, LEVEL, 0.0)],
        law=law,
        time_step=1e-8,
    )
    launch(simulation, 0, vx=0.5, spin=300.0)
    launch(simulation, 1, vx=-0.5, spin=-300.0)
    simulation.run(5000)
    for particle, sign in ((0, 1), (1, -1)):
        assert_allclose(
            velocity(simulation, particle), [-sign * 0.5, 0.0, sign * 300.0], 1e-5, 1e-9
        )
