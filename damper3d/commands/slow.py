"""The commands that press and shear a bed slowly: shear and compress."""

import json
import re
import shlex
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from damper3d.commands.options import case_command, changes_of, material_option
from granulab.campaign.cli.commandline import engine_options, json_option, out_option, quiet_option
from granulab.campaign.cli.many import stop_unless_whole
from granulab.campaign.output.layout import stopped

if TYPE_CHECKING:
    from granulab.campaign.sweeps.sweep import Labelled

# Keys of the particles' case that options change, and what holds for these tests besides.
_OF_PARTICLES = {
    "particles.equal_volume_radius": "",
    "particles.sub_spheres": "",
    "particles.tolerance": "",
    "particles.count": " [default: 100]",
    "law.density": "",
    "law.youngs_modulus": "",
    "law.friction": "",
    "law.friction_wall": "",
    "law.restitution": "",
    "law.restitution_wall": "",
    "law.contact_treatment": "",
    "fill.settle_time": "",
    "run.time_step": "",
}
_OF_TEST = [
    ("--diameter", '"40 mm"', "Of both halves, inside."),
    ("--half-height", '"20 mm"', "Of each half."),
    ("--gap", '"0.5 mm"', "Between the rims of the halves."),
    ("--preload", '"50 N"', "Of the table [default: 50 N for shear, 10 N to compress]."),
    ("--speed", '"5 mm/s"', "Of the test."),
    ("--distance", '"1 mm"', "Of the test [default: shear 1 mm, compress 0.2 mm]."),
    ("--at", '"0.5 mm"', "Of the secant stiffness [default: shear 0.5 mm, compress 0.1 mm]."),
]


def _options(command: Callable[..., Any]) -> Callable[..., Any]:
    for flag, example, text in reversed(_OF_TEST):
        command = click.option(flag, metavar=example, help=text)(command)
    for option in (
        material_option,
        click.option("--seeds", type=click.IntRange(1), default=3, metavar="N",
                     help="Packings of each shape [default: 3]."),
        click.option("--particles", metavar="prolate:1.5,toroid:0.2",
                     help="Shapes [default: the thesis's, and oblate:0.7]."),
        engine_options, out_option,
        click.option("--write", metavar="DIR", help="Where csv, txt and png go [default: --out]."),
        click.option("--so-far", is_flag=True, help="The table of what is finished; run nothing."),
        click.option("--dry-run", is_flag=True, help="Say what would be run, and end."),
        click.option("--no-figures", is_flag=True, help="Make no picture."),
        quiet_option, json_option,
    ):  # fmt: skip
        command = option(command)
    return command


@case_command(keys=_OF_PARTICLES)
@_options
def shear(**options: Any) -> None:
    """Shear beds in two half containers under a held pre-load, the top half sideways.

    Runs that are finished are not done again: the same command goes on after whatever stopped it.
    For example: damper3d shear --particles prolate:1,prolate:1.5 --seeds 5
    """
    _slow("shear", **options)


@case_command(keys=_OF_PARTICLES)
@_options
def compress(**options: Any) -> None:
    """Compress beds in two half containers by a table, from a pre-load on.

    Runs that are finished are not done again: the same command goes on after whatever stopped it.
    For example: damper3d compress --particles toroid:0,toroid:0.2 --distance "0.3 mm"
    """
    _slow("compress", **options)


def _slow(
    kind: Any, *, particles: str | None, seeds: int, material: str | None, out: str,
    write: str | None, so_far: bool, dry_run: bool, no_figures: bool, quiet: bool, as_json: bool,
    engine: str, workers: int | None, scheduler: str | None, **options: Any,
) -> None:  # fmt: skip
    """Run the tests of all shapes and packings; print, keep and draw the table of them."""
    from damper3d.studies.quasistatic.protocol import SLOW_TESTS
    from damper3d.studies.quasistatic.report import report, summary
    from granulab.campaign.output.files import refuse_unless_writable
    from granulab.campaign.output.layout import on_screen
    from granulab.campaign.sweeps.overview import cost
    from granulab.campaign.sweeps.sweep import run_labelled

    cases = _cases(kind, particles, seeds, material, options)
    if so_far:
        cases = [c for c in cases if SLOW_TESTS.run_folder(c[1], Path(out)).state == "finished"]
        if not cases:
            raise click.UsageError(f"--so-far: none of these tests is finished in {out}")
    if dry_run:
        click.echo(cost(SLOW_TESTS, cases))
        return
    for folder, option in ((out, "--out"), (write or out, "--write")):
        refuse_unless_writable(Path(folder), option)
    if not (quiet or so_far):
        click.echo(cost(SLOW_TESTS, cases), err=True)
    rows = run_labelled(
        SLOW_TESTS, cases, out=Path(out), engine=engine, workers=workers, scheduler=scheduler,
        quiet=quiet,
    )  # fmt: skip
    text = report(rows)
    click.echo(json.dumps(summary(kind, rows), indent=2) if as_json else on_screen(text))
    given = {"particles": particles, "seeds": str(seeds), "material": material, **options}
    given |= {"so-far": ""} if so_far else {}
    if any(row["state"] == "done" for row in rows):
        pictured = not (no_figures or stopped(rows))
        _write(kind, rows, text, given, Path(write or out), quiet, pictured)
    stop_unless_whole(rows)


def _cases(
    kind: Any, particles: str | None, seeds: int, material: str | None,
    options: dict[str, str | None],
) -> "list[Labelled]":  # fmt: skip
    """The test of each shape and packing; all shapes of the first packing stand in front."""
    from damper3d.studies.quasistatic.case import SlowTest
    from damper3d.studies.quasistatic.shapes import SHAPES

    names = {flag.removeprefix("--").replace("-", "_") for flag, _, _ in _OF_TEST}
    of_test = {name: options[name] for name in names}
    changes = changes_of(material, {k: v for k, v in options.items() if k not in names})
    shapes = list(SHAPES) if particles is None else _listed(particles)
    return [
        ({"shape": shape, "seed": seed},
         SlowTest.load(kind, changes | {"particles.shape": shape}, of_test, seed))
        for seed in range(1, seeds + 1)
        for shape in shapes
    ]  # fmt: skip


def _listed(particles: str) -> list[str]:
    """The shapes of a list; a comma before a digit belongs to a shape, as in superquadric:1,1."""
    shapes = [word.strip() for word in re.split(r",\s*(?=[A-Za-z])", particles)]
    if not any(shapes):
        raise click.UsageError("--particles: empty; give shapes such as prolate:1.5,toroid:0.2")
    return list(dict.fromkeys(filter(None, shapes)))


def _write(
    kind: str, rows: list[dict[str, Any]], text: str, given: dict[str, str | None], folder: Path,
    quiet: bool, pictured: bool,
) -> None:  # fmt: skip
    """Keep the table, and its picture where there is to be one."""
    from damper3d.studies.quasistatic.chart import draw
    from damper3d.studies.quasistatic.protocol import SLOW_TESTS
    from granulab.campaign.output.results import origin, write_results

    keys = {name: name.rpartition("__")[2].replace("_", "-") for name in given}
    words = [
        f"--{keys[name]} {shlex.quote(str(value))}" if value else f"--{keys[name]}"
        for name, value in given.items()
        if value is not None
    ]
    lines = origin(" ".join([f"damper3d {kind}", *words]), SLOW_TESTS)
    files = write_results(
        folder, kind, rows, lines, text, partial(draw, rows) if pictured else None
    )
    if not quiet:
        click.echo("\n".join(map(str, files)), err=True)
