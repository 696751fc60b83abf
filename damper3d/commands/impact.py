"""The command that lets one sphere hit something: impact."""

import json
import math
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from damper3d.studies.single_contact.spheres.impact import Impact, Outcome


@click.command()
@click.option("--material", metavar="acrylic|FILE", help="Of the sphere [default: acrylic].")
@click.option("--youngs-modulus", metavar='"3.3 GPa"', help="Of the sphere, in place of its own.")
@click.option("--poisson", metavar="0.37", help="Poisson's ratio, likewise.")
@click.option("--density", metavar='"1190 kg/m3"', help="Likewise.")
@click.option("--yield-strength", metavar='"125 MPa"', help="Likewise.")
@click.option("--radius", metavar='"2.5 mm"', help="Of the sphere [default: 2.5 mm].")
@click.option("--speed", metavar="3.9", help="Relative, in m/s [default: 3.9].")
@click.option("--angle", metavar="0", help="From the line of centres, in degrees [default: 0].")
@click.option(
    "--spin", metavar="0", help="Angular velocity before, in rad/s; positive rolls forwards."
)
@click.option("--other-spin", metavar="0", help="Of the other sphere, likewise.")
@click.option(
    "--against", default="wall", metavar="wall|rigid-wall|sphere|MATERIAL",
    help="A wall or equal sphere of its material, or a wall of another [default: wall].",
)  # fmt: skip
@click.option("--restitution", metavar="0.86", help="[default: the pair's in the materials file]")
@click.option("--friction", metavar="0.52", help="[default: the pair's in the materials file]")
@click.option(
    "--tangential", metavar="displacement|force|mindlin-deresiewicz",
    help="Quantity that the spring carries on, or the exact law [default: displacement].",
)  # fmt: skip
@click.option("--no-tangential-damping", is_flag=True, help="Leave the tangential dashpot out.")
@click.option("--contact-end", "end", metavar="overlap|force", help="[default: overlap]")
@click.option(
    "--damping", metavar="published|restitution",
    help="By eq. 5.32, or so that the restitution comes out at --contact-end force, too.",
)  # fmt: skip
@click.option("--yielding", is_flag=True, help="Restitution falls above the yield velocity.")
@click.option("--quiet", is_flag=True, help="Print nothing but the result.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def impact(
    against: str, no_tangential_damping: bool, yielding: bool, quiet: bool, as_json: bool,
    **given: str | None,
) -> None:  # fmt: skip
    """Let a sphere hit a wall or an equal sphere once, without gravity.

    For example: damper3d impact --material alumina --speed 3.9 --angle 40
    """
    from damper3d.studies.single_contact.spheres.impact import doubts, run
    from damper3d.studies.single_contact.spheres.impact_input import impact_of

    flags = {"tangential_damping": not no_tangential_damping, "yielding": yielding}
    described, remarks = impact_of(given, against=against, flags=flags)
    if not quiet:
        click.echo("\n".join([*remarks, _echo(described, against)]), err=True)
    outcome = run(described)
    warnings = doubts(described, outcome)
    if not quiet:
        for line in warnings:
            click.echo(f"warning: {line}", err=True)
    if as_json:
        found = _used(described) | outcome.as_json() | {"warnings": warnings}
        click.echo(json.dumps(found, indent=2))
    else:
        click.echo(_report(outcome))


def _used(impact: "Impact") -> dict[str, object]:
    """The values used, which a default or a file may have given."""
    names = {
        "speed": "speed_m_s", "radius": "radius_m", "end": "contact_end",
        "spin": "spin_before_rad_s", "other_spin": "other_spin_before_rad_s",
    }  # fmt: skip
    keys = (*names, "friction", "restitution", "tangential", "damping", "yielding")
    used = {names.get(key, key): getattr(impact, key) for key in keys}
    return {
        "material": impact.first.name,
        "against": "sphere" if impact.sphere else "wall",
        "against_material": impact.second.name if impact.second else None,
        "angle_deg": math.degrees(impact.angle),
        **used,
    }


def _echo(impact: "Impact", against: str) -> str:
    other = {"rigid-wall": "a rigid wall", "wall": "a wall of it", "sphere": "its like"}
    second = f" and {impact.other_spin:g}" if impact.sphere else ""
    return (
        f"sphere of {impact.first.name}, radius {1e3 * impact.radius:g} mm, on "
        f"{other.get(against, f'a wall of {against}')}: {impact.speed:g} m/s at "
        f"{math.degrees(impact.angle):g} deg, angular velocity {impact.spin:g}{second} rad/s, "
        f"restitution {impact.restitution:g}, damping {impact.damping}, friction "
        f"{impact.friction:g}, tangential {impact.tangential}, ends at zero {impact.end}"
    )


def _report(outcome: "Outcome") -> str:
    rows = [
        ("normal restitution", f"{outcome.normal_restitution:.4f}"),
        ("tangential restitution", _or_none(outcome.tangential_restitution)),
        ("angular velocity", f"{outcome.spin_rad_s:.4g} rad/s"),
        ("contact point leaves at", f"{outcome.contact_point_rebound_deg:.2f} deg"),
        ("contact time", f"{1e6 * outcome.contact_time_s:.4g} us"),
        ("largest overlap", f"{1e6 * outcome.max_overlap_m:.4g} um"),
        ("largest force", f"{outcome.max_force_n:.4g} N"),
        ("dissipated", f"{outcome.dissipated_j:.4g} J"),
        ("  normal damping", f"{outcome.normal_damping_j:.4g} J"),
        ("  tangential damping", f"{outcome.tangential_damping_j:.4g} J"),
        ("  friction", f"{outcome.friction_j:.4g} J"),
        ("  changing stiffness", f"{outcome.law_term_j:.4g} J"),
        ("time step", f"{outcome.time_step_s:.3g} s"),
    ]
    return "\n".join(f"{name:24} {value}" for name, value in rows)


def _or_none(value: float | None) -> str:
    return "-" if value is None else f"{value:.4f}"
