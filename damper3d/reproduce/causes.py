"""Causes of the half V: what the thesis leaves open about the onset's rise, varied one at a time.

The thesis says that prolates of 1.5 bounce at a Gamma more than 50 % above that of spheres (sec.
8.5.1.2); ours do at some 24 % (`shapes`). Each variant changes one setting within what the thesis
leaves open, or beyond it where the question is whether it does anything, of spheres and of those
prolates; all have the same seeds. The readings take the onset from the same runs in other ways: on
the thesis's Gammas alone, which lie at 15, 20, 30 and 40, by its largest point or by a fitted curve
("curves fitted to the datapoints", sec. 8.5.1.1, of which it does not say more).
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import product
from statistics import fmean
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from damper3d.reproduce.panels import (
    ORIENTATIONS,
    Panel,
    Row,
    completeness,
    labels_of,
    run_of_panels,
)
from damper3d.reproduce.quantities.optima import Optimum, pooled_scatter, with_scatter
from damper3d.reproduce.quantities.shapes import BOUNCING, Line, optimum_of
from damper3d.reproduce.shapes import about, panel
from damper3d.studies.map.grid import GAMMAS, MapResult, counted
from damper3d.studies.map.peaks import Floats, find_peaks, highest
from granulab.campaign.output.layout import columns, done, paragraphs, signed
from granulab.campaign.output.statistics import CONFIDENCE, mean_sd, pooled_sd, quantile

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SEEDS = 1
REFINE = 2
# Of ln Gamma over packings, and its degrees of freedom: of 48 onsets of three packings each that
# `shapes` has at 40 Hz (docs/results). It stands for that of this table where that has one packing.
SCATTER = 0.023, 96
COLUMNS = (
    "variant", "ratio", "orientation", "frequency_hz", "gamma", "fill_ratio", "efficiency",
    "efficiency_interval", "efficiency_wall_work", "energy_closure",
)  # fmt: skip

RATIOS = 1.0, 1.5  # the sphere, and the prolate whose onset the thesis has more than 50 % above
PRINTED = 0.5
Where = tuple[float, str]  # frequency [Hz] and orientation
Found = Mapping[tuple[str, Where], tuple[Optimum, Optimum]]  # of each variant, at each place
AT: Where = (40.0, "vertical")  # of all variants; the first is run in all four
FIRST = "as shipped"

# The thesis prints material and law (Table 6.2), 51 sub-spheres, 18 cycles of which 15 count, and
# none of the rest; of the printed ones the question is whether they do anything.
VARIANTS: dict[str, dict[str, Any]] = {
    FIRST: {},
    "settled without friction": {"fill.friction": False},
    "30 more cycles left out": {"run.cycles": 48, "run.discard": 33},
    "5 cycles count": {"run.cycles": 8},
    "motion grows over 3 cycles": {"motion.ramp": 3},
    "contacts: deepest": {"law.contact_treatment": "deepest"},
    "contacts: scaled": {"law.contact_treatment": "scaled"},
    "21 sub-spheres": {"particles.sub_spheres": 21},
    "101 sub-spheres": {"particles.sub_spheres": 101},
    "restitution 0.75": {"law.restitution": 0.75},
    "restitution 0.95": {"law.restitution": 0.95},
    "friction 0.1": {"law.friction": 0.1},
    "friction 0.3": {"law.friction": 0.3},
    "friction 0.8": {"law.friction": 0.8},
    "walls' friction 0.1": {"law.friction_wall": 0.1},
    "contacts end at zero force": {"law.contact_end": "force"},
    "springs carry the force": {"law.tangential": "force"},
}

_CRITERION = """\
onset: as in `shapes`, by a parabola through the top of eta, geometric mean +- standard deviation
  over the packings (their number). rise: of the prolate's over the sphere's, with the 95 % interval
  t s sqrt(1/n1 + 1/n2), s of ln Gamma over packings, of variants pooled over all of them; where
  there is one packing, 2.3 % as of the onsets of `shapes`. differs:
  from the first by more than chance makes one of all variants in 5 % of studies; reaches: its
  interval holds the printed +50 % or lies above. as read: by a spline on the thesis's Gammas.
readings: of the first variant's packings, one by one; thesis's: of its Gammas alone (Table 6.1).
  spline: a cubic one through all of them, over ln Gamma or over Gamma. steepest: the middle of the
  two neighbours between which eta rises most: no peak, but where bouncing begins."""


def panels() -> list[Panel]:
    """Both shapes of each variant about the onset; the first at all frequencies and directions."""
    places: list[tuple[str, str, Sequence[float]]] = [(FIRST, o, BOUNCING) for o in ORIENTATIONS]
    places += [(variant, AT[1], AT[:1]) for variant in VARIANTS if variant != FIRST]
    return [_panel(*place, ratio) for place in places for ratio in RATIOS]


def _panel(variant: str, orientation: str, frequencies: Sequence[float], ratio: float) -> Panel:
    shape = "spheroid", ratio
    points = [(frequency, g) for frequency in frequencies for g in about(shape, frequency)]
    shipped = panel(shape, orientation, points)
    labels = {"variant": variant, "ratio": ratio, "orientation": orientation}
    return Panel(labels, shipped.changes | VARIANTS[variant], shipped.points)


run = run_of_panels(panels, REFINE)


class Reading(NamedTuple):
    """A way to take an onset from a curve of eta along Gamma.

    of       from Gammas (n,) and eta (n,) [-]; NaN where the curve has none
    printed  whether of the thesis's Gammas alone
    column   that eta is taken from
    """

    of: Callable[[Floats, Floats], float]
    printed: bool = True
    column: str = "efficiency"


def by_parabola(gamma: Floats, eta: Floats) -> float:
    """Gamma of the vertex of the parabola about the highest peak."""
    top = highest(find_peaks(gamma, eta, np.zeros(len(eta))))
    return math.nan if top is None else top.gamma


def by_largest(gamma: Floats, eta: Floats) -> float:
    """The Gamma of the largest eta."""
    return float(gamma[np.argmax(eta)])


def by_spline(gamma: Floats, eta: Floats) -> float:
    """The Gamma at which a cubic spline through all points is highest."""
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(gamma, eta)
    turns = spline.derivative().roots(extrapolate=False)
    tops = [turn for turn in turns if spline(turn, 2) < 0]
    return float(max(tops, key=spline)) if tops else math.nan


def by_spline_of_logarithm(gamma: Floats, eta: Floats) -> float:
    """The same over ln Gamma."""
    return math.exp(by_spline(np.log(gamma), eta))


def by_steepest(gamma: Floats, eta: Floats) -> float:
    """The geometric middle of the neighbours between which eta rises most over ln Gamma."""
    k = int(np.argmax(np.diff(eta) / np.diff(np.log(gamma))))
    return math.sqrt(gamma[k] * gamma[k + 1])


READINGS = {
    "parabola": Reading(by_parabola, printed=False),
    "parabola, by the walls' work": Reading(by_parabola, False, "efficiency_wall_work"),
    "largest point": Reading(by_largest, printed=False),
    "steepest": Reading(by_steepest, printed=False),
    "thesis's, parabola": Reading(by_parabola),
    "thesis's, spline over ln Gamma": Reading(by_spline_of_logarithm),
    "thesis's, spline over Gamma": Reading(by_spline),
    "thesis's, largest point": Reading(by_largest),
}
FITTED = "thesis's, spline over ln Gamma"  # as the thesis may have read them


class Rise(NamedTuple):
    """An onset's rise from the sphere to the prolate, in ln Gamma.

    error    its standard error, from the scatter of packings; NaN where there is one packing each
    freedom  degrees of freedom of that scatter
    """

    value: float
    error: float
    freedom: int
    onsets: tuple[float, float]  # Gamma of the sphere and the prolate

    def half_width(self, confidence: float = CONFIDENCE) -> float:
        """Half width of its interval, in ln Gamma; infinite where the scatter is not known."""
        return quantile(self.freedom, confidence) * self.error if self.freedom else math.inf

    @property
    def words(self) -> str:
        """In per cent of the sphere's onset, such as "+24 % (+19 to +29)"."""
        half = self.half_width()
        low, high = (math.expm1(self.value + side * half) for side in (-1, 1))
        # Largest points of all packings may be the same: their scatter says nothing then.
        around = f" ({100 * low:+.0f} to {100 * high:+.0f})" if 0 < half < math.inf else ""
        return signed(math.expm1(self.value)) + around

    @property
    def reaches(self) -> bool:
        """True where the interval holds the printed rise, or lies above it."""
        half = self.half_width() if self.freedom else 0.0
        return self.value + half >= math.log1p(PRINTED)


def rows_at(rows: Iterable[Row], variant: str, where: Where, ratio: float) -> list[Row]:
    """The rows of a curve."""
    own = variant, ratio, *where
    labels = "variant", "ratio", "frequency_hz", "orientation"
    return [row for row in rows if tuple(row[name] for name in labels) == own]


def optima(rows: Sequence[Row]) -> Found:
    """The onsets of both shapes, of each variant at each place where both have a peak."""
    places = dict.fromkeys(
        (row["variant"], (row["frequency_hz"], row["orientation"])) for row in done(rows)
    )
    found = {}
    for variant, where in places:
        sphere, prolate = (
            optimum_of(
                rows_at(rows, variant, where, ratio), Line(("spheroid", ratio), where[1], where[0])
            )
            for ratio in RATIOS
        )
        if sphere and prolate:
            found[variant, where] = sphere, prolate
    return found


def rises(found: Found) -> dict[tuple[str, Where], Rise]:
    """The rise of each variant at each place; all share one scatter over packings."""
    shared = pooled_scatter([one for both in found.values() for one in both]) or SCATTER
    return {
        key: rise_of([one.alone or (math.log(one.gamma),) for one in both], shared)
        for key, both in found.items()
    }


def rise_of(onsets: Sequence[Sequence[float]], shared: tuple[float, int] | None = None) -> Rise:
    """The rise from onsets, ln Gamma, of the packings of the sphere and of the prolate.

    shared: standard deviation over packings and its degrees of freedom; left out, their own.
    """
    samples = [mean_sd(own) for own in onsets]
    sphere, prolate = map(fmean, onsets)
    sd, freedom = shared or pooled_sd(samples) or (math.nan, 0)
    error = sd * math.sqrt(sum(1 / one.n for one in samples))
    return Rise(prolate - sphere, error, freedom, (math.exp(sphere), math.exp(prolate)))


def read_rise(
    rows: Sequence[Row], reading: Reading, where: Where, variant: str = FIRST
) -> Rise | None:
    """The rise of a variant as a reading takes it; None where a shape has no onset."""
    onsets = []
    for ratio in RATIOS:
        own = counted(rows_at(rows, variant, where, ratio), reading.column)
        seeds = sorted({row["seed"] for row in done(own)})
        read = [_read([row for row in own if row["seed"] == seed], reading) for seed in seeds]
        onsets.append([math.log(one) for one in read if math.isfinite(one)])
    return rise_of(onsets) if all(onsets) else None


def _read(rows: Sequence[Row], reading: Reading) -> float:
    """The onset of one packing."""
    kept = [row for row in rows if not reading.printed or row["gamma"] in GAMMAS]
    kept = [row for row in kept if row.get("efficiency") is not None]
    curve = MapResult.of(kept)
    known = np.isfinite(curve.efficiency)
    if np.count_nonzero(known) < 4:
        return math.nan
    return reading.of(curve.gamma[known], curve.efficiency[known])


def report(rows: list[Row]) -> str:
    """Return what lacks, the rise of each variant and reading, and which reach what is printed."""
    found = optima(rows)
    risen = rises(found)
    return paragraphs(
        completeness(rows, labels_of(panels()), SEEDS),
        _variant_table(rows, found, risen),
        _reading_table(rows),
        _words(rows, risen),
        _CRITERION,
    )


def _variant_table(
    rows: Sequence[Row], found: Found, risen: Mapping[tuple[str, Where], Rise]
) -> str:
    lines = [
        [variant, f"{frequency:g} Hz {orientation}", *(with_scatter(one) for one in both),
         *(f"{one.mean.efficiency:.3f}" for one in both),
         risen[variant, (frequency, orientation)].words,
         _percent(read_rise(rows, READINGS[FITTED], (frequency, orientation), variant))]
        for (variant, (frequency, orientation)), both in found.items()
    ]  # fmt: skip
    heads = ["variant", "where", "sphere", "prolate of 1.5", "eta", "eta of 1.5", "rise", "as read"]
    return columns(heads, lines) if lines else ""


def _reading_table(rows: Sequence[Row]) -> str:
    places = list(product(BOUNCING, ORIENTATIONS))
    lines = []
    for name, reading in READINGS.items():
        read = [read_rise(rows, reading, where) for where in places]
        lines.append([name, *(_read_words(one) for one in read)])
    heads = ["reading", *(f"{frequency:g} Hz {orientation}" for frequency, orientation in places)]
    return columns(heads, lines) if done(rows) else ""


def _percent(rise: Rise | None) -> str:
    return "-" if rise is None else signed(math.expm1(rise.value))


def _read_words(rise: Rise | None) -> str:
    if rise is None:
        return "-"
    sphere, prolate = rise.onsets
    return f"{sphere:.3g} to {prolate:.3g}, {rise.words}"


def _words(rows: Sequence[Row], risen: Mapping[tuple[str, Where], Rise]) -> str:
    """Names of the variants and readings of each verdict, at the place that all have."""
    here = {variant: rise for (variant, where), rise in risen.items() if where == AT}
    first = here.get(FIRST)
    if first is None:
        return ""
    certain = 1 - (1 - CONFIDENCE) / max(len(here) - 1, 1)
    differ = [
        name
        for name, rise in here.items()
        if abs(rise.value - first.value)
        > math.hypot(*(r.half_width(certain) for r in (rise, first)))
    ]
    read = {name: read_rise(rows, reading, AT) for name, reading in READINGS.items()}
    named = {
        f"reach the printed {signed(PRINTED)}": [n for n, rise in here.items() if rise.reaches],
        f"differ from {FIRST}": differ,
        "readings that reach it": [name for name, rise in read.items() if rise and rise.reaches],
    }
    verdicts = (f"  {verdict}: {', '.join(own) or 'none'}" for verdict, own in named.items())
    return "\n".join([f"{AT[0]:g} Hz, {AT[1]}:", *verdicts])


def draw(rows: list[Row]) -> "Figure":
    """The rise of each variant and reading; both curves, with the thesis's Gammas marked."""
    from damper3d.reproduce.figures.causes import draw_causes

    return draw_causes(rows)
