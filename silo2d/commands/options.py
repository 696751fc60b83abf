"""Options of a silo and words that several commands share."""

import contextlib
from collections.abc import Callable
from typing import Any

import click

# Options of `run` that change a key of the case.
_CASE_OPTIONS = [
    ("--outlet", "silo.outlet", '"150 mm"', "Width of the outlet."),
    ("--angle", "silo.angle", '"60 deg"', "Hopper angle from the horizontal."),
    ("--fill-level", "fill.level", '"475 mm"', "Height of the filling above the outlet."),
    ("--mu-particle", "law.mu_particle", "0.38", "Friction between particles."),
    ("--mu-wall", "law.mu_wall", "0.44", "Friction at the walls."),
    ("--kn", "law.kn", '"1e4 N/mm"', "Normal stiffness of all contacts."),
    ("--kt", "law.kt", '"650 N/mm"', "Tangential stiffness of all contacts."),
    ("--gamma-n", "law.gamma_n", '"6085 1/s"', "Normal damping; the wall's scales with it."),
    ("--gamma-n-wall", "law.gamma_n_wall", '"4303 1/s"', "Normal damping at the walls."),
    ("--gamma-t", "law.gamma_t", '"3 1/s"', "Tangential damping of all contacts."),
    ("--damping", "law.damping", "published|restitution", "Where gamma_n comes from."),
    ("--contact-end", "law.contact_end", "overlap|force", "Where a contact ends."),
    ("--disorder", "disorder.per", "none|particle|pair", "Parameters drawn from pair to pair."),
    ("--time-step", "run.time_step", '"5 us"', "Chosen if not given."),
    ("--door-speed", "run.door_speed", '"0.5 m/s"', "Draw the door; else it is gone at once."),
    ("--max-time", "run.max_time", '"6 s"', "When to stop at the latest."),
    ("--shapes", "particles.shapes", "FILE", "Shape set: a shipped name or a TOML file."),
    ("--materials", "particles.materials", "FILE", "Materials: a shipped name or a TOML file."),
    ("--pour-with", "fill.pour_with", "dem|pymunk", "What fills the silo."),
    ("--engine", "run.engine", "dem|pymunk", "What moves the particles."),
    ("--iterations", "pymunk.iterations", "30", "Of pymunk, a step."),
    ("--pymunk-time-step", "pymunk.time_step", '"0.25 ms"', "Of pymunk."),
]


def case_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The options that change a key of a case, and --seed."""
    for flag, key, example, text in reversed(_CASE_OPTIONS):
        command = click.option(flag, key.replace(".", "__"), metavar=example, help=text)(command)
    command = click.option("--mu", metavar="0.4", help="Friction of all contacts.")(command)
    command = click.option(
        "--keep-ratios", is_flag=True, help="kt goes with kn, and gamma_n with its root."
    )(command)
    return click.option("--seed", metavar="1", help="Seed of the filling [default: 1].")(command)


def changes_of(
    seed: str | None, mu: str | None, keep_ratios: bool, options: dict
) -> dict[str, Any]:
    """The keys of the case that the options change, as they would stand in a file."""
    changes = {k.replace("__", "."): v for k, v in options.items() if v is not None}
    if mu is not None:
        changes = {"law.mu_particle": mu, "law.mu_wall": mu} | changes
    if keep_ratios:
        changes["law.keep_ratios"] = True
    if seed is not None:
        changes["run.seed"] = seed
        with contextlib.suppress(ValueError):  # no number: the case refuses it as any other key
            changes["run.seed"] = int(seed)
    return changes
