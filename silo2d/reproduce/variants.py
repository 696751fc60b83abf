"""Variants of a study against its first: the same packings or seeds, one setting changed.

Times are compared seed by seed: the mean of the differences, with Student's t over its standard
error, in which what the seeds share cancels. Counts of clogged runs are compared by Fisher's exact
test. A difference counts where chance alone would make one as large in less than 5 % of studies;
each is judged by itself, and of twenty that mean nothing one is then expected to count.
"""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from granulab.campaign.output.figure import BLUE, GREY, INK, VERMILION, ruled
from granulab.campaign.output.layout import columns, done, not_done, percent, share, with_sd
from granulab.campaign.output.statistics import (
    CONFIDENCE,
    Counts,
    Sample,
    chance_of_shares,
    half_width_of_mean,
    mean_sd,
    wilson,
)
from silo2d.reproduce.quantities.published import outcomes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from silo2d.reproduce import Row

Variants = dict[str, "list[Row]"]  # name of a variant -> its rows, the one to compare with first
NameOf = Callable[["Row"], str]

_CRITERION = """\
time and T90: mean +- standard deviation (number) over the runs that emptied, and the mean
  difference from the first variant over the seeds that emptied in both, with its 95 % interval.
clogged, at opening: with Wilson's 95 % interval; p of Fisher's exact test against the first
  variant."""


def variants_of(rows: "Sequence[Row]", name_of: NameOf) -> dict[str, Variants]:
    """The rows of each silo and variant, in their order."""
    silos: dict[str, Variants] = {}
    for row in rows:
        silos.setdefault(row["silo"], {}).setdefault(name_of(row), []).append(row)
    return silos


def report_variants(rows: "list[Row]", name_of: NameOf) -> str:
    """A line a variant with its times and counts, how they differ from the first, and words."""
    header = ["silo", "variant", "time [s]", "difference", "T90 [s]", "difference", "clogged", "p",
              "at opening", "p"]  # fmt: skip
    silos = variants_of(rows, name_of)
    lines = [
        _line(silo, name, own, next(iter(variants.values())))
        for silo, variants in silos.items()
        for name, own in variants.items()
    ]
    words = [
        f"{silo}, {name}: {'; '.join(findings(own, next(iter(variants.values()))))}"
        for silo, variants in silos.items()
        for name, own in list(variants.items())[1:]
    ]
    failed = "\n".join(not_done(rows, ["silo", "seed"]))
    parts = [columns(header, lines), "\n".join(words), _CRITERION, failed]
    return "\n\n".join(filter(None, parts))


def _line(silo: str, name: str, rows: "list[Row]", first: "list[Row]") -> list[str]:
    line = [silo, name]
    for key in ("discharge_time_s", "t90_s"):
        line += [with_sd(mean_sd(_values(rows, key))), _difference(rows, first, key)]
    k, at_opening, n = outcomes(rows)
    k1, at_opening1, n1 = outcomes(first)
    for own, other in ((k, k1), (at_opening, at_opening1)):
        p = fisher_p(own, n, other, n1)
        line += [share(own, n), "-" if rows is first or p is None else f"{p:.2f}"]
    return line


def _values(rows: "list[Row]", key: str) -> list[float]:
    return [row[key] for row in done(rows) if row[key] is not None]


def paired(rows: "list[Row]", first: "list[Row]", key: str) -> tuple[Sample, float | None]:
    """Differences over the seeds with a value in both; half width of the mean's interval."""
    known = {row["seed"]: row[key] for row in done(first) if row[key] is not None}
    both = [row for row in done(rows) if row[key] is not None and row["seed"] in known]
    sample = mean_sd([row[key] - known[row["seed"]] for row in both])
    return sample, half_width_of_mean(sample)


def _difference(rows: "list[Row]", first: "list[Row]", key: str) -> str:
    sample, half = paired(rows, first, key)
    if rows is first or sample.mean is None:
        return "-"
    return f"{sample.mean:+.3f}" + ("" if half is None else f" +- {half:.3f}") + f" ({sample.n})"


def fisher_p(k: int, n: int, other_k: int, other_n: int) -> float | None:
    """Fisher's p of k of n against another count; None where one has no run."""
    return chance_of_shares([Counts(k, n, other_k, other_n)]) if n and other_n else None


def findings(rows: "list[Row]", first: "list[Row]") -> list[str]:
    """A few words on each of time, T90, clogging and clogging at the opening."""
    words = []
    for name, key in (("time", "discharge_time_s"), ("T90", "t90_s")):
        (sample, half), usual = paired(rows, first, key), mean_sd(_values(first, key)).mean
        if sample.mean is None or half is None or usual is None:
            words.append(f"{name} too few to judge")
        elif abs(sample.mean) <= half:
            words.append(f"{name} the same within {percent(half / usual)}")
        else:
            way = "longer" if sample.mean > 0 else "shorter"
            words.append(
                f"{name} {way} by {percent(abs(sample.mean) / usual)} (+- {percent(half / usual)})"
            )
    (k, at_opening, n), (k1, at_opening1, n1) = outcomes(rows), outcomes(first)
    for name, own, other in (("clogs", k, k1), ("at the opening", at_opening, at_opening1)):
        p = fisher_p(own, n, other, n1)
        if p is None:
            words.append(f"{name}: no run to judge by")
        elif p >= 1 - CONFIDENCE:
            words.append(f"{name} as often within noise")
        else:
            words.append(f"{name} {'more' if own / n > other / n1 else 'less'} often (p {p:.2g})")
    return words


def draw_variants(rows: "list[Row]", name_of: NameOf) -> "Figure":
    """For each silo: T90 of every run by variant, and how often each clogs, with intervals."""
    from matplotlib.figure import Figure

    silos = variants_of(rows, name_of)
    longest = max(len(variants) for variants in silos.values())
    figure = Figure(figsize=(9.2, len(silos) * (1.1 + 0.36 * longest)), layout="constrained")
    panels = figure.subplots(len(silos), 2, squeeze=False, width_ratios=[1.3, 1])
    for (silo, variants), (times, shares) in zip(silos.items(), panels, strict=True):
        _draw_times(times, variants)
        _draw_shares(shares, variants)
        times.set_title(silo, loc="left", fontweight="bold")
        shares.sharey(times)
        shares.tick_params(labelleft=False)
        times.set_yticks(range(len(variants)), list(variants))
        times.set_ylim(len(variants) - 0.5, -0.5)
    panels[-1, 0].set_xlabel("T90 [s]: runs, mean and its 95 % interval")
    panels[-1, 1].set_xlabel("share of runs (95 % interval)")
    panels[0, 1].legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=2, borderaxespad=0.1)
    return figure


def _draw_times(axes: "Axes", variants: Variants) -> None:
    for k, rows in enumerate(variants.values()):
        times = _values(rows, "t90_s")
        axes.plot(times, [k] * len(times), "o", color=GREY, ms=4, alpha=0.5, mew=0)
        sample = mean_sd(times)
        half = half_width_of_mean(sample)
        if sample.mean is not None and half is not None:
            axes.errorbar(sample.mean, k, xerr=half, fmt="D", color=INK, ms=5, capsize=3)
    ruled(axes, "x")


def _draw_shares(axes: "Axes", variants: Variants) -> None:
    for k, rows in enumerate(variants.values()):
        clogged, at_opening, n = outcomes(rows)
        for count, position, colour, label in (
            (clogged, k - 0.12, BLUE, "clogged"),
            (at_opening, k + 0.12, VERMILION, "of these at the opening"),
        ):
            if not n:
                continue
            low, high = wilson(count, n)
            bars = [[max(count / n - low, 0.0)], [max(high - count / n, 0.0)]]
            axes.errorbar(count / n, position, xerr=bars, fmt="o", color=colour, ms=4.5, capsize=3,
                          label=label if k == 0 else None)  # fmt: skip
    axes.set_xlim(-0.03, 1.03)
    ruled(axes, "x")
