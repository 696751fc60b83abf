"""The command that turns a restitution into the damping of both contact laws: damping."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from calibration.result import Into
from granulab.campaign.cli.commandline import json_option

if TYPE_CHECKING:
    from calibration.bench.damping import Impact
    from granulab.contact.restitution import ContactEnd

_PARALLEL = (1, 2, 4, 8)  # a corner; a face on a wall; shifted faces; aligned faces
_ENDS: tuple["ContactEnd", ...] = ("overlap", "force")


@click.command(short_help="A restitution turned into the damping gamma_n")
@click.option("--restitution", metavar='"0.53 +- 0.02"', help="[default: the pair's in the file]")
@click.option("--kn", metavar='"1e4 N/mm +- 18 %"', help="Of one contact [default: likewise].")
@click.option("--mass", metavar='"10.8 g +- 6 %"', help="Of a body; the other is its like.")
@click.option("--area", metavar='"200 mm2"', help="In its place: of a prism of the material.")
@click.option("--other-mass", metavar='"12 g"', help="Of the other body, weighed by itself.")
@click.option("--wall", is_flag=True, help="The other body is a wall that does not move.")
@click.option(
    "--contacts",
    default=1,
    metavar="N",
    help="Contacts in parallel that have the restitution together [default: 1].",
)
@click.option(
    "--contact-end",
    "end",
    type=click.Choice(_ENDS),
    default="overlap",
    help="A contact ends at zero overlap, or at zero force [default: overlap].",
)
@click.option("--materials", metavar="FILE", help="Read what is not given [default: as --into].")
@click.option("--pair", metavar="wood-steel", help="Of that file.")
@click.option("--into", metavar="FILE.toml", help="Write gamma_n of the pair into this file.")
@json_option  # fmt: skip
def command(into: str | None, materials: str | None, pair: str | None, as_json: bool,
            **given: Any) -> None:  # fmt: skip
    """Turn a restitution into the damping gamma_n of one contact, with its uncertainty.

    For example: calibrate damping --restitution "0.53 +- 0.02" --kn "1e4 N/mm" --mass "10.8 g"
    --wall
    """
    from calibration.bench.damping import impact_of

    target = Into(Path(into), pair, None, ("gamma_n",)) if into else None
    if target:
        target.check()
        materials = materials or (into if target.path.exists() else None)
    impact = impact_of(materials=materials, pair=pair, **given)
    try:
        answer = _answer(impact)
    except (ValueError, OverflowError, ZeroDivisionError):  # of 1e-100, or a mass of 1e-300 g
        from granulab.errors import InputError

        raise InputError(
            f"restitution {impact.restitution.value:g}, kn {impact.kn.value:g} N/m and reduced "
            f"mass {impact.mass.value:g} kg: no number can hold the damping; check their units"
        ) from None
    answer["into"] = _put(target, impact, answer) if target else None
    click.echo(json.dumps(answer, indent=2) if as_json else _report(impact, answer))


def _answer(impact: "Impact") -> dict[str, Any]:
    """The keys of --json: numbers in the unit of the key."""
    from calibration.bench.damping import (
        damping_ratio,
        in_parallel,
        linear_damping,
        tsuji_damping_ratio,
    )

    e, n = impact.restitution, impact.contacts
    return {
        "restitution": _both(e),
        "contacts": n,
        "contact_end": impact.end,
        "kn_n_per_m": _both(impact.kn),
        "reduced_mass_kg": _both(impact.mass),
        "gamma_n_per_s": {
            end: _both(linear_damping(e, impact.kn, impact.mass, end=end, contacts=n))
            for end in _ENDS
        },
        "restitution_in_parallel": {
            end: {str(k): _both(in_parallel(e, k, of=n, end=end)) for k in _PARALLEL}
            for end in _ENDS
        },
        "damping_ratio": {end: _both(damping_ratio(e, end)) for end in _ENDS},
        "tsuji_zeta": {end: _both(tsuji_damping_ratio(e, end)) for end in _ENDS},
        "warnings": impact.remarks,
    }


def _both(value: Any) -> dict[str, float | None]:
    return {"value": value.value, "sigma": value.sigma}


def _put(target: Into, impact: "Impact", answer: dict[str, Any]) -> dict[str, Any]:
    """Write gamma_n of the chosen end of contact; the file's own words say what it came from."""
    from calibration.statistics.uncertainty import Estimate

    found = answer["gamma_n_per_s"][impact.end]
    many = "one contact" if impact.contacts == 1 else f"{impact.contacts} contacts in parallel"
    source = (
        f"restitution {_shown(answer['restitution'])} of {many}, kn "
        f"{_shown(answer['kn_n_per_m'], 1e-3)} N/mm, reduced mass "
        f"{_shown(answer['reduced_mass_kg'], 1e3)} g"
    )
    written = target.put(
        "gamma_n",
        Estimate(found["value"], found["sigma"], impact.restitution.trials or 0),
        method=f"from restitution, eq. 3.8, contact ends at zero {impact.end}",
        source=source,
    )
    return written.as_json()


def _report(impact: "Impact", answer: dict[str, Any]) -> str:
    many = "one contact" if impact.contacts == 1 else f"{impact.contacts} contacts in parallel"
    lines = [
        f"restitution   {_shown(answer['restitution'])} of {many}",
        f"kn            {_shown(answer['kn_n_per_m'], 1e-3)} N/mm",
        f"reduced mass  {_shown(answer['reduced_mass_kg'], 1e3)} g",
        "",
        f"{'the contact ends at':36}{'zero overlap':22}zero force",
        _row("gamma_n of each contact [1/s]", answer["gamma_n_per_s"]),
        _row("b, linear or Hertz (eq. 5.29, 5.30)", answer["damping_ratio"]),
        _row("zeta of Tsuji (eq. 5.31)", answer["tsuji_zeta"]),
        "restitution with that gamma_n",
    ]
    parallel = answer["restitution_in_parallel"]
    for k in _PARALLEL:
        name = "one contact" if k == 1 else f"{k} in parallel"
        lines.append(_row(f"  {name}", {end: parallel[end][str(k)] for end in _ENDS}))
    return "\n".join(lines + [f"warning: {remark}" for remark in impact.remarks])


def _row(name: str, values: dict[str, dict[str, float | None]]) -> str:
    return f"{name:36}{_shown(values['overlap']):22}{_shown(values['force'])}"


def _shown(found: dict[str, float | None], factor: float = 1.0) -> str:
    """A value with its sigma, in the unit of the report."""
    from calibration.statistics.quantity import plus_minus

    value, sigma = found["value"], found["sigma"]
    assert value is not None
    return plus_minus(factor * value, None if sigma is None else factor * sigma)
