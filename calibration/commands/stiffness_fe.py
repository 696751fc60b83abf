"""The command that finds kt/kn of two blocks by finite elements: stiffness-fe."""

from pathlib import Path
from typing import Any

import click

from calibration.commands.options import answers_options, figures_option, into_options
from calibration.result import Into, finish
from granulab.campaign.cli.commandline import quiet_option


@click.command("stiffness-fe", short_help="kt/kn of two blocks by finite elements")
@click.option(
    "--surface",
    type=click.Choice(["both", "flat", "rough"]),
    default="both",
    help="Which contact [default: both].",
)
@click.option(
    "--profile",
    "profiles",
    multiple=True,
    metavar="FILE",
    help="Measured profile x, z, as roughness reads it, in place of a made one.",
)
@click.option(
    "--column",
    "columns",
    multiple=True,
    metavar="NAME=HEAD",
    help='A column of it that is called otherwise: "z=Height [um]".',
)
@click.option("--roughness", metavar='"32 um"', help="Ra of a made surface [default: 31.8 um].")
@click.option("--wavelength", metavar='"1 mm"', help="Its shortest wave [default: 1 mm].")
@click.option(
    "--E",
    "--youngs-modulus",
    "youngs_modulus",
    default="242 MPa +- 15 %",
    metavar='"242 MPa +- 15 %"',
    help="[default: the paper's, across the fibres].",
)
@click.option("--nu", "--poisson", "poisson", type=float, default=0.2, help="[default: 0.2].")
@click.option(
    "--plane", type=click.Choice(["strain", "stress"]), default="strain", help="[default: strain]."
)
@click.option("--friction", type=float, help="[default: 0.37 flat, 0.2 rough].")
@click.option("--width", default="10 mm", metavar='"10 mm"', help="Of the blocks [default: 10 mm].")
@click.option("--height", default="10 mm", metavar='"10 mm"', help="Of each [default: 10 mm].")
@click.option("--depth", default="120 mm", metavar='"120 mm"', help="[default: 120 mm].")
@click.option(
    "--sides",
    type=click.Choice(["periodic", "free"]),
    default="periodic",
    help="Part of a long contact, or blocks that end there [default: periodic].",
)
@click.option("--across", metavar='"0.07 mm"', help="Travel that presses [default: Table 1].")
@click.option("--along", metavar='"0.03 mm"', help="Travel that shears [default: Table 1].")
@click.option("--random-profiles", type=click.IntRange(1, 200), help="[default: 8].")
@click.option(
    "--mesh", type=click.IntRange(16, 400), default=160, help="Columns of elements [default: 160]."
)
@click.option("--seed", type=click.IntRange(0), default=1, help="[default: 1].")
@click.option("--no-assumptions", is_flag=True, help="Do not vary what had to be assumed.")
@click.option(
    "--kn",
    metavar='"1e4 N/mm +- 18 %"',
    help="Measured kn, of which kt/kn makes kt: reported, and written by --into.",
)
@figures_option("Folder for the diagnostic figure (PNG).")
@into_options("kt")
@quiet_option
@answers_options
def command(
    out: Path | None,
    into: Into | None,
    kn: str | None,
    quiet: bool,
    as_json: bool,
    no_assumptions: bool,
    **given: Any,
) -> None:
    """kt/kn of two blocks with a flat or a rough contact, by plane finite elements (sec. 3.2.2).

    Without options it is the paper's case, as far as the paper gives it. --into writes
    kt = (kt/kn) kn of the rough contact, of the flat one with --surface flat.

    For example: calibrate stiffness-fe --roughness "12 um" --wavelength "0.8 mm" --out figures
    """
    from calibration.stiffness_fe.assumptions import applied, vary
    from calibration.stiffness_fe.measure import measure
    from calibration.stiffness_fe.result import Stiffness
    from calibration.stiffness_fe.setting import PROFILES, read_kn, read_setting

    setting, sigma_e = read_setting(given)
    known_kn = read_kn(kn, into is not None)
    wanted, seed = given["surface"], given["seed"]

    def progress(words: str) -> None:
        if not quiet:
            click.echo(f"{words} ...", err=True)

    found = measure(
        setting.case,
        None if wanted == "rough" else setting.flat,
        None if wanted == "flat" else (setting.rough, setting.surface),
        profiles=given["random_profiles"] or PROFILES,
        seed=seed,
        sigma_e=sigma_e,
        progress=progress,
    )
    rows = [] if no_assumptions or wanted != "both" else vary(setting, seed, progress)
    if rows:
        found = applied(found, rows)
    source = None if given["profiles"] else "made surfaces"
    result = Stiffness(found, rows, known_kn, source)
    finish(result, as_json=as_json, quiet=quiet, out=out, name="stiffness-fe", into=into,
           measured=given["profiles"])  # fmt: skip
