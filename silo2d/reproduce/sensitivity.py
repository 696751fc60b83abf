"""A4's discharge time against each contact parameter, from two baselines, compared with SPOLY's."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from granulab.campaign.output.figure import BLUE, ORANGE, VERMILION, entries, ruled, ticked
from granulab.campaign.output.layout import columns, done, not_done, percent, signed, with_sd
from granulab.campaign.output.statistics import Sample, noise_of_one_more, pooled_sd
from silo2d.reproduce.parameters import BASELINES, Pairs
from silo2d.reproduce.quantities.published import ROUNDING, Point, outcomes, sensitivity
from silo2d.reproduce.quantities.trends import LOGARITHMIC, Series, Trend, series_of
from silo2d.reproduce.runs import run_of_cases

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from granulab.campaign.sweeps.sweep import Labelled
    from silo2d.reproduce import Row

SEEDS = 3
COLUMNS = (
    "baseline", "parameter", "pairs", "value", "unit", "outcome", "discharge_time_s", "t90_s",
    "restitution.", "state_digest",
)  # fmt: skip

# Parameter and pairs of contacts, in the order of the paper's tables: a heading each.
SERIES: dict[tuple[str, Pairs], str] = {
    ("kn", "both"): "kn [N/mm] of all contacts, kt/kn and gamma_n/omega_0 held (Table 7)",
    ("kt", "both"): "kt [N/mm] of all contacts (Table 8)",
    ("mu", "both"): "mu of all contacts (Table 9)",
    ("mu", "particle"): "mu between particles alone (not published)",
    ("mu", "wall"): "mu at the walls alone (not published)",
    ("gamma_n", "both"): "gamma_n [1/s] of all contacts (Table 10)",
    ("gamma_t", "both"): "gamma_t [1/s] of all contacts (Table 11)",
}
_CRITERION = """\
eps: printed; then of ours, as it follows from the mean particle's mass, between particles through
  one contact / face to face (8 pairs). Times: mean +- standard deviation (number of runs that
  emptied); T90, when 90 % of those that leave are out, is less at the mercy of stragglers.
row: SPOLY's is one run. "agrees" where it lies within the 95 % interval of one more run about our
  mean, t s sqrt(1 + 1/n), with s pooled over all rows of the baseline.
trend: least-squares slope, against the logarithm of kn, kt, gamma_n and against mu and gamma_t
  themselves, over the table's range and as a part of the mean time, with its 95 % interval. Rises
  or falls where the interval leaves out 0. "agrees" where the slopes differ by less than the 95 %
  interval of their difference (Welch); the printed times scatter at least by their rounding.
baselines: Table 4: kn 1e4, kt 650 N/mm, mu 0.38 and 0.44 (wall), gamma_n 6085 and 4303 (wall),
  gamma_t 3 1/s. implied, by the rows of 0.99 s: kt 1000 N/mm, mu 0.40 and gamma_n 4000 1/s of all
  contacts, the rest as in Table 4."""


def cases(seeds: Sequence[int]) -> "list[Labelled]":
    """Every row of Tables 7 to 11 from both baselines; a case that two rows share runs once."""
    from granulab.campaign.sweeps.sweep import over_seeds
    from silo2d.case.case import SiloCase

    loaded: dict[tuple, SiloCase] = {}
    found: list[Labelled] = []
    for labels, changes in _wanted():
        law = tuple(changes.items())
        loaded[law] = loaded.get(law) or SiloCase.load("A4", changes)
        found += over_seeds(labels, loaded[law], seeds)
    return found


run = run_of_cases(cases)


def _wanted() -> Iterator[tuple[dict[str, Any], dict[str, Any]]]:
    """The labels, and the changes of the case, of each row of the tables."""
    for name, baseline in BASELINES.items():
        for parameter, pairs in SERIES:
            for point in _published(parameter):
                changed = baseline.varied(parameter, point.value, pairs)
                labels = {"baseline": name, "parameter": parameter, "pairs": pairs}
                yield labels | {"value": point.value, "unit": point.unit}, changed.changes()


def _published(parameter: str) -> list[Point]:
    return [point for point in sensitivity() if point.parameter == parameter]


def report(rows: "list[Row]") -> str:
    """A table a parameter, with the trends in words."""
    series = series_of(rows)
    spread = {name: _spread(name, series) for name in BASELINES}
    parts = [
        f"{heading}\n{_table(series[key], spread)}\n{_trends(series[key])}"
        for key, heading in SERIES.items()
        if key in series
    ]
    scatter = "scatter of a run, pooled: " + "; ".join(
        f"{name} " + (f"{known[0]:.3f} s ({known[1]} degrees of freedom)" if known else "unknown")
        for name, known in spread.items()
    )
    labels = ["baseline", "parameter", "pairs", "value", "seed"]
    failed = "\n".join(not_done(rows, labels))
    return "\n\n".join(filter(None, [*parts, scatter, _CRITERION, failed]))


def _spread(
    baseline: str, series: dict[tuple[str, str], dict[str, Series]]
) -> tuple[float, int] | None:
    """The standard deviation of a run about the mean of its row, and its degrees of freedom."""
    own = [one[baseline] for one in series.values() if baseline in one]
    distinct = {
        tuple(row["state_digest"] for row in done(s.at(value))): s.time(value)
        for s in own
        for value in s.values
    }
    return pooled_sd(list(distinct.values()))


def _table(one: dict[str, Series], spread: dict[str, tuple[float, int] | None]) -> str:
    parameter, pairs = next((s.parameter, s.pairs) for s in one.values())
    points = _published(parameter)
    with_eps = any(point.restitution is not None for point in points)
    header = ["  value", "SPOLY [s]", *(["eps"] if with_eps else [])]
    for name in one:
        header += [f"{name}: [s]", "row", "T90 [s]", *(["eps"] if with_eps else [])]
    lines = []
    for point in points:
        printed = point.time_s if pairs == "both" else None
        line = [f"  {point.value:g}", "-" if printed is None else f"{printed:.2f}"]
        line += [f"{point.restitution:g}"] if with_eps else []
        for name, own in one.items():
            line += _cells(own, point.value, printed, spread[name])
            line += [_restitution(own.at(point.value))] if with_eps else []
        lines.append(line)
    return columns(header, lines)


def _cells(
    own: Series, value: float, printed: float | None, spread: tuple[float, int] | None
) -> list[str]:
    rows, time = own.at(value), own.time(value)
    clogged, _, _ = outcomes(rows)
    rest = len(rows) - time.n - clogged
    remark = f", {clogged} clogged" if clogged else ""
    remark += f", {rest} failed or cut off" if rest else ""
    t90 = with_sd(own.time(value, "t90_s"))
    return [with_sd(time) + remark, _row_word(time, printed, spread), t90]


def _restitution(rows: "list[Row]") -> str:
    """Between particles, through one contact and face to face; the same for all seeds."""
    names = [f"restitution.particle_particle.{how}" for how in ("one_contact", "face_to_face")]
    values = next(([row[name] for name in names] for row in done(rows)), None)
    return " / ".join(f"{value:.2f}" for value in values) if values else "-"


def _row_word(time: Sample, printed: float | None, spread: tuple[float, int] | None) -> str:
    if printed is None or time.mean is None:
        return "-"
    off = time.mean / printed - 1
    if spread is None:
        return f"{signed(off)}, too few to judge"
    if abs(time.mean - printed) <= noise_of_one_more(time.n, *spread):
        return "agrees"
    return f"{'high' if off > 0 else 'low'} by {percent(abs(off))}"


def _trends(one: dict[str, Series]) -> str:
    parameter, pairs = next((s.parameter, s.pairs) for s in one.values())
    points = _published(parameter)
    published = Trend.of(parameter, [p.value for p in points], [p.time_s for p in points], ROUNDING)
    lines = []
    if pairs == "both" and published:
        lines.append(f"  SPOLY {published.words()}")
    for name, own in one.items():
        mine, of_t90 = own.trend(), own.trend("t90_s")
        if mine is None or of_t90 is None:
            lines.append(f"  {name}: too few runs for a trend")
            continue
        word = f": {mine.compared_with(published)}" if pairs == "both" and published else ""
        lines.append(f"  {name}: {mine.words()}{word}; T90 {of_t90.words()}")
    return "\n".join(lines)


_LABELS = {
    "kn": "kn [N/mm], kt/kn and gamma_n/omega_0 held",
    "kt": "kt [N/mm]",
    "mu": "mu [-]",
    "gamma_n": "gamma_n [1/s]",
    "gamma_t": "gamma_t [1/s]",
}
_COLOURS = {"Table 4": BLUE, "implied": ORANGE}
_PAIRS: dict[str, tuple[str, dict[str, Any]]] = {
    "both": ("", {"fmt": "o-"}),
    "particle": (", particles alone", {"fmt": "^--", "mfc": "white", "lw": 0.9}),
    "wall": (", walls alone", {"fmt": "v:", "mfc": "white", "lw": 0.9}),
}


def draw(rows: "list[Row]") -> "Figure":
    """Published times and ours with standard deviations, by baseline; a panel a parameter."""
    from matplotlib.figure import Figure

    published = {p: _published(p) for p in dict.fromkeys(key for key, _ in SERIES)}
    figure = Figure(figsize=(10.5, 6.2), layout="constrained")
    panels = figure.subplots(2, 3, sharey=True)
    for axes, (parameter, points) in zip(panels.flat, published.items(), strict=False):
        _scale(axes, parameter, [point.value for point in points])
        axes.set_xlabel(_LABELS[parameter])
        axes.plot([p.value for p in points], [p.time_s for p in points], "D", color=VERMILION,
                  ms=5, label="SPOLY", zorder=3)  # fmt: skip
        for (name, pairs), one in series_of(rows).items():
            for own in one.values() if name == parameter else ():
                _draw_series(axes, own, pairs)
    for axes in panels[:, 0]:
        axes.set_ylabel("discharge time of A4 [s]")
    panels[-1, -1].axis("off")
    handles = entries(panels.flat)
    panels[-1, -1].legend(handles.values(), handles.keys(), loc="center", title="mean and sd")
    return figure


def _scale(axes: "Axes", parameter: str, values: list[float]) -> None:
    """Ticks at the published values, as the paper spaces them."""
    if parameter in LOGARITHMIC:
        axes.set_xscale("log")
    elif parameter == "gamma_t":
        axes.set_xscale("symlog", linthresh=3)
    ticked(axes, values)
    ruled(axes)


def _draw_series(axes: "Axes", own: "Series", pairs: str) -> None:
    words, style = _PAIRS[pairs]
    samples = [(value, own.time(value)) for value in own.values]
    known = [(value, s.mean, s.sd or 0) for value, s in samples if s.mean is not None]
    if known:
        x, y, bars = zip(*known, strict=True)
        axes.errorbar(x, y, bars, color=_COLOURS[own.baseline], capsize=3, ms=4.5,
                      label=f"ours, {own.baseline}{words}", **style)  # fmt: skip
