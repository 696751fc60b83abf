"""Options that several commands of damper3d share."""

import contextlib
from collections.abc import Callable
from typing import Any

import click

# Options of `run` that change a key of the case.
_CASE_OPTIONS = [
    ("--frequency", "motion.frequency", "40", "Of the motion, in Hz, or with a unit."),
    ("--gamma", "motion.gamma", "20", "Largest acceleration of the enclosure, in g."),
    ("--orientation", "motion.orientation", "vertical|horizontal|none", "Of axis and gravity."),
    ("--ramp", "motion.ramp", "0", "Cycles over which the amplitude grows."),
    (
        "--particles", "particles.shape", "sphere:5mm|prolate:1.5|oblate:0.7|toroid:0.2|mesh:FILE",
        "What moves inside: spheres by diameter, shapes by ratio; see damper3d shape --help.",
    ),
    ("--sub-spheres", "particles.sub_spheres", "N", "That stand for one particle."),
    ("--tolerance", "particles.tolerance", "0.02", "Or their surface error over that radius."),
    ("--mesh-unit", "particles.mesh_unit", "mm", "Of a mesh that keeps its size."),
    (
        "--equal-volume-radius", "particles.equal_volume_radius", '"3.8 mm"',
        "Size of a shape named without one.",
    ),
    ("--count", "particles.count", "N", "Number of particles [default: the thesis's fill ratio]."),
    ("--diameter", "enclosure.diameter", '"40 mm"', "Of a cylinder, inside."),
    ("--height", "enclosure.height", '"40 mm"', "Along the axis, inside."),
    ("--density", "law.density", '"1.19 g/cm3"', "Of the particles."),
    ("--youngs-modulus", "law.youngs_modulus", '"3.3 GPa"', "Of particles and walls."),
    ("--friction", "law.friction", "0.52", "Of all contacts."),
    ("--friction-wall", "law.friction_wall", "0.52", "Of contacts with the walls."),
    ("--restitution", "law.restitution", "0.86", "Of all contacts."),
    ("--restitution-wall", "law.restitution_wall", "0.86", "Of contacts with the walls."),
    (
        "--contact-treatment", "law.contact_treatment", "sum|deepest|scaled",
        "Of several contacts of one pair of particles of sub-spheres.",
    ),
    ("--tangential", "law.tangential", "displacement|force", "What the spring carries on."),
    ("--contact-end", "law.contact_end", "overlap|force", "Where a contact ends."),
    ("--cycles", "run.cycles", "8", "How many [default: 8, of other shapes than spheres 18]."),
    ("--discard", "run.discard", "3", "How many of them do not count."),
    ("--max-cycles", "run.max_cycles", "60", "At most, with --steady."),
    ("--time-step", "run.time_step", '"1 us"', "Chosen if not given."),
    ("--samples", "output.samples", "100", "Energies and forces a cycle."),
    ("--frames", "output.frames", "20", "All particles and contacts a cycle; 0: none."),
    ("--keep", "output.keep", "all|summary", "What stays in the run folder."),
]  # fmt: skip
# Options that are yes where they stand.
_FLAGS = [
    ("--steady", "run.steady", "Go on until the answer is steady."),
    ("--wall-curvature", "law.wall_curvature", "The contact law knows that the side is round."),
    ("--yielding", "law.yielding", "Restitution falls above the yield velocity."),
]


def case_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The options that change a key of a case, --material and --seed."""
    for flag, key, text in reversed(_FLAGS):
        command = click.option(flag, key.replace(".", "__"), is_flag=True, help=text)(command)
    for flag, key, example, text in reversed(_CASE_OPTIONS):
        command = click.option(flag, key.replace(".", "__"), metavar=example, help=text)(command)
    command = click.option(
        "--material", metavar="acrylic|FILE", help="Of particles and walls: a shipped table or one."
    )(command)
    return click.option("--seed", metavar="1", help="Seed of the filling [default: 1].")(command)


def changes_of(
    seed: str | None, material: str | None, options: dict[str, str | bool | None]
) -> dict[str, Any]:
    """The keys of the case that the options change, as they would stand in a file."""
    changes: dict[str, Any] = {
        key.replace("__", "."): value
        for key, value in {**options, "run__seed": seed}.items()
        if value is not None and value is not False
    }
    for key in ("run.seed", "particles.count", "particles.sub_spheres", "run.cycles",
                "run.discard", "run.max_cycles", "output.samples", "output.frames"):  # fmt: skip
        with contextlib.suppress(KeyError, ValueError):  # the case refuses what is no number
            changes[key] = int(changes[key])
    if material is not None:
        from damper3d.case.parameters import named_material

        changes |= named_material(material)
    return changes
