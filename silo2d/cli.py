"""The command silo2d. What a command needs is imported in it: --help answers at once."""

import contextlib
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from silo2d.reproduce.command import reproduce

if TYPE_CHECKING:
    from silo2d.case import SiloCase
    from silo2d.result import Result

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
    ("--time-step", "run.time_step", '"5 us"', "Chosen if not given."),
    ("--max-time", "run.max_time", '"6 s"', "When to stop at the latest."),
    ("--shapes", "particles.shapes", "FILE", "Shape set: a shipped name or a TOML file."),
    ("--materials", "particles.materials", "FILE", "Materials: a shipped name or a TOML file."),
    ("--pour-with", "fill.pour_with", "dem|pymunk", "What fills the silo."),
]


def _case_options(command: Callable[..., Any]) -> Callable[..., Any]:
    for flag, key, example, text in reversed(_CASE_OPTIONS):
        command = click.option(flag, key.replace(".", "__"), metavar=example, help=text)(command)
    command = click.option("--mu", metavar="0.4", help="Friction of all contacts.")(command)
    command = click.option(
        "--keep-ratios", is_flag=True, help="kt goes with kn, and gamma_n with its root."
    )(command)
    return click.option("--seed", metavar="1", help="Seed of the filling [default: 1].")(command)


def _changes(seed: str | None, mu: str | None, keep_ratios: bool, options: dict) -> dict[str, Any]:
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


_out = click.option(
    "-o", "--out", default="runs", metavar="DIR", help="Holds runs and packings [default: runs]."
)
_quiet = click.option("--quiet", is_flag=True, help="Print nothing but the answer.")
_json = click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")


@click.group(
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(package_name="granulab")
@click.pass_context
def app(context: click.Context) -> None:
    """Discharge of angular particles from 2D silos.

    A case is a preset (A1 ... D4: hopper of 60, 45, 30, 0 degrees; outlet of 40, 60, 100,
    150 mm) or a TOML file; `silo2d init my_silo.toml` writes one with a comment on every key.
    """
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


@app.command()
@click.argument("case", required=False)
@_case_options
@_out
@click.option("--resume", metavar="DIR", help="Go on with the run in this folder.")
@click.option("--again", is_flag=True, help="Compute it anew beside a run that is there.")
@click.option("--dry-run", is_flag=True, help="Say what would be run, and end.")
@click.option("--no-figures", is_flag=True, help="Make no pictures and no film.")
@_quiet
@_json
def run(
    case: str | None, seed: str | None, mu: str | None, keep_ratios: bool, out: str,
    resume: str | None, again: bool, dry_run: bool, no_figures: bool, quiet: bool, as_json: bool,
    **options: str | None,
) -> None:  # fmt: skip
    """Fill a silo, open it, and measure how it empties.

    For example: silo2d run A4 --outlet "120 mm" --mu 0.3
    """
    changes = _changes(seed, mu, keep_ratios, options)
    if (case is None) == (resume is None):
        raise click.UsageError("give a case (A4, or a TOML file), or --resume DIR, one of them")
    if resume and (changes or again):
        raise click.UsageError("--resume goes on with a case as it is; leave other options out")
    from campaign.folder import resume_run
    from silo2d.case import SiloCase
    from silo2d.report import echo, plan, report

    loaded = SiloCase.load(resume_run(resume).path / "case.toml" if resume else str(case), changes)
    if dry_run:
        click.echo(json.dumps(plan(loaded), indent=2) if as_json else echo(loaded, dry_run=True))
        return
    if not quiet:
        click.echo(echo(loaded, dry_run=False), err=True)
    result = _computed(loaded, out, resume, again, quiet)
    if not no_figures:
        _draw(result.run_folder, quiet, anew=not result.reused)
    click.echo(_as_json(result) if as_json else report(result))


def _computed(case: "SiloCase", out: str, resume: str | None, again: bool, quiet: bool) -> "Result":
    """The result of a case, with a bar on stderr; Ctrl-C stops at the next frame."""
    from campaign.terminal import Progress, StopRequest
    from silo2d import protocol

    _announce_compilation(quiet)
    with StopRequest() as stop, Progress(case.name, quiet=quiet) as bar:
        if resume:
            return protocol.resume(resume, progress=bar.update, stop=lambda: stop.requested)
        return protocol.run(
            case, out=out, again=again, progress=bar.update, stop=lambda: stop.requested
        )


def _announce_compilation(quiet: bool) -> None:
    from contact.jit import already_compiled

    if not quiet and not already_compiled():
        click.echo("compiling the kernels, once for this version (10 to 30 s) ...", err=True)


def _draw(folder: str, quiet: bool, anew: bool) -> None:
    """The figures of a run, made where they are missing."""
    from silo2d.picture import make_figures

    if not anew and (Path(folder) / "figures" / "silo.png").exists():
        return
    if not quiet:
        click.echo(f"drawing {folder}/figures ...", err=True)
    make_figures(folder)


def _as_json(result: "Result") -> str:
    import dataclasses

    return json.dumps(dataclasses.asdict(result), indent=2)


@app.command()
@click.argument("case")
@_case_options
@_out
@_quiet
@_json
def packing(
    case: str, seed: str | None, mu: str | None, keep_ratios: bool, out: str, quiet: bool,
    as_json: bool, **options: str | None,
) -> None:  # fmt: skip
    """Fill a silo and keep the packing; runs of the same case take it from there."""
    from campaign.terminal import Progress, StopRequest
    from silo2d.case import SiloCase
    from silo2d.packing import packing_digest
    from silo2d.protocol import get_packing

    loaded = SiloCase.load(case, _changes(seed, mu, keep_ratios, options))
    _announce_compilation(quiet)
    with StopRequest() as stop, Progress(loaded.name, quiet=quiet) as bar:
        found = get_packing(loaded, Path(out), bar.update, lambda: stop.requested)
    folder = Path(out) / "packings" / packing_digest(loaded, loaded.settings.run.seed)
    table = {
        "n_particles": len(found.kinds),
        "packing_fraction": found.fraction,
        "coordination": found.coordination,
        "poured_with": found.poured_with,
        "cpu_s": found.cpu_s,
        "folder": str(folder),
    }
    lines = (f"{name:17} {value}" for name, value in table.items())
    click.echo(json.dumps(table, indent=2) if as_json else "\n".join(lines))


@app.command()
@click.argument("study")
@_out
@click.option("--workers", type=int, metavar="N", help="Processes [default: one per core].")
@click.option(
    "--engine",
    type=click.Choice(["processes", "dask"]),
    default="processes",
    help="Where the runs go [default: processes of this machine].",
)
@click.option("--scheduler", metavar="ADDRESS", help="Of a Dask cluster: tcp://127.0.0.1:8786")
@click.option("--dry-run", is_flag=True, help="Say what would be run, and end.")
@_quiet
@_json
def sweep(
    study: str, out: str, workers: int | None, engine: str, scheduler: str | None, dry_run: bool,
    quiet: bool, as_json: bool,
) -> None:  # fmt: skip
    """Run a study: cases over lists, ranges and distributions, times seeds.

    `silo2d init --study my_study.toml` writes a study file with a comment on every key. Runs that
    are finished are not done again: the same command goes on after whatever stopped it.
    """
    from silo2d.overview import as_text, plan, plan_as_text, summary
    from silo2d.study import load_study, run_study

    loaded = load_study(study)
    if dry_run:
        planned = plan(loaded, Path(out))
        click.echo(json.dumps(planned, indent=2) if as_json else plan_as_text(loaded, planned))
        return
    _announce_compilation(quiet)
    folder, rows = run_study(
        loaded, out=Path(out), engine=engine, workers=workers, scheduler=scheduler, quiet=quiet
    )
    table = summary(loaded, folder, rows)
    click.echo(json.dumps(table, indent=2) if as_json else as_text(table))
    if table["interrupted"]:
        _fail(f"{table['why_interrupted']}; the same command goes on from there", 130)
    if table["failed"]:
        _fail(f"{table['failed']} of {table['runs']} runs failed; see {table['table']}", 3)


@app.command()
@click.argument("folder")
@click.option("--no-film", is_flag=True, help="Make the pictures only.")
def render(folder: str, no_film: bool) -> None:
    """Make the pictures and the film of a run again from its folder."""
    from campaign.folder import resume_run
    from silo2d.picture import make_figures

    for path in make_figures(resume_run(folder).path, film=not no_film):
        click.echo(path)


@app.command()
@click.argument("folder")
@click.argument("what", required=False)
@click.option("--no-figures", is_flag=True, help="Print the numbers only.")
@_json
def observe(folder: str, what: str | None, no_figures: bool, as_json: bool) -> None:
    """Measure something of a run: numbers on stdout, a picture in figures/.

    Without WHAT it says what can be measured.
    """
    from campaign.folder import resume_run
    from silo2d.measures import MEASURES, find
    from silo2d.sheet import write_figure

    if what is None:
        click.echo("\n".join(f"{name:15} {text}" for name, (_, text) in MEASURES.items()))
        return
    found, path = find(what), resume_run(folder).path
    numbers = found.measure(path)
    if as_json:
        click.echo(json.dumps(numbers, indent=2))
    else:
        lines = (f"{k:32} {v:.4g}" if isinstance(v, float) else f"{k:32} {v}"
                 for k, v in numbers.items() if not isinstance(v, (list, dict)))  # fmt: skip
        click.echo("\n".join(lines))
    if not no_figures:
        picture = write_figure(path / "figures" / f"{what}.png", lambda: found.draw(path))
        click.echo(picture, err=True)


@app.command()
@click.argument("file")
@click.option("--study", is_flag=True, help="Write a study file instead.")
def init(file: str, study: bool) -> None:
    """Write a case file with a comment on every key."""
    from contact.datafile import data_file
    from silo2d.library import write_new

    template = data_file(*(("studies", "friction") if study else ("cases", "example")))
    assert template is not None  # shipped
    write_new(Path(file), template.read_text(encoding="utf-8"))
    click.echo(f"wrote {file}; run it with: silo2d {'sweep' if study else 'run'} {file}")


@app.command("list")
@_out
def list_(out: str) -> None:
    """What there is: presets, shapes, materials; packings and runs with their state and size."""
    from silo2d.library import listing

    click.echo(listing(Path(out)))


@app.command()
@click.argument("name")
def show(name: str) -> None:
    """A preset, case file, shape set, materials file or run folder in words and numbers."""
    from silo2d.library import description

    click.echo(description(name))


app.add_command(reproduce)


def main() -> None:
    """Run the command; one line on stderr and an exit code for whatever goes wrong."""
    from campaign.engine import EngineError
    from campaign.folder import FolderError
    from campaign.study import StudyError
    from contact.quantity import InputError

    try:
        app(standalone_mode=False, prog_name="silo2d")
    except click.ClickException as error:
        _fail(error.format_message().replace("\n", " "), 2)
    except (InputError, FolderError, EngineError, StudyError) as error:
        _fail(str(error), 2)
    except (KeyboardInterrupt, click.Abort):
        _fail("interrupted; the same command goes on from the last checkpoint", 130)
    except BrokenPipeError:
        sys.stderr.close()  # the reader of a pipe (head) has gone: nothing to say, nobody to tell
        sys.exit(0)
    except Exception as error:
        # The two that carry a run's fate live in modules that load numba: looked up by name here.
        if type(error).__name__ == "SimulationError":
            _fail(str(error), 3)
        if type(error).__name__ == "Stopped":
            _fail(f"stopped; {error}", 130)
        raise


def _fail(line: str, code: int) -> None:
    click.echo(f"silo2d: {line}", err=True)
    sys.exit(code)
