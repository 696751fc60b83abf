"""The command that takes dissipated power and efficiency from a shaken enclosure's signals."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from calibration.commands.options import sheets_option
from granulab.campaign.cli.commandline import json_option, quiet_option
from granulab.contact.files.units import to_si

if TYPE_CHECKING:
    from calibration.shaker.measure import Dissipation, Tone
    from calibration.shaker.shaken import Record
    from calibration.statistics.uncertainty import Estimate


@click.command(short_help="Power and efficiency of a shaken enclosure")
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--empty", type=click.Path(path_type=Path), multiple=True,
    help="Record of the enclosure without particles; once for each amplitude.",
)  # fmt: skip
@click.option(
    "--frequency", type=float, multiple=True, metavar="40",
    help="That the shaker was given, in Hz; once for each tone [default: the strongest].",
)  # fmt: skip
@click.option("--particle-mass", metavar='"27.9 g"', help="For the efficiency.")
@click.option("--harmonics", type=click.IntRange(1, 50), default=5, help="Counted [default: 5].")
@click.option(
    "--column", "columns", multiple=True, metavar="NAME=HEAD",
    help='force or acceleration that is called otherwise: "force=Kraft [kN]".',
)  # fmt: skip
@click.option("--rate", type=float, metavar="40000", help="Samples/s of tables without times.")
@sheets_option("Folder for the sheet (PNG).")
@quiet_option
@json_option
def command(
    file: Path, empty: tuple[Path, ...], frequency: tuple[float, ...], particle_mass: str | None,
    harmonics: int, columns: tuple[str, ...], rate: float | None, out: Path | None, quiet: bool,
    as_json: bool,
) -> None:  # fmt: skip
    """Dissipated power and efficiency from force and acceleration (thesis, eqs 7.6 to 7.12).

    For example: calibrate shaker full.csv --empty empty.csv --particle-mass "27.9 g" -o sheets
    """
    from calibration.bench.sections import asked
    from calibration.shaker.measure import dissipation
    from calibration.shaker.shaken import INPUTS, read_record

    mass = None if particle_mass is None else to_si(particle_mass, "kg", "--particle-mass")
    called = asked(INPUTS, columns).columns
    loaded, *others = (
        read_record(path, rate=rate, frequencies=frequency, harmonics=harmonics, columns=called)
        for path in (file, *empty)
    )
    found = dissipation(loaded, others, mass)
    sheet = None if out is None else _sheet(found, loaded, out)
    if as_json:
        click.echo(json.dumps(_as_json(found) | {"sheet": sheet and str(sheet)}, indent=2))
        return
    click.echo(_report(found))
    if sheet is not None and not quiet:
        click.echo(f"sheet: {sheet}", err=True)


def _sheet(found: "Dissipation", loaded: "Record", out: Path) -> Path:
    from calibration.shaker.sheet import draw_sheet
    from granulab.campaign.output.figure import write_figure

    name = f"{loaded.path.stem}-shaker.png"
    return write_figure(out / name, lambda: draw_sheet(found, loaded))


def _as_json(found: "Dissipation") -> dict[str, object]:
    from calibration.statistics.uncertainty import as_pair

    def pair(one: "Estimate | None") -> dict[str, float | None]:
        return as_pair(one) or {"value": None, "sigma": None}

    return {
        "frequency_hz": found.frequency_hz,
        "gamma": found.gamma,
        "dissipated_power_w": pair(found.power),
        "energy_per_cycle_j": pair(found.energy_per_cycle),
        "efficiency": pair(found.efficiency),
        "enclosure_mass_kg": found.enclosure_mass_kg,
        "tones": [asdict(tone) for tone in found.tones],
        "warnings": list(found.warnings),
    }


def _report(found: "Dissipation") -> str:
    """Tones and what is made of them, as text."""
    lines = [
        "tone [Hz]    force [N]    accel. [m/s2]    phase error [mrad]    power [W]"
        "                  efficiency"
    ]
    lines += [_line(tone) for tone in found.tones]
    rows = [("gamma", f"{found.gamma:.4g} g")]
    for name, one, unit in (
        ("dissipated power", found.power, " W"),
        ("energy per cycle", found.energy_per_cycle, " J"),
        ("efficiency", found.efficiency, ""),
    ):
        rows += [(name, f"{_shown(one.value, one.sigma, '.5g')}{unit}")] if one is not None else []
    if found.enclosure_mass_kg is not None:
        rows.append(("empty enclosure", f"{found.enclosure_mass_kg:.4g} kg"))
    lines += [f"{name:20} {value}" for name, value in rows]
    return "\n".join([*lines, *(f"warning: {words}" for words in found.warnings)])


def _line(tone: "Tone") -> str:
    sigma = tone.phase_error_sigma
    phase = (
        "not known" if sigma is None else f"{1e3 * tone.phase_error_rad:8.3f} ± {1e3 * sigma:.3f}"
    )
    line = (
        f"{tone.frequency_hz:9.3f}    {tone.force_n:9.4g}    {tone.acceleration_m_s2:13.4g}    "
        f"{phase:18}    {_shown(tone.power_w, tone.sigma_w, '.4g'):<23}"
    )
    if tone.efficiency is not None:
        line += f"    {_shown(tone.efficiency, tone.efficiency_sigma, '.4f')}"
    return line.rstrip()


def _shown(value: float, sigma: float | None, form: str) -> str:
    return f"{value:{form}}" + ("" if sigma is None else f" ± {sigma:.2g}")
