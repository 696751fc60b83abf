"""One impact of a sphere on a wall or on an equal sphere, without gravity: what it leaves.

The contact law is that of the damper's engine, or the exact one of Mindlin and Deresiewicz in
place of its tangential part.
"""

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from damper3d.case.oscillation import DEEPEST
from damper3d.engine.spheres import collision
from damper3d.engine.spheres.collision import Bodies, Meeting, collide
from granulab.contact.hertz import HertzLaw, damping_of_impact
from granulab.contact.material import Material
from granulab.contact.mindlin_deresiewicz import N_SPRINGS
from granulab.contact.reduced import reduced_mass, reduced_radius, sphere_mass
from granulab.contact.restitution import ContactEnd, ratio_of_restitution, restitution_of_ratio
from granulab.contact.sphere_law import damping_ratio, sphere_law
from granulab.errors import InputError

Tangential = Literal["displacement", "force", "mindlin-deresiewicz"]
DampingFrom = Literal["published", "restitution"]

STEPS_PER_CONTACT = 20_000  # of an elastic one; results hold to about 1e-4
_LONGEST = 40  # elastic contact times; a damped contact takes longer
_ROWS_PER_CONTACT = 500  # of the history


@dataclass(frozen=True)
class Impact:
    """Bodies that meet, their speed, and the contact law.

    The sphere of material `first` comes along z onto a wall, or an equal sphere, of material
    `second` (None: a rigid wall). Angular velocities are about y, positive where the sphere rolls
    forwards. With an equal sphere speeds are relative, and the centre of mass rests.
    """

    first: Material
    second: Material | None
    sphere: bool = False  # whether the second is a sphere too
    radius: float = 2.5e-3  # [m]
    speed: float = 3.9  # relative [m/s]
    angle: float = 0.0  # from the line of centres [rad], below pi/2
    spin: float = 0.0  # of the first [rad/s]
    other_spin: float = 0.0  # of the second, where it is a sphere [rad/s]
    friction: float = 0.0
    restitution: float = 1.0
    tangential: Tangential = "displacement"
    tangential_damping: bool = True
    end: ContactEnd = "overlap"
    # "published": eqs 5.32 and 5.33 as they are; "restitution": the damping that gives the
    # restitution where the contact ends at zero force, too.
    damping: DampingFrom = "published"
    yielding: bool = False  # restitution falls above the yield velocity

    def __post_init__(self) -> None:
        if not 0.0 <= self.angle < math.pi / 2 - 1e-9:
            raise InputError(
                f"angle = {math.degrees(self.angle):g} deg: must be from 0 to below 90"
            )
        for name, unit in (("radius", "m"), ("speed", "m/s")):
            value = getattr(self, name)
            if not 0.0 < value < math.inf:
                raise InputError(f"{name} = {value:g} {unit}: must be above 0")
        if not 0.0 <= self.friction < math.inf:
            raise InputError(f"friction = {self.friction:g}: must be at least 0")
        damping_ratio(self.restitution)  # refuses one that is none

    @property
    def law(self) -> HertzLaw:
        """The law of this pair; InputError where a material lacks a constant."""
        return sphere_law(
            self.first,
            self.second,
            friction=self.friction,
            restitution=self.restitution,
            end=self.end,
            tangential="force" if self.tangential == "force" else "displacement",
            tangential_damping=self.tangential_damping,
            yielding=self.yielding,
        )

    @property
    def mass(self) -> float:
        """Mass of one sphere [kg]."""
        return sphere_mass(self.radius, self.first.density.value)


@dataclass(frozen=True)
class Outcome:
    """Results of an impact. Speeds after it are along and across the line of centres then."""

    normal_restitution: float  # leaving over arriving normal speed [-]
    tangential_restitution: float | None  # tangential speed after over before [-]
    spin_rad_s: float  # of the first sphere
    other_spin_rad_s: float | None  # of the second
    contact_point_rebound_deg: float | None  # of the surface, from the line of centres
    contact_time_s: float  # until there is no overlap, or no force
    max_overlap_m: float
    max_force_n: float  # normal
    dissipated_j: float  # kinetic energy lost, of translation and rotation
    normal_damping_j: float
    tangential_damping_j: float
    friction_j: float
    law_term_j: float  # gained by the tangential spring of the law, which has no potential
    max_force_ratio: float  # tangential over normal force, at most the friction [-]
    max_tilt: float  # cosine of the angle between tangential force and line of centres
    momentum_error: float | None  # linear, relative; None against a wall, which takes momentum
    angular_momentum_error: float | None  # relative; likewise
    time_step_s: float
    steps: int
    history: np.ndarray  # (n, 5), columns of collision.py

    def as_json(self) -> dict[str, Any]:
        """All but the history."""
        return {key: value for key, value in vars(self).items() if key != "history"}


def run(impact: Impact, steps_per_contact: int = STEPS_PER_CONTACT) -> Outcome:
    """Integrate an impact.

    Raises InputError where a material lacks a constant, or spheres would pass their centres.
    """
    law = impact.law
    meeting = _meeting(impact, law)
    bodies = _bodies(impact)
    before = _state(impact, bodies)
    deepest = hertz_overlap(meeting, impact.speed * math.cos(impact.angle))
    if deepest >= impact.radius:
        raise InputError(
            f"speed = {impact.speed:g} m/s: an overlap of {1e3 * deepest:.3g} mm is more than the "
            f"radius of {1e3 * impact.radius:g} mm; give a lower speed, or a stiffer material"
        )
    dt = hertz_contact_time(meeting, impact.speed * math.cos(impact.angle)) / steps_per_contact
    n_springs = N_SPRINGS if impact.tangential == "mindlin-deresiewicz" else 0
    # A contact area a little larger than an elastic impact's: rotation adds next to nothing.
    reach = 1.05 * math.sqrt(meeting.reduced_radius * deepest)
    rows = np.full((_LONGEST * min(_ROWS_PER_CONTACT, steps_per_contact), 5), np.nan)
    most = _LONGEST * steps_per_contact
    totals, steps = collide(law, meeting, bodies, np.zeros((n_springs, 3)), reach, dt, most, rows)
    if steps == most:
        raise InputError(
            f"restitution = {impact.restitution:g}: the spheres do not part within {_LONGEST} "
            "contact times; give a larger one"
        )
    return _outcome(impact, before, _state(impact, bodies), totals, dt, steps, rows)


def doubts(impact: Impact, outcome: Outcome) -> list[str]:
    """Lines on what the law is not meant for."""
    part = outcome.max_overlap_m / impact.radius
    if part <= DEEPEST:
        return []
    return [
        f"the overlap is {part:.2g} of the radius: Hertz's law is for small ones, up to {DEEPEST:g}"
    ]


def hertz_overlap(meeting: Meeting, speed: float) -> float:
    """Deepest overlap [m] of an elastic impact, (5 m v^2/(4 K))^0.4; eq. 5.8."""
    return (1.25 * meeting.reduced_mass * speed**2 / meeting.hertz) ** 0.4


def hertz_contact_time(meeting: Meeting, speed: float) -> float:
    """Time of an elastic contact [s], 2.9433 times the deepest overlap over the speed."""
    return 2.9433 * hertz_overlap(meeting, speed) / speed


def _meeting(impact: Impact, law: HertzLaw) -> Meeting:
    inverse = 1.0 / impact.mass
    other = inverse if impact.sphere else 0.0
    radius = reduced_radius(1.0 / impact.radius, 1.0 / impact.radius if impact.sphere else 0.0)
    mass = reduced_mass(inverse, other)
    hertz = law.hertz * math.sqrt(radius)
    per_mass = 2.5 / impact.radius**2
    damping = damping_of_impact(law, hertz, mass, impact.speed * math.cos(impact.angle))
    if impact.damping == "restitution":
        damping = ratio_of_restitution(restitution_of_ratio(damping), impact.end)
    return Meeting(
        radius=(impact.radius, impact.radius if impact.sphere else 0.0),
        inverse_mass=(inverse, other),
        inverse_inertia=(per_mass * inverse, per_mass * other),
        reduced_radius=radius,
        reduced_mass=mass,
        hertz=hertz,
        damping=damping,
    )


def _bodies(impact: Impact) -> Bodies:
    r, v, w = np.zeros((2, 3)), np.zeros((2, 3)), np.zeros((2, 3))
    r[0, 2] = impact.radius
    arriving = impact.speed * np.array([math.sin(impact.angle), 0.0, -math.cos(impact.angle)])
    w[0, 1] = impact.spin
    if impact.sphere:
        r[1, 2] = -impact.radius
        v[0], v[1] = 0.5 * arriving, -0.5 * arriving
        w[1, 1] = impact.other_spin
    else:
        v[0] = arriving
    return Bodies(r, v, w, np.zeros((2, 3)), np.zeros((2, 3)))


@dataclass(frozen=True)
class _State:
    """Quantities that are compared before and after."""

    normal: float  # speed of parting along the line of centres [m/s]
    tangential: float  # of the first relative to the second, across it [m/s]
    angular_velocities: tuple[float, float]  # [rad/s]
    energy: float  # kinetic [J]
    momentum: np.ndarray  # [kg m/s]
    angular: float  # angular momentum about the origin, along y [kg m2/s]


def _state(impact: Impact, bodies: Bodies) -> _State:
    x, v, w = bodies.position, bodies.velocity, bodies.spin
    m, inertia = impact.mass, 0.4 * impact.mass * impact.radius**2
    up = (x[0] - x[1]) / np.linalg.norm(x[0] - x[1]) if impact.sphere else np.array([0.0, 0, 1])
    across = np.cross([0.0, 1.0, 0.0], up)
    apart = v[0] - v[1]
    return _State(
        float(apart @ up),
        float(apart @ across),
        (float(w[0, 1]), float(w[1, 1])),
        float(0.5 * m * np.sum(v**2) + 0.5 * inertia * np.sum(w**2)),
        m * v.sum(axis=0),
        float(m * np.cross(x, v)[:, 1].sum() + inertia * w[:, 1].sum()),
    )


def _outcome(
    impact: Impact, before: _State, after: _State, totals: np.ndarray, dt: float, steps: int,
    rows: np.ndarray,
) -> Outcome:  # fmt: skip
    slide = after.tangential - impact.radius * sum(after.angular_velocities)
    moves = before.tangential > 0.0 and impact.angle > 0.0
    scale = impact.mass * impact.speed
    momentum = scale * impact.radius + 0.4 * impact.mass * impact.radius**2 * abs(impact.spin)
    shift = float(np.abs(after.momentum - before.momentum).max())
    gained = abs(after.angular - before.angular)
    return Outcome(
        normal_restitution=-after.normal / before.normal,
        tangential_restitution=after.tangential / before.tangential if moves else None,
        spin_rad_s=after.angular_velocities[0],
        other_spin_rad_s=after.angular_velocities[1] if impact.sphere else None,
        contact_point_rebound_deg=math.degrees(math.atan2(slide, after.normal)),
        contact_time_s=float(totals[collision.CONTACT_TIME]),
        max_overlap_m=float(totals[collision.MAX_OVERLAP]),
        max_force_n=float(totals[collision.MAX_FORCE]),
        dissipated_j=before.energy - after.energy,
        normal_damping_j=float(totals[collision.NORMAL_DAMPING]),
        tangential_damping_j=float(totals[collision.TANGENTIAL_DAMPING]),
        friction_j=float(totals[collision.FRICTION]),
        law_term_j=float(totals[collision.LAW_TERM]),
        max_force_ratio=float(totals[collision.MAX_RATIO]),
        max_tilt=float(totals[collision.MAX_TILT]),
        momentum_error=shift / scale if impact.sphere else None,
        angular_momentum_error=gained / momentum if impact.sphere else None,
        time_step_s=dt,
        steps=steps,
        history=rows[np.isfinite(rows[:, 0])],
    )
