"""Limits of a case: contacts that a material can have, and steps that can be waited for."""

import math

from granulab.contact.laws import LinearLaw
from granulab.errors import InputError
from silo2d.case.filling import GRAVITY, Rain
from silo2d.case.settings import Settings
from silo2d.case.shape import ShapeSet
from silo2d.engine.beds.laws import CohesiveLaw, CurveLaw, curve_energy, elastic_force
from silo2d.engine.pair_law import Law

_DIAMOND = 1.2e12  # [Pa] Young's modulus of the stiffest material
_OVERDAMPED = 10.0  # damping ratio of one contact; at 1 nothing bounces any more
_DEEPEST_FALL, _DEEPEST_REST = 1.0, 0.1  # overlaps over the spheroradius, see check_softness
_MOST_STEPS = 10**11  # a hundred thousand seconds of a single particle
_MOST_IMPULSES = 10**8  # steps of pymunk, of a millisecond each or so
_MOST_FRAMES = 10**6


def check_contacts(
    laws: tuple[LinearLaw, LinearLaw], length: float, mean_mass: float, where: str
) -> None:
    """Raise InputError for a contact that no material has.

    A contact as wide as the particles are thick, through the whole prism of a length [m], has the
    stiffness of the modulus times the length. mean_mass [kg] of a particle.
    """
    stiffest = _DIAMOND * length
    for law, mass, name in zip(
        laws, (mean_mass / 2, mean_mass), ("between particles", "at walls"), strict=True
    ):
        for key, k, gamma_key, gamma in (
            ("kn", law.kn, "gamma_n", law.gamma_n),
            ("kt", law.kt, "gamma_t", law.gamma_t),
        ):
            if k > stiffest:
                raise InputError(
                    f"{where}: {key} = {k:.3g} N/m {name}: stiffer than any material; diamond, "
                    f"{_DIAMOND:.3g} Pa, in prisms of {length:g} m has at most {stiffest:.3g} N/m"
                )
            critical = 2 * math.sqrt(k / mass)
            if gamma > _OVERDAMPED * critical:
                raise InputError(
                    f"{where}: {gamma_key} = {gamma:.3g} 1/s {name}: overdamped; a contact of "
                    f"{key} = {k:.3g} N/m and {mass:.3g} kg does not bounce any more from "
                    f"{critical:.3g} 1/s on; give less"
                )


def check_softness(
    laws: tuple[Law, Law], rain: Rain, level: float, shapes: ShapeSet, where: str
) -> None:
    """Raise InputError for contacts that the silo would press too deep into each other.

    A particle that falls from the level [m] on one contact may overlap by the spheroradius (few
    fall so far, most land on more contacts; the engine takes half of it), and the column of
    material above one particle may press a tenth of it. Silos up to 1.2 and 0.15 of it ran, those
    beyond 1.8 and 0.18 failed within 20 ms. So may cohesion alone, which acts from the opening on.
    """
    energy = rain.mass * GRAVITY * level
    column = rain.mean_mass / shapes.mean_area * GRAVITY * level * 2 * shapes.bounding_radius
    resting = _DEEPEST_REST * rain.spheroradius
    for law in laws:
        if isinstance(law, CurveLaw):
            _check_curve(law, energy, column, rain.spheroradius, where)
        if isinstance(law, CohesiveLaw) and law.pull > resting * law.kn:
            raise InputError(
                f"{where}: [law] cohesion pulls particles {1e3 * law.pull / law.kn:.3g} mm into "
                f"each other; at most a tenth of the spheroradius, {1e3 * resting:.3g} mm: give "
                "less, or a larger kn"
            )
    if isinstance(laws[0], CurveLaw):
        return
    softest = min(law.kn for law in laws)
    landing = 2 * energy / (_DEEPEST_FALL * rain.spheroradius) ** 2
    needed = max(landing, column / resting)
    if softest < needed:
        digit = 10.0 ** (math.floor(math.log10(needed)) - 1)
        enough = 1e-3 * math.ceil(needed / digit) * digit
        raise InputError(
            f"{where}: kn = {1e-3 * softest:.3g} N/mm: too soft, particles would pass through each "
            f"other; give [law] kn of at least {enough:g} N/mm (and keep_ratios), a larger "
            "spheroradius or a lower [fill] level"
        )


def _check_curve(law: CurveLaw, energy: float, column: float, r: float, where: str) -> None:
    """Raise InputError for a curve that gives way too far; energy [J] of a fall, column [N]."""
    for what, unit, deep, takes, needed in (
        ("energy", "J", _DEEPEST_FALL * r, curve_energy, energy),
        ("force", "N", _DEEPEST_REST * r, elastic_force, column),
    ):
        if not takes(law, deep) >= needed:
            raise InputError(
                f"{where}: [law] kn_curve: too soft, particles would pass through each other: "
                f"{what} of {takes(law, deep):.3g} {unit} at an overlap of {1e3 * deep:.3g} mm, "
                f"where {needed:.3g} {unit} come; give a steeper one, a larger spheroradius or a "
                "lower [fill] level"
            )


def check_steps(settings: Settings, time_step: float, filling: float, where: str) -> None:
    """Raise InputError for a run of more steps, or frames, than anybody can wait for or keep.

    time_step, filling [s]: of the discharge and of the filling.
    """
    longest, output = settings.run.max_time, settings.output
    steps = [("[run] time_step", time_step, _MOST_STEPS), ("filling", filling, _MOST_STEPS)]
    if settings.run.engine == "pymunk":
        steps[0] = ("[pymunk] time_step", settings.pymunk.time_step, _MOST_IMPULSES)
    for name, step, most in steps:
        if not longest / step <= most:
            raise InputError(
                f"{where}: {name} = {step:.3g} s: {longest:g} s take {longest / step:.1e} steps, "
                f"which nobody can wait for (at most {most:.0e}); give a shorter max_time, "
                "a longer step, or softer contacts where it follows from them"
            )
    if longest < time_step:
        raise InputError(
            f"{where}: [run] max_time = {longest:.3g} s: shorter than a step of {time_step:.3g} s"
        )
    for key in ("frame_interval", "checkpoint_interval", "wall_interval"):
        interval = max(getattr(output, key) or longest, time_step)
        if not longest / interval <= _MOST_FRAMES:
            raise InputError(
                f"{where}: [output] {key} = {getattr(output, key):.3g} s: {longest / interval:.1e} "
                f"in {longest:g} s, which no disk keeps (at most {_MOST_FRAMES:.0e}); give a "
                "longer one"
            )
