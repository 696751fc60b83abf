"""The command `view` of any simulator: a page that plays a run, or that of a sweep or map."""

from collections.abc import Callable, Sequence
from pathlib import Path

import click

MOST_MB = 2.5  # of a page, unless --size says more

Page = Callable[[str | Path, float], tuple[str, str]]


def view_command(
    name: str, player: Callable[[], Page], answers: Callable[[], Sequence[str]]
) -> click.Command:
    """The command `view` of a simulator's command line.

    player   gives what makes the page of a run folder of at most so many bytes, and a remark
    answers  gives the columns of a study's table that matter most
    """

    @click.command(
        help=f"""Write a page that plays a run in a browser; or of a sweep or map, its table.

        The page is one file that needs no network. For example: {name} view runs/A4-seed1-...
        """
    )
    @click.argument("folder", metavar="RUN|SWEEP")
    @click.option(
        "-o", "--output", metavar="page.html",
        help="The file [default: figures/page.html in a run, page.html in a sweep or map].",
    )  # fmt: skip
    @click.option(
        "--size", type=click.FloatRange(0.05), default=MOST_MB, metavar="MB",
        help=f"Of a run's page at most; frames are left out for it [default: {MOST_MB:g}].",
    )  # fmt: skip
    @click.option("--runs", is_flag=True, help="Of a sweep or map: pages of its runs too.")
    def view(folder: str, output: str | None, size: float, runs: bool) -> None:
        from granulab.campaign.output.page.study import refuse_no_study

        path = Path(folder)
        if (path / "case.toml").is_file():
            if runs:
                raise click.UsageError("--runs is of a sweep or map; leave it out")
            _say(*written(player(), path, size, Path(output) if output else None))
            return
        refuse_no_study(path)
        _view_study(path, Path(output) if output else path / "page.html", player(), answers(),
                    size if runs else None)  # fmt: skip

    return view


def written(player: Page, run: Path, size: float, target: Path | None = None) -> tuple[Path, str]:
    """The page of a run, of at most so many MB, written; its path, and a remark on what lacks."""
    from granulab.campaign.cli.library import write_output
    from granulab.campaign.output.page.study import page_of

    page, remark = player(run, 1e6 * size)
    return write_output(target or page_of(run), page.encode()), remark


def _say(path: Path, remark: str) -> None:
    click.echo(path)
    if remark:
        click.echo(remark, err=True)


def _view_study(
    folder: Path, target: Path, player: Page, answers: Sequence[str], size: float | None
) -> None:
    """Write the page of a sweep or map, before it those of its runs where a size is given."""
    from granulab.campaign.cli.library import write_output
    from granulab.campaign.output.page.study import runs_of, study_page
    from granulab.errors import FolderError

    reasons: dict[str, int] = {}
    for run in runs_of(folder) if size is not None else []:
        try:
            _say(*written(player, run, size or MOST_MB))
        except FolderError as error:
            reason = str(error).removeprefix(f"{run}: ")
            reasons[reason] = reasons.get(reason, 0) + 1
    for reason, count in reasons.items():
        click.echo(f"{count} of its runs without a page: {reason}", err=True)
    _say(write_output(target, study_page(folder, answers, target).encode()), "")
