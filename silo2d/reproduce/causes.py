"""Causes of clogging at 100 mm: what the source leaves open, varied one at a time.

Ours clog more often there than the experiment, and D3 takes longer (docs/validation/silos.md). Each
variant changes one setting within what the source leaves open (Alonso-Marroquin et al., Granular
Matter 15 (2013) 811), or beyond it where the question is whether it does anything; all have the
same seeds. They are many: intervals, and tests against the first, are of a confidence of
1 - 0.05/(their number).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from granulab.campaign.output.figure import BLUE, GREEN, GREY, INK, ruled
from granulab.campaign.output.layout import columns, done, not_done, paragraphs, with_sd
from granulab.campaign.output.statistics import (
    CONFIDENCE,
    Counts,
    Sample,
    chance_of_shares,
    half_width_of_mean,
    mean_sd,
    pooled_sd,
    quantile,
    welch_half_width,
    wilson,
)
from silo2d.reproduce.quantities.published import by_silo, outcomes, trials
from silo2d.reproduce.runs import run_of_cases

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from granulab.campaign.sweeps.sweep import Labelled
    from silo2d.case.case import SiloCase
    from silo2d.reproduce import Row

SEEDS = 5  # 20 runs a variant
COLUMNS = ("variant", "silo", "outcome", "discharge_time_s")

SILOS = "A3", "B3", "C3", "D3"
SLOW = "D3"  # whose time does not fit
FIRST = "as shipped"
LIPS = {"lips": True}  # walls that end in an arc; see rounded_lips
_LIP, _PIECES = 5.0, 4  # radius [mm], and pieces of its arc

# The outlines are a reconstruction of a picture: sizes, bevels and corners are ours. Frictions are
# the ends of the ranges that the paper measured (Table 4), its restitutions of 0.45 and 0.53 are
# less than one contact has by its gamma_n, and gamma_t of 3 +- 0.5 1/s is taken to both extremes.
# The plates' friction, the way of opening and of pouring, the edge of the outlet and the rule of
# rest are not printed. The last two are the strongest of the others together, as they came out:
# smaller outlines and pouring in layers clog least, rounded lips are D3's fastest.
VARIANTS: dict[str, dict[str, Any]] = {
    FIRST: {},
    "outlines 10 % smaller": {"particles.scale": 0.9},
    "outlines 5 % smaller": {"particles.scale": 0.95},
    "outlines 5 % larger": {"particles.scale": 1.05},
    "bevels half as large": {"particles.shapes": "wood19-sharp"},
    "bevels a tenth larger": {"particles.shapes": "wood19-blunt"},
    "corners of 0.5 mm": {"particles.spheroradius": "0.5 mm"},
    "corners of 2 mm": {"particles.spheroradius": "2 mm"},
    "particles' friction 0.33": {"law.mu_particle": 0.33},
    "particles' friction 0.43": {"law.mu_particle": 0.43},
    "walls' friction 0.31": {"law.mu_wall": 0.31},
    "walls' friction 0.58": {"law.mu_wall": 0.58},
    "gamma_t 0": {"law.gamma_t": "0 1/s"},
    "gamma_t 100 1/s": {"law.gamma_t": "100 1/s"},
    "restitution as measured": {"law.damping": "restitution"},
    "contacts end at zero force": {"law.contact_end": "force"},
    "plates' friction 0.44": {"law.mu_plates": 0.44, "law.plates_ratio": 0.4},
    "door drawn at 0.5 m/s": {"run.door_speed": "0.5 m/s"},
    "poured with friction": {"fill.friction": True},
    "poured in layers": {"fill.layer": "95 mm"},
    "outlet of 98 mm": {"silo.outlet": "98 mm"},
    "outlet of 102 mm": {"silo.outlet": "102 mm"},
    "lips rounded by 5 mm": LIPS,
    "at rest after 0.5 s": {"run.rest_time": "0.5 s"},
    "10 % smaller, lips rounded": {"particles.scale": 0.9} | LIPS,
    "in layers, lips rounded": {"fill.layer": "95 mm"} | LIPS,
}  # fmt: skip

_CRITERION = """\
clogged: of the runs that ended before the time limit, all four silos together, with Wilson's
  interval. p: chance of counts as unlikely if both shares were equal in each silo (stratified exact
  test), from the first variant and from the experiment.
time: of the runs that emptied; off: difference from the experiment's mean, with the allowance
  t sqrt(s1^2/n1 + s2^2/n2) (Welch), s1 pooled over all variants, as each has a few times only.
fits: p from the experiment is at least 0.05, and D3's time within the allowance of 95 %. excluded:
  one of them is off by more than chance makes one of all variants in 5 % of studies."""


def cases(seeds: Sequence[int]) -> "list[Labelled]":
    """Each variant in the four silos, with all seeds."""
    from granulab.campaign.sweeps.sweep import over_seeds

    return [
        labelled
        for variant in VARIANTS
        for silo in SILOS
        for labelled in over_seeds({"variant": variant, "silo": silo}, case(variant, silo), seeds)
    ]


def case(variant: str, silo: str) -> "SiloCase":
    """A silo with the changes of a variant."""
    from granulab.contact.files.casefile import changed
    from silo2d.case.case import SiloCase
    from silo2d.case.settings import Settings

    changes = dict(VARIANTS[variant])
    if not changes.pop("lips", False):
        return SiloCase.load(silo, changes)
    document: dict[str, Any] = {"name": silo, "silo": {"outline": rounded_lips(silo)}}
    return SiloCase.resolve(changed(document, changes, Settings), silo, Path())


def rounded_lips(silo: str) -> list[list[float]]:
    """Corners [mm] of a preset whose walls end in an arc down to its outlet.

    The arc about (D/2 + r, 0) begins at the lip, upright, and meets the hopper's wall, at an angle
    a from the horizontal, at (D/2 + r (1 - sin a), r cos a). The outlet keeps its width D.
    """
    from silo2d.case.outline import preset, preset_sizes

    own = preset(silo)
    angle, outlet = preset_sizes(silo)
    half, wide, high = 500.0 * outlet, 500.0 * own.width, 1000.0 * own.height
    turns = [k / _PIECES * (math.pi / 2 - angle) for k in range(_PIECES + 1)]
    right = [[half + _LIP * (1 - math.cos(t)), _LIP * math.sin(t)] for t in turns]
    x, y = right[-1]
    right += [[wide, y + (wide - x) * math.tan(angle)], [wide, high]]
    return [*right, *([-x, y] for x, y in reversed(right))]


run = run_of_cases(cases)


def by_variant(rows: "Sequence[Row]") -> "dict[str, list[Row]]":
    """The rows of each variant, in their order."""
    names = dict.fromkeys(row["variant"] for row in rows)
    return {name: [row for row in rows if row["variant"] == name] for name in names}


@dataclass(frozen=True)
class Judged:
    """A variant beside the first and the experiment."""

    counts: dict[str, tuple[int, int]]  # of each silo, clogged and ended
    p_first: float | None  # None: this is the first, or one has no run
    p_experiment: float | None
    time: Sample  # of the slow silo [s]
    off: float | None  # of its mean from the experiment's [s]
    allowed: float | None  # [s], of 95 %
    allowed_of_all: float | None  # [s], of the confidence for all variants together

    @property
    def clogged(self) -> tuple[int, int]:
        """Runs that clogged, and that ended, of all silos."""
        k, n = (sum(part) for part in zip(*self.counts.values(), strict=True))
        return k, n

    @property
    def fits(self) -> bool:
        """Agreement of counts and time with the experiment, within noise."""
        if self.p_experiment is None or self.off is None or self.allowed is None:
            return False
        return self.p_experiment >= 1 - CONFIDENCE and abs(self.off) <= self.allowed

    def excluded(self, confidence: float) -> bool:
        """Disagreement of one of them by more than the noise of all variants together."""
        clogs = self.p_experiment is not None and self.p_experiment < 1 - confidence
        late = self.off is not None and self.allowed_of_all is not None
        return clogs or (late and abs(self.off or 0.0) > (self.allowed_of_all or 0.0))


def judged(rows: "Sequence[Row]") -> dict[str, Judged]:
    """Each variant by its name; the first of the rows is what the others are compared with."""
    variants = by_variant(rows)
    found: dict[str, Judged] = {}
    shared = scatter(rows)
    for name, runs_of in variants.items():
        own = by_silo(runs_of)
        counts = {silo: outcomes(runs)[::2] for silo, runs in own.items()}
        base = next(iter(found.values())).counts if found else {}
        printed = {silo: (trials(silo).clogged, trials(silo).n) for silo in own}
        time, theirs = _time(own.get(SLOW, [])), trials(SLOW).time
        known = time.mean is not None and theirs.mean is not None
        noise = [_noise(time, theirs, shared, c) for c in (CONFIDENCE, certainty(len(variants)))]
        found[name] = Judged(
            counts, _chance(counts, base), _chance(counts, printed), time,
            time.mean - theirs.mean if known else None,  # type: ignore[operator]
            *noise,
        )  # fmt: skip
    return found


def scatter(rows: "Sequence[Row]") -> tuple[float, int] | None:
    """Standard deviation of the slow silo's times [s] that all variants share, and its freedom."""
    each = by_variant(rows).values()
    return pooled_sd([_time(by_silo(own).get(SLOW, [])) for own in each])


def _noise(
    ours: Sample, theirs: Sample, shared: tuple[float, int] | None, confidence: float
) -> float | None:
    if not ours.n or theirs.sd is None or shared is None:
        return None
    errors = [shared[0] ** 2 / ours.n, theirs.sd**2 / theirs.n]
    return welch_half_width(errors, [shared[1], theirs.n - 1], confidence)


def certainty(variants: int) -> float:
    """Confidence of both tests of each variant, counts and time, at which chance alone excludes one
    of all variants in 5 % of studies at most (Bonferroni)."""
    return 1.0 - (1.0 - CONFIDENCE) / (2 * variants)


def _chance(counts: dict[str, tuple[int, int]], others: dict[str, tuple[int, int]]) -> float | None:
    strata = [
        Counts(k, n, *others[silo]) for silo, (k, n) in counts.items() if n and others.get(silo)
    ]
    strata = [one for one in strata if one.other_n]
    return chance_of_shares(strata) if strata else None


def _time(rows: "Sequence[Row]") -> Sample:
    return mean_sd([row["discharge_time_s"] for row in done(rows) if row["discharge_time_s"]])


def report(rows: "list[Row]") -> str:
    """Counts and times of each variant beside the experiment, and which fit or are excluded."""
    found = judged(rows)
    certain = certainty(len(found))
    counts = columns(
        ["variant", *SILOS, "clogged", f"{100 * certain:.1f} % interval", "p first",
         "p experiment"],
        [_counts_line(name, one, certain) for name, one in found.items()],
    )  # fmt: skip
    times = columns(
        ["variant", *(f"{silo} [s]" for silo in SILOS), f"{SLOW} off [s]"],
        [_times_line(name, found[name], own) for name, own in by_variant(rows).items()],
    )
    failed = "\n".join(not_done(rows, ["variant", "silo", "seed"]))
    return paragraphs(counts, times, _words(found), _CRITERION, failed)


def _counts_line(name: str, one: Judged, certain: float) -> list[str]:
    k, n = one.clogged
    low, high = wilson(k, n, certain)
    ps = ["-" if p is None else f"{p:.2g}" for p in (one.p_first, one.p_experiment)]
    each = ["{} of {}".format(*one.counts.get(silo, (0, 0))) for silo in SILOS]
    return [name, *each, f"{k} of {n}", f"{low:.2f} to {high:.2f}", *ps]


def _times_line(name: str, one: Judged, rows: "list[Row]") -> list[str]:
    own = by_silo(rows)
    off = "-" if one.off is None else f"{one.off:+.2f}"
    if one.off is not None and one.allowed is not None:
        off += f" (+- {one.allowed:.2f}, for all {one.allowed_of_all:.2f})"
    return [name, *(with_sd(_time(own.get(silo, [])), 2) for silo in SILOS), off]


def _words(found: dict[str, Judged]) -> str:
    """Names of the variants of each verdict."""
    certain = certainty(len(found))
    first = next(iter(found.values()))
    share = first.clogged[0] / max(first.clogged[1], 1)
    differ = {
        name: one for name, one in found.items()
        if one.p_first is not None and one.p_first < 1 - certain
    }  # fmt: skip
    less = [name for name, one in differ.items() if one.clogged[0] / one.clogged[1] < share]
    named = {
        "fit the experiment": [name for name, one in found.items() if one.fits],
        "excluded": [name for name, one in found.items() if one.excluded(certain)],
        f"clog less often than {next(iter(found))}": less,
        f"clog more often than {next(iter(found))}": [name for name in differ if name not in less],
        f"of {SLOW}'s time nothing is known": [n for n, one in found.items() if one.off is None],
    }
    return "\n".join(f"{verdict}: {', '.join(names) or 'none'}" for verdict, names in named.items())


def draw(rows: "list[Row]") -> "Figure":
    """Share of clogged runs and time of the slow silo by variant, with the experiment's bands."""
    from matplotlib.figure import Figure

    found = judged(rows)
    certain, shared, variants = certainty(len(found)), scatter(rows), by_variant(rows)
    figure = Figure(figsize=(9.2, 1.3 + 0.27 * len(found)), layout="constrained")
    shares, times = figure.subplots(1, 2, sharey=True)
    printed = [trials(silo) for silo in SILOS]
    between = wilson(sum(one.clogged for one in printed), sum(one.n for one in printed))
    shares.axvspan(*between, color=GREEN, alpha=0.15, lw=0)
    theirs = trials(SLOW).time
    half = half_width_of_mean(theirs)
    if theirs.mean is not None and half is not None:
        times.axvspan(theirs.mean - half, theirs.mean + half, color=GREEN, alpha=0.15, lw=0)
    for k, (name, one) in enumerate(found.items()):
        count, n = one.clogged
        if n:
            low, high = wilson(count, n, certain)
            bars = [[count / n - low], [high - count / n]]
            shares.errorbar(count / n, k, xerr=bars, fmt="o", color=BLUE, ms=4.5, capsize=2)
        own = by_silo(variants[name]).get(SLOW, [])
        each = [row["discharge_time_s"] for row in done(own) if row["discharge_time_s"]]
        times.plot(each, [k] * len(each), "o", color=GREY, ms=4, alpha=0.5, mew=0)
        if one.time.mean is not None:
            wide = shared and quantile(shared[1], certain) * shared[0] / math.sqrt(one.time.n)
            times.errorbar(one.time.mean, k, xerr=wide, fmt="D", color=INK, ms=4.5, capsize=2)
    shares.set_yticks(range(len(found)), list(found))
    shares.set_ylim(len(found) - 0.5, -0.5)
    shares.set(xlim=(-0.02, 1.02), xlabel=f"clogged, of {', '.join(SILOS)} together")
    times.set(xlim=(1.5, 4.5), xlabel=f"time of {SLOW} [s]: runs and mean")
    for axes in (shares, times):
        ruled(axes, "x")
    shares.plot([], [], lw=6, color=GREEN, alpha=0.3, label="experiment, 95 %")
    shares.errorbar([], [], xerr=[], fmt="o", color=BLUE, ms=4.5, capsize=2,
                    label=f"ours, {100 * certain:.1f} %")  # fmt: skip
    figure.legend(loc="outside upper right", ncols=2)
    return figure
