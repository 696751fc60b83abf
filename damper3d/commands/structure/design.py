"""The command that designs a damper for a structure: design."""

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from granulab.campaign.cli.commandline import device_options, json_option, out_option, quiet_option

if TYPE_CHECKING:
    from damper3d.studies.design.design import Designer
    from damper3d.studies.design.spec import Task

_DRAWN = 3  # of the random designs, the best by their fields, that are simulated


@click.command()
@click.argument("spec")
@click.option(
    "--compare", type=click.IntRange(0, 1000), default=0, metavar="N",
    help="Beside the thesis's rule of thumb and N random designs [default: 0].",
)  # fmt: skip
@device_options
@out_option
@click.option("--dry-run", is_flag=True, help="Say what would be run, and end.")
@click.option("--no-figures", is_flag=True, help="Make no picture and no page.")
@quiet_option
@json_option
def design(
    spec: str, compare: int, workers: int | None, engine: str, scheduler: str | None, out: str,
    dry_run: bool, no_figures: bool, quiet: bool, as_json: bool,
) -> None:  # fmt: skip
    """Design a damper for a structure: particles, number and enclosure that damp it best.

    SPEC is a TOML file with structure, level, space and mass budget; `damper3d init FILE --design`
    writes one. Finished runs are not done again.
    For example: damper3d init my_task.toml --design, then damper3d design my_task.toml
    """
    from damper3d.studies.design.candidates import refuse_at_rest
    from damper3d.studies.design.design import Designer
    from damper3d.studies.design.spec import read_spec
    from granulab.campaign.output.files import refuse_unless_writable
    from granulab.campaign.output.layout import on_screen

    task = read_spec(spec)
    engines = {"engine": engine, "workers": workers, "scheduler": scheduler, "quiet": quiet}

    def say(words: str) -> None:
        if not quiet:
            click.echo(words, err=True)

    designer = Designer(task, Path(out), engines, say)
    refuse_at_rest(task)
    if dry_run:
        planned = _plan(designer, compare)
        click.echo(json.dumps(planned, indent=2) if as_json else _planned(planned))
        return
    _ = designer.beds  # a space in which none fits is refused before anything is computed
    refuse_unless_writable(Path(out), "--out")
    results = _designed(designer, compare, spec, no_figures)
    from damper3d.studies.design.report import in_words

    words = f"{in_words(results)}\nfolder      {results['folder']}"
    click.echo(json.dumps(results, indent=2) if as_json else on_screen(words))


def _plan(designer: "Designer", compare: int) -> dict[str, Any]:
    from damper3d.studies.design.candidates import NEARBY
    from damper3d.studies.design.design import AGAIN

    spec = designer.task.spec
    costs = designer.expected_cpu_s(compare, min(_DRAWN, compare))
    return {
        "name": spec.name,
        "bare_gamma": designer.task.bare_gamma,
        "force_n": designer.task.force,
        "closed_form_m": designer.amplitude,
        "beds": len(designer.beds),
        "candidates": designer.number,
        "expected_cpu_min": sum(costs.values()) / 60,
        "parts_cpu_min": {name: cost / 60 for name, cost in costs.items()},
        "verified": (spec.search.verified + 1 + len(NEARBY) + AGAIN * len(spec.level.range))
        * spec.search.seeds
        * 3,
    }


def _planned(planned: dict[str, Any]) -> str:
    return (
        f"{planned['name']}: bare {planned['bare_gamma']:.4g} g under {planned['force_n']:.4g} N; "
        f"closed form {1e3 * planned['closed_form_m']:.4g} mm\n"
        f"{planned['beds']} beds find room; fields of {planned['candidates']} candidates; then "
        f"some {planned['verified']} runs with the structure\n"
        f"expected    about {planned['expected_cpu_min']:.1f} min of CPU: "
        + ", ".join(f"{name} {cost:.1f}" for name, cost in planned["parts_cpu_min"].items())
    )


def _designed(designer: "Designer", compare: int, spec: str, no_figures: bool) -> dict[str, Any]:
    """Compute, write the files, and return the results."""
    from damper3d.studies.design.report import as_dict, as_page, draw, draw_first, ranked
    from damper3d.studies.design.verification import to_verify
    from granulab.campaign.output.figure import as_png
    from granulab.campaign.output.files import write_atomic, writing
    from granulab.campaign.runs.folder import digest
    from granulab.errors import SimulationError

    task, search = designer.task, designer.task.spec.search
    found = designer.searched()
    tried = to_verify(found, search.verified, designer.rule)
    designer.say(f"{len(tried)} designs with the structure, {search.seeds} packings each")
    verified = designer.verify(tried, search.seed + 1)
    beside = [one.design for one in verified[len(tried) :]]
    computed = [*found, *beside]
    able = [one for one in computed if one.field is not None]
    if not able:
        raise SimulationError(
            f"{task.spec.name}: the runs of all {len(computed)} candidates failed; `damper3d list "
            f"{designer.out}` names them"
        )
    order = ranked(able, verified)
    again = None
    if chosen := next((one for one in verified if one.design is order[0]), None):
        designer.say("the first on packings that it was not chosen by")
        again = designer.again(chosen)
    seen = verified if again is None else [*verified, again]  # scatter of all packings
    designer.say("the first where level and frequency are off")
    robust = designer.robustness(order[0])
    designs = [
        as_dict(task, order[0], 1, seen, robust, again),
        *(as_dict(task, one, rank, seen) for rank, one in enumerate(order[1:], 2)),
    ]
    name = digest({"spec": task.spec.model_dump(), "balls": [vars(b) for b in task.catalogue]})
    folder = designer.out / "designs" / f"{task.spec.name}-{name}"
    results = {
        "name": task.spec.name, "spec": spec, "task": _task(designer), "designs": designs,
        "failed": len(computed) - len(able),
        "compared": _compared(designer, order, compare) if compare else [],
        "made_by": " ".join(["damper3d", *sys.argv[1:]]), "folder": str(folder),
    }  # fmt: skip
    with writing(designer.out):
        folder.mkdir(parents=True, exist_ok=True)
    write_atomic(folder / "summary.json", json.dumps(results, indent=2) + "\n")
    if not no_figures:
        drawn = {"sketch": as_png(lambda: draw_first(task, order[0])),
                 "design": as_png(lambda: draw(task, order, seen))}  # fmt: skip
        pictures = {name: png for name, png in drawn.items() if png is not None}
        for name, png in pictures.items():
            write_atomic(folder / f"{name}.png", png)
        write_atomic(folder / "design.html", as_page(results, pictures))
        click.echo(folder / "design.html", err=True)
    return results


def _task(designer: "Designer") -> dict[str, Any]:
    task: Task = designer.task
    own, level = task.spec.structure, task.spec.level
    return {
        "mass_kg": own.mass, "frequency_hz": own.frequency, "damping_ratio": own.damping_ratio,
        "bare_gamma": task.bare_gamma, "force_n": task.force, "levels": level.range,
        "orientation": level.orientation, "budget_kg": task.budget,
        "closed_form_m": designer.amplitude,
    }  # fmt: skip


def _compared(designer: "Designer", order: list[Any], number: int) -> list[dict[str, Any]]:
    """The first design, the rule of thumb and the best random one, on packings nobody has seen."""
    from damper3d.studies.design.design import UNSEEN
    from damper3d.studies.design.verification import Verified

    designer.say(f"the rule of thumb and {number} random designs")
    rule, drawn = designer.others(number)
    chosen = [("first", order[0]), ("thumb", rule), *(("random", one) for one in drawn[:_DRAWN])]
    able = [(what, one) for what, one in chosen if one.field is not None]
    seen = [Verified(one) for _, one in able]
    levels = range(len(designer.task.spec.level.range))
    designer.simulate([(one, level) for one in seen for level in levels],
                      designer.task.spec.search.seed + UNSEEN)  # fmt: skip
    return [
        {
            "what": what,
            "words": one.candidate.words,
            "reduction": one.reduction,
            "reductions": each.reductions,
            "simulated": ", with the structure "
            + ", ".join(f"{value:.3f}" for value in each.reductions)
            + (f" (mean {each.mean:.3f})" if each.reductions else ""),
        }
        for (what, one), each in zip(able, seen, strict=True)
    ]
