"""Commands of the bench: one for each method that reads tables, made from the table of methods.

damping converts a restitution into damping, published calculates the sources' measurements again.
"""

import importlib
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from calibration import methods
from calibration.commands.options import (
    answers_options,
    figures_option,
    fps_option,
    into_options,
    roi_option,
)
from calibration.methods import METHODS, Inputs
from calibration.result import Into, draw, finish
from granulab.campaign.cli.commandline import quiet_option
from granulab.errors import InputError

if TYPE_CHECKING:
    from calibration.bench.measure import Measurement

_PAIR = re.compile(r"[^\W\d]\w*-[^\W\d]\w*")  # two materials, as a parameter file names a pair

Decorator = Callable[[Callable[..., Any]], Callable[..., Any]]


@dataclass(frozen=True)
class Command:
    """Command of a method of the bench, which has the method's name (calibration.methods).

    help       what --help says; the columns that the method reads follow it
    options    of its own
    files      at least one is needed
    films      films are read, too
    """

    help: str
    options: tuple[Decorator, ...] = ()
    files: bool = True
    films: bool = False


_TRIAL = click.option(
    "--trial", metavar="HEAD",
    help='Column that distinguishes curves in one file [default: "trial", if there is one].',
)  # fmt: skip

_FILM = (fps_option, roi_option("Part of a film's picture to look at, in pixels."))

COMMANDS = {
    "heights": Command(
        """Restitution from heights of drop and rebound, e = sqrt(H1/H0) (eqs 3.5, 3.6).

        A row a trial, a column a drop height, or means with standard deviations; CSV or a
        spreadsheet.

        For example: calibrate heights drops.xlsx --reading "h1=2 mm"
        """,
    ),
    "incline": Command(
        """Friction from the angle of first slip, mu = tan(alpha), from tables or films.

        A row a trial, or a film of a plate that is tilted until a block on it slips.

        For example: calibrate incline tilt.csv --group pairing --instrument "angle=0.2 deg"

        calibrate incline tilt1.mp4 tilt2.mp4 --start-angle "0 deg"
        """,
        (
            click.option(
                "--length-along", "along", type=click.Choice(["slope", "base"]), default="slope",
                help="Where L was measured [default: slope, sin(alpha) = |H1 - H2|/L].",
            ),
            *_FILM,
            click.option(
                "--start-angle", metavar='"0 deg"',
                help="Inclination of a film's plate in its first frame, by a level "
                "[default: from the picture's rows].",
            ),
        ),
        films=True,
    ),
    "slide": Command(
        """Tangential damping gamma_t of a sliding block (eqs 3.11a-c), from tables or films.

        A curve v(t) or x(t), a row a trial, or a film of a block that slides down a plate.

        For example: calibrate slide run1.csv run2.csv --constant "incline=30 deg +- 0.5 deg"

        calibrate slide slide.mp4 --scale "0.5 mm/px" --fps 100
        """,
        (
            _TRIAL,
            click.option(
                "--start", type=click.Choice(["rest", "any"]), default="rest",
                help="From rest at t = 0, eq. 3.11b, or at any velocity there [default: rest].",
            ),
            *_FILM,
            click.option("--scale", metavar='"0.5 mm/px"', help="Length of a pixel of a film."),
        ),
        films=True,
    ),
    "compression": Command(
        """Unloading stiffness of each cycle, modulus, and kn = E A/L.

        A record a trial.

        For example: calibrate compression cube*.csv --constant "area=100 mm2" --constant
        "length=10 mm"

        Without a file: calibrate compression --constant "modulus=242 MPa +- 15 %" --constant
        "contact_area=1200 mm2" --constant "contact_length=20 mm"
        """,
        (
            _TRIAL,
            click.option(
                "--range", "share", nargs=2, type=float, default=(0.95, 0.5), metavar="UPPER LOWER",
                help="Shares of each fall of the load that the slope is fitted to "
                "[default: 0.95 0.5].",
            ),
            click.option(
                "--least-cycle", type=float, default=0.1, metavar="SHARE",
                help="A fall by less than this share of the range of the load is no cycle "
                "[default: 0.1].",
            ),
        ),
        files=False,
    ),
    "interface": Command(
        """kt/kn from displacements and stresses next to an interface.

        kt/kn = (sigma_t/sigma_n) (dx_n/dx_t), eq. 3.3; a row a marker.

        For example: calibrate interface markers.csv --group surface --reading "dx_t=0.003 mm"
        """,
    ),
    "roughness": Command(
        """Mean roughness Ra of profiles z(x).

        Ra = (1/L) integral |z| dx, thesis eq. 7.1; a path a trial.

        For example: calibrate roughness paths.csv --trial path --group particle --form circle
        """,
        (
            _TRIAL,
            click.option(
                "--form", type=click.Choice(["mean", "line", "parabola", "circle"]), default="line",
                help="Form that is taken off the profile first, by least squares [default: line].",
            ),
        ),
    ),
    "density": Command(
        """Density, mass over volume, from masses and sizes.

        A row a particle.

        For example: calibrate density weighed.csv --instrument "mass=0.01 g"
        """,
    ),
}  # fmt: skip

_INPUT_OPTIONS = (
    click.option(
        "--column", "columns", multiple=True, metavar="NAME=HEAD",
        help='A column that is called otherwise, with its unit if it lacks one: "load=Force [kN]".',
    ),
    click.option(
        "--constant", "constants", multiple=True, metavar="NAME=VALUE",
        help='Value that all trials share, instead of a column: "length=300 mm +- 1 mm".',
    ),
    click.option(
        "--instrument", "instruments", multiple=True, metavar="NAME=SIGMA",
        help='Uncertainty of an input that all trials share, such as a zero: "angle=0.2 deg".',
    ),
    click.option(
        "--reading", "readings", multiple=True, metavar="NAME=SIGMA",
        help="Uncertainty of an input that differs from trial to trial.",
    ),
    click.option(
        "--group", metavar="HEAD",
        help='Column that distinguishes pairings [default: "group" or "pairing", if there is one].',
    ),
    click.option("--only", metavar="GROUP", help="Evaluate this group and no other."),
    figures_option("Folder for the diagnostic figure (PNG)."),
    quiet_option,
    answers_options,
)  # fmt: skip


class _Columns(click.Command):
    """A command whose help ends with the columns of its method, read when help is requested."""

    def format_help_text(self, context: click.Context, formatter: click.HelpFormatter) -> None:
        """Write help and columns as they stand: click keeps a block that begins with \\b."""
        plain = self.help
        inputs = _module(self.name or "").INPUTS
        width = max(len(one.name) for one in inputs)
        head = "Columns (any unit of the kind; written in the head or as load_N):"
        lines = [f"  {one.name:{width}}  [{one.unit:4}]  {one.meaning}" for one in inputs]
        self.help = "\n".join([f"{plain}\n\n\b", head, *lines])
        super().format_help_text(context, formatter)
        self.help = plain


def _module(name: str) -> Any:
    return importlib.import_module(f"calibration.bench.{name}")


def _command(name: str, method: Command) -> click.Command:
    """Make the command of a method: read the options, measure, write and show the result."""
    writes = METHODS[name].writes

    def run(
        files: tuple[str, ...], columns: tuple[str, ...], constants: tuple[str, ...],
        instruments: tuple[str, ...], readings: tuple[str, ...], group: str | None,
        only: str | None, out: Path | None, quiet: bool, as_json: bool, into: Into | None = None,
        **own: Any,
    ) -> None:  # fmt: skip
        inputs = Inputs(columns=columns, constants=constants, instruments=instruments,
                        readings=readings, group=group, only=only)  # fmt: skip
        result = replace(_measured(name, method, files, inputs, quiet, own), brief=quiet)
        first = result.quantities[0]
        if into is not None:
            _refuse_several_pairs(into, first.pooled.groups)
        stem = Path(files[0]).stem if files else "constants"
        sheets = [] if out is None else [
            draw(one, out / f"{name}-{one.name}-film.png") for one in first.films
        ]  # fmt: skip
        finish(
            result, as_json=as_json, quiet=quiet, out=out, name=f"{name}-{stem}", into=into,
            measured=files, files={"films": sheets} if sheets else None,
        )  # fmt: skip

    command: Callable[..., Any] = run
    for option in reversed(method.options):
        command = option(command)
    if writes:
        command = into_options(*writes)(command)
    for option in reversed(_INPUT_OPTIONS):
        command = option(command)
    argument = click.argument("files", nargs=-1, required=method.files, metavar="FILE...")
    return click.command(name, cls=_Columns, help=method.help)(argument(command))


def _measured(
    name: str, method: Command, files: tuple[str, ...], inputs: Inputs, quiet: bool,
    own: dict[str, Any],
) -> "Measurement":  # fmt: skip
    """The result of a method; its progress is shown where it reads films."""
    measure = getattr(methods, f"measure_{name}")
    if not method.films:
        return measure(files, **own, **inputs)
    from granulab.campaign.output.terminal import Progress

    with Progress(name, quiet) as progress:
        return measure(files, progress=progress.update, **own, **inputs)


def _refuse_several_pairs(into: Into, groups: Iterable[str]) -> None:
    """InputError where the mean over pairs of materials would be written into one of them."""
    pairs = [group for group in groups if _PAIR.fullmatch(group)]
    if into.pair is not None and len(pairs) > 1:
        raise InputError(
            f"--into {into.path}: the trials are of {' and '.join(pairs)}; say which of them goes "
            f"into {into.pair}: --only {pairs[0]}"
        )


@click.command(short_help="The damping gamma_n of a restitution")
@click.option("--restitution", metavar='"0.53 +- 0.02"', help="[default: the pair's in the file]")
@click.option("--kn", metavar='"1e4 N/mm +- 18 %"', help="Of one contact [default: likewise].")
@click.option("--mass", metavar='"10.8 g +- 6 %"', help="Of a particle; the other is its like.")
@click.option("--area", metavar='"200 mm2"', help="Instead: of a prism of the material.")
@click.option("--other-mass", metavar='"12 g"', help="Of the other particle, weighed by itself.")
@click.option("--wall", is_flag=True, help="The other one is a wall that does not move.")
@click.option(
    "--contacts",
    default=1,
    metavar="N",
    help="Contacts in parallel that have the restitution together [default: 1].",
)
@click.option(
    "--contact-end",
    "end",
    type=click.Choice(["overlap", "force"]),
    default="overlap",
    help="A contact ends at zero overlap, or at zero force [default: overlap].",
)
@click.option("--materials", metavar="FILE", help="Read what is not given [default: as --into].")
@click.option("--pair", metavar="wood-steel", help="Of that file.")
@click.option("--into", metavar="FILE.toml", help="Write gamma_n of the pair into this file.")
@answers_options  # fmt: skip
def damping(into: str | None, materials: str | None, pair: str | None, as_json: bool,
            **given: Any) -> None:  # fmt: skip
    """Convert a restitution into the damping gamma_n of one contact, with its uncertainty.

    For example: calibrate damping --restitution "0.53 +- 0.02" --kn "1e4 N/mm" --mass "10.8 g"
    --wall
    """
    from calibration.bench.damping import damping as converted

    target = Into(Path(into), pair, None, ("gamma_n",)) if into else None
    if target:
        target.check()
        materials = materials or (into if target.path.exists() else None)
    result = converted(materials=materials, pair=pair, **given)
    if target:
        one = result.parameters()["gamma_n"]
        written = target.put("gamma_n", one.estimate, method=one.method, source=one.source)
        result = replace(result, written=written.as_json())
    finish(result, as_json=as_json, figure_key=None)


@click.command("published", short_help="The sources' measurements, calculated again")
@click.argument("tables", nargs=-1, metavar="[TABLE]...")
@answers_options
def published(tables: tuple[str, ...], as_json: bool) -> None:
    """The sources' bench measurements compared with what follows from their own parts.

    Tables: friction, restitution, interface, stiffness, damping, density, roughness; all of them
    where none is named. Only means are printed but for the interface's markers: single trials,
    curves and profiles cannot be evaluated again.
    """
    from calibration.published import published as calculated

    finish(calculated(tables), as_json=as_json, figure_key=None)


commands = {name: _command(name, method) for name, method in COMMANDS.items()} | {
    "damping": damping,
    "published": published,
}
