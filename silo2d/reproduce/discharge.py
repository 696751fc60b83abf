"""Discharge times and outcomes of the sixteen silos, the experiment's and SPOLY's."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from granulab.campaign.output.figure import BLUE, GREEN, GREY, SKY, VERMILION, entries, ruled
from granulab.campaign.output.layout import (
    columns,
    done,
    not_done,
    percent,
    share,
    verdict,
    with_sd,
)
from granulab.campaign.output.statistics import Sample, mean_sd
from silo2d.case.outline import PRESETS
from silo2d.reproduce.quantities.published import (
    Trials,
    by_silo,
    outcome_word,
    outcomes,
    trials,
    unfinished,
)
from silo2d.reproduce.runs import run_of_cases

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from granulab.campaign.sweeps.sweep import Labelled
    from silo2d.reproduce import Row

SEEDS = 5
COLUMNS = ("silo", "outcome", "discharge_time_s", "t90_s", "packing_fraction")

_CRITERION = """\
time: mean +- standard deviation (number) of the runs and trials that did not clog. "agrees" where
  |ours - experiment| is within the 95 % interval of a difference of two means with unlike spreads,
  t sqrt(s1^2/n1 + s2^2/n2) (Welch), which stands in brackets as a part of the experiment's mean;
  it needs two times on either side; the experiment has three or four a silo. T90: when 90 % of
  those that leave are out.
outcome: clogged of all, with Wilson's 95 % interval; "agrees" where Fisher's exact test does not
  part the two at 5 %. 40 and 60 mm were tried once each, of which it says little."""


def cases(seeds: Sequence[int]) -> "list[Labelled]":
    """The sixteen silos, each with all seeds."""
    from granulab.campaign.sweeps.sweep import over_seeds
    from silo2d.case.case import SiloCase

    return [c for s in PRESETS for c in over_seeds({"silo": s}, SiloCase.load(s), seeds)]


run = run_of_cases(cases)


def report(rows: "list[Row]") -> str:
    """Times, outcomes, what agrees, and the mean deviation next to SPOLY's own."""
    silos = by_silo(rows)
    timed = {silo: own for silo, own in silos.items() if _has_time(silo, own)}
    times = columns(
        ["silo", "experiment [s]", "SPOLY [s]", "ours [s]", "time", "T90 [s]"],
        [_time_line(silo, own) for silo, own in timed.items()],
    )
    ends = columns(
        ["silo", "experiment clogged", "SPOLY", "ours clogged", "at opening", "outcome"],
        [_outcome_line(silo, own) for silo, own in silos.items()],
    )
    summary, failed = "\n".join(_summary(silos)), "\n".join(not_done(rows, ["silo", "seed"]))
    return "\n\n".join(filter(None, [times, ends, summary, _CRITERION, failed]))


def _has_time(silo: str, rows: "list[Row]") -> bool:
    known = trials(silo)
    return bool(_times(rows).n or known.time.n or known.spoly_s)


def _times(rows: "Sequence[Row]", key: str = "discharge_time_s") -> Sample:
    return mean_sd([row[key] for row in done(rows) if row[key] is not None])


def _time_line(silo: str, rows: "list[Row]") -> list[str]:
    known, ours = trials(silo), _times(rows)
    return [
        silo,
        with_sd(known.time, 2),
        "-" if known.spoly_s is None else f"{known.spoly_s:.2f}",
        with_sd(ours),
        verdict(ours, known.time),
        with_sd(_times(rows, "t90_s")),
    ]


def _outcome_line(silo: str, rows: "list[Row]") -> list[str]:
    known, (k, at_opening, n) = trials(silo), outcomes(rows)
    return [
        silo,
        share(known.clogged, known.n),
        {True: "clogged", False: "flows", None: "-"}[known.spoly_clogged],
        share(k, n) + unfinished(rows, n),
        str(at_opening),
        outcome_word(known, k, n),
    ]


def _summary(silos: "dict[str, list[Row]]") -> list[str]:
    times, words = {}, []
    for silo, rows in silos.items():
        known, ours = trials(silo), _times(rows)
        k, _, n = outcomes(rows)
        words.append(outcome_word(known, k, n))
        if ours.mean is not None and known.time.mean is not None:
            times[silo] = ours, known
    judged = [verdict(ours, known.time) for ours, known in times.values()]
    agree = sum(word.startswith("agrees") for word in judged)
    few = sum(word.endswith("too few to judge") for word in judged)
    lines = [
        f"times: {agree} of {len(judged)} silos agree within noise, {len(judged) - agree - few} "
        f"do not, {few} have too few times to judge; outcomes: {words.count('agrees')} of "
        f"{len(words) - words.count('-')} agree"
    ]
    if times:
        lines.append(f"mean |deviation| from the experiment: {_deviation(times)}")
    both = {s: pair for s, pair in times.items() if pair[1].spoly_s is not None}
    if both:
        spoly = mean_sd([abs(_off(known.spoly_s, known)) for _, known in both.values()])
        assert spoly.mean is not None
        lines.append(
            f"of these with a time of SPOLY ({', '.join(both)}): ours "
            f"{_deviation(both)}, SPOLY's own {percent(spoly.mean)}"
        )
    return lines


def _off(time: float | None, known: Trials) -> float:
    assert time is not None
    assert known.time.mean is not None
    return time / known.time.mean - 1


def _deviation(times: dict[str, tuple[Sample, Trials]]) -> str:
    off = mean_sd([abs(_off(ours.mean, known)) for ours, known in times.values()])
    assert off.mean is not None
    return f"{percent(off.mean)} over {off.n} silos"


def draw(rows: "list[Row]") -> "Figure":
    """Times of the silos that have one, experiment, SPOLY and ours side by side."""
    from matplotlib.figure import Figure

    silos = {silo: own for silo, own in by_silo(rows).items() if _has_time(silo, own)}
    figure = Figure(figsize=(8.4, 4.8), layout="constrained")
    axes = figure.subplots()
    for position, (silo, own) in enumerate(silos.items()):
        _draw_silo(axes, position, own, trials(silo))
    axes.set_xticks(range(len(silos)), [_tick(silo, own) for silo, own in silos.items()])
    axes.set_xlabel("silo, and how many clogged: experiment | ours")
    axes.set_ylabel("discharge time [s]")
    axes.set_ylim(bottom=0)
    ruled(axes)
    named = entries([axes])
    axes.legend(named.values(), named.keys(), loc="lower left", bbox_to_anchor=(0, 1), ncols=4)
    return figure


def _draw_silo(axes: "Axes", position: int, rows: "list[Row]", known: Trials) -> None:
    ours, t90 = _times(rows), _times(rows, "t90_s")
    single = [row["discharge_time_s"] for row in done(rows) if row["discharge_time_s"] is not None]
    axes.plot([position + 0.2] * len(single), single, "_", color=SKY, ms=7, mew=1.2)
    for shift, sample, style in (
        (-0.2, known.time, {"fmt": "s", "color": GREEN, "label": "experiment, mean and sd"}),
        (0.2, ours, {"fmt": "o", "color": BLUE, "label": "ours, mean and sd (bars: each run)"}),
        (0.36, t90, {"fmt": "o", "color": GREY, "mfc": "white", "ms": 4, "label": "ours, T90"}),
    ):
        if sample.mean is not None:
            axes.errorbar(position + shift, sample.mean, sample.sd or 0, capsize=3, **style)
    if known.spoly_s is not None:
        axes.plot(position, known.spoly_s, "D", color=VERMILION, ms=5, label="SPOLY")


def _tick(silo: str, rows: "list[Row]") -> str:
    known, (k, _, n) = trials(silo), outcomes(rows)
    return f"{silo}\n{known.clogged}/{known.n} | {k}/{n}"
