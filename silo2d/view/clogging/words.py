"""The report of clogging by outlet: tables and sentences."""

from collections.abc import Mapping
from typing import Any

from granulab.campaign.output.layout import columns, paragraphs, share
from silo2d.measures.clogging.study import laws_of

_NOTES = """\
<s>: particles that leave between two clogs, those of cut avalanches over the clogs; intervals are
  of 95 %. The avalanche from the opening is not among them. runs alike: p that the runs of an
  outlet share one <s>; below 0.05 they scatter more than that, and the intervals are wider by it.
first flow clogged: of the runs, before as many left as the silo holds; "-" where that is not known.
clogs: probability that the filled silo, which is not refilled, clogs before it is empty, of <s>;
  the silos that clog at an outlet likewise, of the law of <s>.
beta: exponent of P(more than s) = exp(-lambda s^beta), from 20 clogs on; p: of an exponential.
r: rank correlation of successive sizes. arch: particles, mean and most.
alpha: of the waiting times' density t^-alpha, from one time on at all outlets up to that which
  counts as a clog."""
_NAMES = {"A": "A", "C": "C", "critical": "critical D/d", "g": "g"}
_ENDS = {
    "rathole": "in a rathole: their beds stood around a channel, through which what is put on top "
    "falls",
    "stuck": "early, as no break of many in a row let anything out",
    "dead_zones": "early, at rest with nothing over the outlet",
    "time_limit": "early, as nothing came out and nothing lay still",
}
_FORMS = {"exponential": "A exp(C (D/d)^2)", "power": "A (1 - D/D_c)^-g"}


def in_words(found: Mapping[str, Any]) -> str:
    """Tables by outlet, the laws, and what they say of the silo."""
    outlets = found["outlets"]
    first = columns(
        ["outlet", "D/d", "avalanches", "cut", "<s>", "runs alike", "clogs", "first flow clogged"],
        [
            [
                f"{1e3 * one['outlet_m']:g} mm", f"{one['outlet_over_diameter']:.2f}",
                str(one["avalanches"]), str(one["cut"]), _mean(one), _p(one["runs_alike"]),
                _interval(one["clogs_before_empty"], one["clogs_before_empty_interval"], ".2f"),
                share(one["clogged"], one["runs"]) if one["runs"] else "-",
            ]
            for one in outlets
        ],
    )  # fmt: skip
    second = columns(
        ["outlet", "beta", "p", "beta beyond the mode", "p", "r of successive", "arch", "span",
         "alpha of waits"],
        [
            [
                f"{1e3 * one['outlet_m']:g} mm", *_form(one["form"]),
                *_form(one["form_beyond_mode"]), _correlation(one["independence"]),
                *_arch(one), _tail(one["waits_tail"]),
            ]
            for one in outlets
        ],
    )  # fmt: skip
    said = [*_laws(found), *_together(found), *_early(found)]
    return paragraphs(first, second, _threshold(found), "\n".join(said), _NOTES)


def _mean(one: Mapping[str, Any]) -> str:
    low, high = one["mean_avalanche_interval"]
    if one["mean_avalanche"] is None:
        return f"above {low:.0f}"
    return f"{one['mean_avalanche']:.1f} [{low:.1f}, {high:.1f}]"


def _p(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}"


def _interval(value: float | None, ends: Any, digits: str) -> str:
    """A number with its interval; an end that is open is "-"."""
    if value is None:
        return "-"
    low, high = ("-" if end is None else f"{end:{digits}}" for end in ends)
    return f"{value:{digits}} [{low}, {high}]"


def _form(form: Mapping[str, Any] | None) -> list[str]:
    if form is None:
        return ["-", "-"]
    words = _interval(form["beta"], (form["low"], form["high"]), ".2f")
    beyond = f" beyond {form['start']}" if form["start"] else ""
    return [f"{words}{beyond}", f"{form['p_value']:.2f}"]


def _correlation(found: Mapping[str, Any] | None) -> str:
    return "-" if found is None else _interval(found["value"], (found["low"], found["high"]), ".2f")


def _arch(one: Mapping[str, Any]) -> list[str]:
    if one["arch_particles_mean"] is None:
        return ["-", "-"]
    most = len(one["arch_particles"]) - 1
    return [f"{one['arch_particles_mean']:.1f}, {most}", f"{1e3 * one['arch_span_m']:.0f} mm"]


def _tail(found: Mapping[str, Any] | None) -> str:
    if found is None:
        return "-"
    words = _interval(found["alpha"], (found["low"], found["high"]), ".2f")
    return f"{words} from {1e3 * found['start']:.0f} ms"


def _laws(found: Mapping[str, Any]) -> list[str]:
    lines = []
    for name, law in found["laws"].items():
        parts = ", ".join(filter(None, map(_parameter, law["parameters"].items())))
        fit = "" if law["p_value"] is None else f", p {law['p_value']:.2f} of the scatter about it"
        lines.append(f"{name}: <s> = {_FORMS[name]}; {parts}; AIC {law['aic']:.1f}{fit}")
    if len(found["laws"]) == 2:
        gain = found["laws"]["power"]["aic"] - found["laws"]["exponential"]["aic"]
        better = "exponential" if gain > 0 else "power"
        how = "hardly" if abs(gain) < 2 else "clearly" if abs(gain) > 10 else "somewhat"
        lines.append(f"the {better} law is {how} the better one: AIC less by {abs(gain):.1f}")
    return lines


def _parameter(named: tuple[str, Mapping[str, Any]]) -> str:
    """A parameter with its interval; a bound where that is open above, nothing without one."""
    name, one = named
    if one["low"] is None and one["high"] is None:
        return ""
    if one["high"] is None:
        return f"{_NAMES[name]} above {one['low']:.3g}"
    return f"{_NAMES[name]} {_interval(one['value'], (one['low'], one['high']), '.3g')}"


def _threshold(found: Mapping[str, Any]) -> str:
    """Return a table of outlets by the share of silos that clog there, by each law."""
    names, cells = list(found["laws"]), dict[float, dict[str, str]]()
    for one in found["outlets_by_probability"]:
        ends = [None if end is None else 1e3 * end for end in one["interval_m"]]
        beyond = ", extrapolated" if one["extrapolated"] else ""
        cells.setdefault(one["probability"], {})[one["law"]] = (
            f"{_interval(1e3 * one['outlet_m'], ends, '.1f')} mm, "
            f"D/d {one['outlet_over_diameter']:.2f}{beyond}"
        )
    if not cells:
        return ""
    return columns(
        [f"of the silos of {found['n_particles']}", *(f"clog at ({name} law)" for name in names)],
        [
            [f"{100 * probability:g} %", *(own.get(name, "-") for name in names)]
            for probability, own in cells.items()
        ],
    )


def _together(found: Mapping[str, Any]) -> list[str]:
    """Lines on laws that the outlets refute, and on successive sizes."""
    lines = [
        f"the outlets refute the {law.name} law: it gives none beyond them"
        for law in laws_of(found)
        if law.refuted
    ]
    if (r := found["independence"]) is not None:
        of = "independent" if r["low"] <= 0 <= r["high"] else "not independent"
        lines.append(f"successive avalanches of all outlets are {of}: r = {_correlation(r)}")
    return lines


def _early(found: Mapping[str, Any]) -> list[str]:
    """Outlets at which nothing clogged, or runs ended before their avalanches were all there."""
    flows = [
        f"nothing clogged at {1e3 * one['outlet_m']:g} mm: the bound is of {one['unclogged']:,} "
        "particles, without those up to the first cut"
        for one in found["outlets"]
        if one["unclogged"]
    ]
    return flows + [
        f"{number} of the runs at {1e3 * one['outlet_m']:g} mm ended {_ENDS[outcome]}"
        for one in found["outlets"]
        for outcome, number in one["ended_early"].items()
    ]
