"""The group of commands, the options that all packages share, and the end of a command."""

import errno
import gc
import io
import shlex
import sys
import tempfile
import traceback
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import click


def _a_name(_context: click.Context, _option: click.Parameter, folder: str) -> str:
    """A folder; OSError for a name longer than any may be, which Path takes for one not there."""
    try:
        Path(folder).stat()
    except OSError as error:
        if error.errno == errno.ENAMETOOLONG:
            raise
    return folder


MANY = 20  # runs of a case, as studies leave them, of which a list gives only the states
all_option = click.option(
    "--all", "every", is_flag=True, help=f"List each run, also of a case with more than {MANY}."
)
out_option = click.option(
    "-o", "--out", default="runs", metavar="DIR", callback=_a_name,
    help="Holds runs and packings [default: runs].",
)  # fmt: skip
quiet_option = click.option("--quiet", is_flag=True, help="Print nothing but the result.")
workers_option = click.option(
    "--workers", type=int, metavar="N", help="Processes [default: one per core]."
)
dry_run_option = click.option(
    "--dry-run", is_flag=True, help="Say and draw what would be run, and end."
)
no_figures_option = click.option("--no-figures", is_flag=True, help="Make no pictures.")
json_option = click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")


class Ended(Exception):
    """A command did its work and says, by a line and an exit code, what is missing."""

    def __init__(self, line: str, code: int) -> None:
        super().__init__(line)
        self.code = code


def command_group(
    commands: Sequence[click.Command], purpose: str, cls: type[click.Group] = click.Group
) -> click.Group:
    """The group of a package's commands, of a class; purpose: the text of its --help."""
    context = {"help_option_names": ["-h", "--help"], "max_content_width": 100}

    @click.group(cls=cls, help=purpose, invoke_without_command=True, context_settings=context)
    @click.version_option(package_name="granulab")
    @click.pass_context
    def app(context: click.Context) -> None:
        if context.invoked_subcommand is None:
            click.echo(context.get_help())

    for command in commands:
        app.add_command(command)
    return app


ENGINES = ["processes", "dask"]
ENGINES_AND_GPU = [*ENGINES, "cuda"]  # of simulators that have a device


def engine_options(command: Callable[..., Any], *, engines: list[str] = ENGINES) -> Any:
    """Options that say what computes many runs: --workers, --engine, --scheduler."""
    gpu = ", a Dask cluster, or a GPU" if "cuda" in engines else ""
    for option in (
        click.option("--scheduler", metavar="ADDRESS", help="A Dask cluster: tcp://127.0.0.1:8786"),
        click.option(
            "--engine",
            type=click.Choice(engines),
            default="processes",
            help=f"Where the runs go [default: processes of this machine]{gpu}.",
        ),
        workers_option,
    ):
        command = option(command)
    return command


device_options = partial(engine_options, engines=ENGINES_AND_GPU)


_INTERRUPTED = "interrupted; the same command goes on from the last checkpoint"
# Objects that are made before Python looks for unreachable cycles among them; its own 700 make it
# look so often while modules and kernels are loaded that a run starts a fifth of a second later.
_UNTIL_COLLECTION = 50_000


def run_app(app: click.Group, name: str) -> None:
    """Run a command; one line on stderr and an exit code for whatever goes wrong.

    An exception that nobody foresaw (also a numerical library's) ends with the code 3, and its
    traceback is kept in a file.
    """
    from granulab.campaign.output.terminal import StopRequest, forget_reader, pass_on_interrupt
    from granulab.campaign.sweeps.study import StudyError
    from granulab.campaign.sweeps.task import EngineError
    from granulab.contact.files.datafile import refuse_pipe
    from granulab.errors import FolderError, InputError, SimulationError, Stopped

    def fail(line: str, code: int) -> None:
        shown = "".join(c if c.isprintable() else repr(c)[1:-1] for c in line)  # one line it is
        click.echo(f"{name}: {shown}", err=True)
        sys.exit(code)

    gc.set_threshold(max(_UNTIL_COLLECTION, gc.get_threshold()[0]), *gc.get_threshold()[1:])
    StopRequest.interrupted = False
    before, sys.unraisablehook = sys.unraisablehook, pass_on_interrupt
    if isinstance(sys.stdout, io.TextIOWrapper):  # letters that its alphabet lacks: as \u0416
        sys.stdout.reconfigure(errors="backslashreplace")
    try:
        for argument in sys.argv[1:]:
            refuse_pipe(Path(argument.rpartition("=")[2].removeprefix("mesh:")))
        app(standalone_mode=False, prog_name=name)
        sys.stdout.flush()
    except click.ClickException as error:
        fail(error.format_message().replace("\n", " "), 2)
    except (InputError, FolderError, EngineError, StudyError) as error:
        fail(str(error), 2)
    except Ended as error:
        fail(str(error), error.code)
    except SimulationError as error:
        fail(str(error), 3)
    except Stopped as error:
        fail(f"stopped; {error}", 130)
    except (KeyboardInterrupt, click.Abort):
        fail(_INTERRUPTED, 130)
    except BrokenPipeError:  # the reader of a pipe (head) has gone: nobody is left to read a line
        forget_reader(sys.stdout)
        sys.exit(0)
    except SystemExit:  # what click makes of it; no command raises one
        sys.exit(0)
    except OSError as error:
        if error.errno == errno.ENAMETOOLONG:
            fail(f"{error.filename}: longer than a name of a file may be; give a shorter one", 2)
        if error.errno not in (errno.ENOSPC, errno.EDQUOT, errno.EIO):
            fail(_unforeseen(app, name, error), 3)
        fail(f"the output cannot be written ({error.strerror}); make room there, or send it "
             "elsewhere, and give the same command again", 2)  # fmt: skip
    except Exception as error:
        if StopRequest.interrupted:  # numba makes another error of it while it compiles
            fail(_INTERRUPTED, 130)
        fail(_unforeseen(app, name, error), 3)
    finally:
        sys.unraisablehook = before


def _unforeseen(app: click.Group, name: str, error: Exception) -> str:
    """One line for an exception that nobody foresaw: kind, reason, position, kept traceback."""
    ours = (type(app), *(command.callback for command in app.commands.values()))
    own = {_package(one) for one in ours} - {"click"} | {"granulab"}
    frames = [
        (frame.f_globals.get("__name__", frame.f_code.co_filename), line, frame.f_code.co_name)
        for frame, line in traceback.walk_tb(error.__traceback__)
    ]
    module, line, function = [f for f in frames if f[0].partition(".")[0] in own][-1]
    raised = f", raised in {frames[-1][0]}" if frames[-1][0] != module else ""
    reason = " ".join(str(error).split())
    kind = f"{type(error).__name__}: {reason}" if reason else type(error).__name__
    return (
        f"{kind} (at {module}:{line} in {function}{raised}); a fault of the program that nobody "
        f"foresaw, please report it; {_kept_traceback(name, error)}"
    )


def _package(one: Any) -> str:
    """The top-level package that a function or class is of."""
    return getattr(one, "__module__", "").partition(".")[0]


def _kept_traceback(name: str, error: Exception) -> str:
    """Write the command and its traceback to a file of the temporary folder; where that is."""
    text = f"{shlex.join([name, *sys.argv[1:]])}\n{''.join(traceback.format_exception(error))}"
    try:
        with tempfile.NamedTemporaryFile(
            "w", prefix=f"{name}-", suffix="-traceback.txt", delete=False, encoding="utf-8",
            newline="\n",
        ) as file:  # fmt: skip
            file.write(text)
    except OSError:
        return "its traceback could not be kept: the temporary folder cannot be written"
    return f"its traceback is in {file.name}"
