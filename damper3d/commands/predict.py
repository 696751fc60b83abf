"""The command that predicts by closed forms where a damper damps best: predict."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from damper3d.commands.options import case_command, changes_of, material_option
from granulab.campaign.cli.commandline import device_options, json_option, out_option, quiet_option
from granulab.campaign.cli.many import numbers, stop_unless_whole
from granulab.campaign.output.layout import on_screen, stopped

if TYPE_CHECKING:
    from damper3d.case.random_packing import Fraction
    from damper3d.studies.predict.prediction import Prediction

_FREQUENCIES = "give --frequencies, a list such as 20,40,80"
_WITHOUT = {
    "motion.frequency": _FREQUENCIES,
    "motion.gamma": "a prediction is for all gamma, and --simulate chooses some",
}


@case_command(without=_WITHOUT)
@click.argument("case", required=False)
@material_option
@click.option(
    "--frequencies", metavar="20,40,80", help="In Hz [default: 20, 40, 80 and the case's]."
)
@click.option("--packing", type=float, metavar="0.6", help="Fill ratio of your packed bed.")
@click.option("--pack", is_flag=True, help="Compute the close packing of the particles' shape.")
@click.option("--full-count", type=int, metavar="N", help="How many particles fill the enclosure.")
@click.option(
    "--for", "wanted_for", metavar="60,5",
    help="Frequency in Hz and Gamma whose clearance is wanted.",
)  # fmt: skip
@click.option("--simulate", is_flag=True, help="Compare runs with the ideal curves, to Gamma 100.")
@device_options
@out_option
@click.option("--no-figures", is_flag=True, help="Make no picture.")
@quiet_option
@json_option
def predict(
    case: str | None, material: str | None, frequencies: str | None,
    packing: float | None, pack: bool, full_count: int | None, wanted_for: str | None,
    simulate: bool, workers: int | None, engine: str, scheduler: str | None, out: str,
    no_figures: bool, quiet: bool, as_json: bool, **options: Any,
) -> None:  # fmt: skip
    """Predict where a damper damps best, from its fill ratio and height.

    Without CASE, --height and --count it is the thesis's damper at its four heights.
    For example: damper3d predict --height "45 mm" --count 358 --packing 0.6
    """
    from damper3d.case.case import DamperCase
    from damper3d.studies.map.grid import rising
    from damper3d.studies.predict import prediction as predicting
    from damper3d.studies.predict.chart import draw_predictions
    from granulab.campaign.output.figure import write_figure
    from granulab.campaign.output.files import refuse_unless_writable
    from granulab.errors import InputError

    point = numbers("--for", wanted_for, ())
    if len(point) not in (0, 2) or any(value <= 0 for value in point):
        raise InputError(f"--for {wanted_for!r}: give frequency in Hz and Gamma, such as 60,5")
    fills = predicting.fills(case, changes_of(material, options))
    cases = [DamperCase.load(*fill) for fill in fills]
    usual = predicting.frequencies_for(cases[0])
    wanted = rising("frequencies", numbers("--frequencies", frequencies, usual))
    if pack or simulate or not no_figures:
        refuse_unless_writable(Path(out), "--out")
    close = _computed(fills[0], out, workers, quiet) if pack else None
    predictions = [predicting.predict(loaded, packing, full_count, close) for loaded in cases]
    for prediction in predictions:
        predicting.check_known(prediction)
    rows: list[dict[str, Any]] = []
    if simulate:
        from damper3d.studies.predict import compare

        engines = {"engine": engine, "workers": workers, "scheduler": scheduler, "quiet": quiet}
        rows = compare.simulate(fills, predictions, wanted, out=Path(out), **engines)
    results = {
        "frequencies_hz": list(wanted),
        "fills": [predicting.as_dict(p, wanted) for p in predictions],
        "simulated": rows,
    }
    words = _in_words(predictions, wanted, rows)
    if point:
        found = [predicting.inverted(prediction, *point) for prediction in predictions]
        results["for"] = found
        words += "\n" + "\n".join(map(predicting.inverted_words, found))
    click.echo(json.dumps(results, indent=2) if as_json else on_screen(words))
    if not (no_figures or stopped(rows)):
        picture = Path(out) / f"predict-{cases[0].name}.png"
        write_figure(picture, lambda: draw_predictions(predictions, wanted, rows))
        click.echo(picture, err=True)
    stop_unless_whole(rows)


def _computed(
    fill: tuple[str, dict[str, Any]], out: str, workers: int | None, quiet: bool
) -> "Fraction | None":
    """The close packing of a case's particles, which all fills have in common."""
    from damper3d.run.sweep import DAMPER
    from damper3d.studies.pack import computed
    from granulab.campaign.output.terminal import announce_compilation

    announce_compilation(quiet, DAMPER.compiled())
    rows = computed.pack(*fill, out=Path(out), beds=False, workers=workers, quiet=quiet)
    stop_unless_whole(rows)
    return computed.close_fraction(rows, computed.BODIES)


def _in_words(
    predictions: "list[Prediction]", frequencies: tuple[float, ...], rows: list[dict[str, Any]]
) -> str:
    from damper3d.studies.predict.prediction import as_text

    parts = [as_text(prediction, frequencies) for prediction in predictions]
    if rows:
        from damper3d.studies.predict import compare

        parts.append(compare.as_text(rows, predictions))
    return "\n\n".join(parts)
