"""Shares of runs that clog at outlets of 40, 60, 100 mm, compared with the experiment's."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from granulab.campaign.output.figure import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, entries, ruled
from granulab.campaign.output.layout import columns, not_done, share
from granulab.campaign.output.statistics import (
    Counts,
    chance_of_few,
    chance_of_shares,
    wilson,
)
from silo2d.case.outline import PRESETS
from silo2d.reproduce.quantities.published import (
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

SEEDS = 20
COLUMNS = ("silo", "outcome")

_SILOS = [name for name in PRESETS if name[1] != "4"]
_OUTLETS = {"1": "40 mm", "2": "60 mm", "3": "100 mm"}
_ANGLES = {"A": "A, 60 deg", "B": "B, 45 deg", "C": "C, 30 deg", "D": "D, 0 deg"}
_COLOURS = {"A": BLUE, "B": SKY, "C": ORANGE, "D": PURPLE}

_CRITERION = """\
clogged: at rest with a particle across the outlet's centre line, of all runs that ended before the
  time limit, with Wilson's 95 % interval; at opening: with fewer particles out than [run]
  opening_count, of the same runs; later: the others, of those that did not stick at the opening.
outcome: "agrees" where Fisher's exact test does not part ours from the experiment's at 5 %: of a
  single trial it hardly ever does.
p: chance of counts as unlikely as these if both shares were equal, two-sided: of the sums by
  Fisher's exact test, and silo by silo with the sums of each given. The experiment repeated trials
  where a clog was seen; read as "until as many emptied", the chance of so few clogs by ours."""


def cases(seeds: Sequence[int]) -> "list[Labelled]":
    """The twelve silos with the smaller outlets, each with all seeds."""
    from granulab.campaign.sweeps.sweep import over_seeds
    from silo2d.case.case import SiloCase

    return [c for s in _SILOS for c in over_seeds({"silo": s}, SiloCase.load(s), seeds)]


run = run_of_cases(cases)


def report(rows: "list[Row]") -> str:
    """A line a silo: shares with their intervals, and whether the experiment's fits."""
    header = ["silo", "outlet", "experiment clogged", "ours clogged", "at opening", "later",
              "outcome"]  # fmt: skip
    silos = by_silo(rows)
    words = {silo: _word(silo, own) for silo, own in silos.items()}
    judged = [word for word in words.values() if word != "-"]
    alone = f"one by one, {judged.count('agrees')} of {len(judged)} silos agree with the experiment"
    summary = "\n".join(filter(None, [_together(silos), alone]))
    lines = [_line(silo, own, words[silo]) for silo, own in silos.items()]
    failed = "\n".join(not_done(rows, ["silo", "seed"]))
    return "\n\n".join(filter(None, [columns(header, lines), summary, _CRITERION, failed]))


def _word(silo: str, rows: "list[Row]") -> str:
    k, _, n = outcomes(rows)
    return outcome_word(trials(silo), k, n)


def _together(silos: "dict[str, list[Row]]") -> str:
    """Tests of all silos of which the experiment has more than one trial, together."""
    found: dict[str, Counts] = {}
    for silo, own in silos.items():
        known, (k, _, n) = trials(silo), outcomes(own)
        if known.n > 1 and n:
            found[silo] = Counts(known.clogged, known.n, k, n)
    if not found:
        return ""
    strata = list(found.values())
    k, n, other_k, other_n = (
        sum(getattr(one, name) for one in strata) for name in ("k", "n", "other_k", "other_n")
    )
    pooled = chance_of_shares([Counts(k, n, other_k, other_n)])
    return (
        f"{', '.join(found)} together: the experiment clogged in {share(k, n)}, ours in"
        f" {share(other_k, other_n)}: p = {pooled:.2g},\n"
        f"  silo by silo p = {chance_of_shares(strata):.2g}; by trials repeated until as many"
        f" emptied, {chance_of_few(strata):.2g}"
    )


def _line(silo: str, rows: "list[Row]", word: str) -> list[str]:
    known, (k, at_opening, n) = trials(silo), outcomes(rows)
    return [
        silo,
        _OUTLETS[silo[1]],
        share(known.clogged, known.n),
        share(k, n) + unfinished(rows, n),
        share(at_opening, n),
        share(k - at_opening, n - at_opening),
        word,
    ]


def draw(rows: "list[Row]") -> "Figure":
    """Shares with intervals against the outlet, a colour a hopper; what clogged at the opening."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.4, 4.4), layout="constrained")
    axes = figure.subplots()
    silos = by_silo(rows)
    for silo, own in silos.items():
        _draw_silo(axes, silo, own)
    for label, style in (
        ("experiment", {"marker": "s", "color": GREEN}),
        ("ours, of these at the opening", {"marker": "_", "color": GREY, "mew": 2, "ms": 9}),
    ):
        axes.plot([], [], ls="", label=label, **style)
    axes.set_xticks(range(3), [f"{outlet} ({number})" for number, outlet in _OUTLETS.items()])
    axes.set_xlim(-0.5, 2.5)
    axes.set_ylim(-0.03, 1.03)
    axes.set_xlabel("outlet (number of the silo)")
    axes.set_ylabel("clogged, share of runs (95 % interval)")
    ruled(axes)
    named = entries([axes])
    axes.legend(named.values(), named.keys(), loc="upper left", bbox_to_anchor=(1, 1))
    return figure


def _draw_silo(axes: "Axes", silo: str, rows: "list[Row]") -> None:
    (k, at_opening, n), known = outcomes(rows), trials(silo)
    hopper = "ABCD".index(silo[0])
    position = int(silo[1]) - 1 + 0.2 * (hopper - 1.5)
    if n:
        low, high = wilson(k, n)
        bars = [[k / n - low], [high - k / n]]
        axes.errorbar(position, k / n, bars, fmt="o", color=_COLOURS[silo[0]], capsize=3,
                      label=f"ours, {_ANGLES[silo[0]]}")  # fmt: skip
        axes.plot(position, at_opening / n, "_", color=GREY, ms=9, mew=2)
    if known.n:
        low, high = wilson(known.clogged, known.n)
        found = known.clogged / known.n
        axes.errorbar(position + 0.07, found, [[found - low], [high - found]], fmt="s", ms=4,
                      color=GREEN, lw=0.8)  # fmt: skip
