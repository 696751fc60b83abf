"""Energy balance of a run: damping efficiency, shares of the mechanisms, closure.

Functions of samples as records.cut gives them, from the end of one cycle to the end of another.
The thesis (eqs 6.4-6.9) adds the power of all dissipative force components. Its law has no
potential, so that this count is some per cent more than the energy that is lost; here the lost
energy is read from the budget,

    lost = wall work - change of (kinetic + potential + elastic)
         = sum of (normal damping + tangential damping + friction) - work of the changing stiffness,

and the thesis's count is kept too. Eq. 6.9 is printed with the wrong sign (errata).
"""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from damper3d.engine.records import CLASSES, HELD, IMPACTS, MECHANISMS, Samples, per_cycle_change
from damper3d.measures.counted import Cycles, read_cycles
from granulab.campaign.output.figure import BLUE, GREY, headline
from granulab.contact.sphere_law import hertz_validity

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_OF_A_DECAY = "a free decay has no one amplitude: efficiency_per_cycle goes by each cycle's own"
_OF_A_ROTATION = "a rotation has no efficiency: the other counts go by the rim's velocity"
OWN = 0.1  # of what is lost, that may be the bed's own energy in an efficiency


def reference_energy(peak_speed: float, mass: float) -> float:
    """The most that a cycle can dissipate, 4 V^2 M [J] (eq. 6.10).

    peak_speed    V = Gamma g/omega of the enclosure [m/s]
    mass          M of all particles [kg]

    All particles, as one mass, meet both ends with twice the enclosure's speed and stay there.
    """
    return 4.0 * peak_speed**2 * mass


def held(samples: Samples) -> np.ndarray:
    """Energy that the bed holds (n,) [J]."""
    return np.sum([samples[name] for name in HELD], axis=0)


def lost(samples: Samples) -> np.ndarray:
    """Energy lost since the first row (n,) [J], from the budget."""
    gone = samples["wall_work"] - held(samples)
    return gone - gone[0]


def dissipated(samples: Samples) -> np.ndarray:
    """Energy that the mechanisms dissipated since the first row (n,) [J]."""
    return _since(samples, MECHANISMS)


def contact_count(samples: Samples) -> np.ndarray:
    """Energy since the first row as the thesis counts it (n,) [J], eq. 6.7.

    Friction is the whole force mu Fn times the sliding velocity, whatever the spring gives back.
    """
    return _since(samples, ("normal_damping", "tangential_damping", "slip_count"))


def stiffness_work(samples: Samples) -> np.ndarray:
    """Work of the changing tangential stiffness since the first row (n,) [J]."""
    return _since(samples, ("law_term",))


def _since(samples: Samples, names: tuple[str, ...]) -> np.ndarray:
    total = summed(samples, names)
    return total - total[0]


def summed(samples: Samples, names: tuple[str, ...]) -> np.ndarray:
    """Columns added up over names and classes (n,)."""
    return np.sum([samples[f"{name}_{pair}"] for pair in CLASSES for name in names], axis=0)


def efficiencies(
    samples: Samples, per_cycle: int, reference: float | np.ndarray
) -> dict[str, np.ndarray]:
    """The damping efficiency of each cycle (n_cycles,) [-], eq. 6.8; reference from eq. 6.10 [J].

    reference    of all cycles, or of each (n_cycles,)

    efficiency       from the budget
    contact_count    as the thesis counts
    wall_work        of the enclosure on the bed: the same in the long run
    """
    series = {
        "efficiency": lost(samples),
        "contact_count": contact_count(samples),
        "wall_work": samples["wall_work"],
    }
    return {name: per_cycle_change(s, per_cycle) / reference for name, s in series.items()}


def settling(efficiency: float, wall_work: float) -> str | None:
    """Reason why a run has no efficiency: much of it is the bed's own energy; None for little.

    In the long run all that is lost is the enclosure's work. Over the counted cycles the bed gives
    what it falls, slows down and springs back, or takes it: up to OWN of what counts is let pass.
    """
    own = efficiency - wall_work
    if not abs(own) > OWN * abs(efficiency):
        return None
    whence = "the bed gives itself as it settles" if own > 0 else "the bed takes up and keeps"
    return (
        f"{abs(own):.3g} of {efficiency:.3g} is energy that {whence}, and not the shaker's work, "
        f"{wall_work:.3g}: go on until it is steady (--steady, or more --cycles)"
    )


def shares(samples: Samples) -> dict[str, dict[str, float | None]]:
    """Part of each class and mechanism in what they all dissipated (eqs 2.2, 6.14).

    None where nothing is dissipated.
    """
    return _shares(samples, {name: name for name in MECHANISMS})


def shares_contact_count(samples: Samples) -> dict[str, dict[str, float | None]]:
    """The same of what the thesis counts (see contact_count), which is more friction.

    None where nothing is counted.
    """
    return _shares(samples, {name: name for name in MECHANISMS} | {"friction": "slip_count"})


def _shares(samples: Samples, columns: Mapping[str, str]) -> dict[str, dict[str, float | None]]:
    """Part of each class and mechanism in the sum of all, from the column of each mechanism."""
    whole = float(_since(samples, tuple(columns.values()))[-1])

    def share(column: np.ndarray) -> float | None:
        return float(column[-1] - column[0]) / whole if whole > 0 else None

    return {
        pair: {name: share(samples[f"{column}_{pair}"]) for name, column in columns.items()}
        for pair in CLASSES
    }


def closure(samples: Samples) -> tuple[float | None, float | None]:
    """Unaccounted energy, and the work of the changing stiffness, over the energy dissipated.

    Unaccounted is what is lost and neither dissipated nor that work. None where nothing
    is dissipated.
    """
    whole, gain = float(dissipated(samples)[-1]), float(stiffness_work(samples)[-1])
    if whole <= 0:
        return None, None
    return (float(lost(samples)[-1]) + gain - whole) / whole, gain / whole


def impact_ratios(
    samples: Samples, yield_velocity: Mapping[str, float | None]
) -> dict[str, float | None]:
    """Largest impact speed of each class over its yield velocity [-] (eq. 5.26).

    The law holds while this is near or below 1. None where the yield velocity is not known.
    """
    fastest = _fastest(samples)
    limits = {pair: yield_velocity[pair] for pair in CLASSES}
    return {
        pair: None if limit is None else fastest[pair] / limit for pair, limit in limits.items()
    }


def hertz_validities(samples: Samples, wave_speed: Mapping[str, float]) -> dict[str, float | None]:
    """(c/v)^(1/5) of the fastest impact of each class [-] (eqs 5.11, 5.12); None without one."""
    return {
        pair: hertz_validity(wave_speed[pair], fastest) if fastest > 0.0 else None
        for pair, fastest in _fastest(samples).items()
    }


def _fastest(samples: Samples) -> dict[str, float]:
    """The largest impact speed of each class after the first row [m/s]."""
    return {pair: float(samples[f"impact_speed_{pair}"][1:].max()) for pair in CLASSES}


def impacts_beyond_yield(
    samples: Samples, yield_velocity: Mapping[str, float | None]
) -> dict[str, float | None] | None:
    """Part of the impacts of each class that are faster than its yield velocity [-] (eq. 5.26).

    None of a class where that is not known, or without an impact; of samples of earlier versions,
    which did not count them, None at all.
    """
    if IMPACTS[CLASSES[0]][0] not in samples:
        return None
    found: dict[str, float | None] = {}
    for pair in CLASSES:
        begun, beyond = (float(samples[name][1:].sum()) for name in IMPACTS[pair])
        found[pair] = beyond / begun if begun and yield_velocity[pair] is not None else None
    return found


def numbers(cycles: Cycles) -> dict[str, Any]:
    """Efficiencies, shares and energy balance, by the names of a run's Result."""
    counted, references = cycles.counted, cycles.references
    eta = efficiencies(counted, cycles.per_cycle, references[cycles.first :])
    whole = efficiencies(cycles.samples, cycles.per_cycle, references)["efficiency"]
    unaccounted, law_term = closure(counted)
    whole_mean, wall_mean = (float(eta[name].mean()) for name in ("efficiency", "wall_work"))
    note = _OF_A_DECAY if cycles.case.is_decay else settling(whole_mean, wall_mean)
    own = cycles.case.excitation
    if cycles.case.arc is not None or (own is not None and own.kind == "rotation"):
        note = _OF_A_ROTATION
    return {
        "efficiency": None if note else whole_mean,
        "efficiency_note": note,
        "efficiency_with_settling": whole_mean,
        "efficiency_contact_count": float(eta["contact_count"].mean()),
        "efficiency_wall_work": wall_mean,
        "efficiency_per_cycle": whole.tolist(),
        "shares": shares(counted),
        "shares_contact_count": shares_contact_count(counted),
        "law_term": law_term,
        "energy_closure": unaccounted,
    }


def in_words(found: Mapping[str, Any]) -> str:
    """The efficiency of a run, or that it has none; `found`: its results, by their names."""
    if found["efficiency"] is not None:
        return f"efficiency {found['efficiency']:.3f}"
    known = {_OF_A_DECAY: "a free decay", _OF_A_ROTATION: "a rotation"}
    why = known.get(found["efficiency_note"], "the bed settles")
    return f"no efficiency, {why} (wall work {found['efficiency_wall_work']:.3f})"


def measure(folder: Path) -> dict[str, Any]:
    """Efficiencies, shares and energy balance of a run; FolderError as read_cycles."""
    return numbers(read_cycles(folder))


def draw(folder: Path) -> "Figure":
    """Efficiency of each cycle, and the shares of the mechanisms."""
    from matplotlib.figure import Figure

    cycles = read_cycles(folder)
    found = numbers(cycles)
    figure = Figure(figsize=(9.6, 4.0), layout="constrained")
    headline(figure, f"{cycles.case.name}: {in_words(found)}")
    each, parts = figure.subplots(1, 2)
    eta = np.array(found["efficiency_per_cycle"])
    number = 1 + np.arange(len(eta))
    each.plot(number, eta, "o-", color=GREY, mfc="white", lw=0.8, label="discarded")
    each.plot(number[cycles.first :], eta[cycles.first :], "o", color=BLUE, label="counted")
    each.set(xlabel="cycle", ylabel="efficiency [-]", ylim=(min(0.0, float(eta.min())), None))
    each.legend()
    named = {
        f"{name.replace('_', ' ')},\n{pair.replace('_', '-')}": share or 0.0
        for pair, of_pair in found["shares"].items()
        for name, share in of_pair.items()
    }
    parts.barh(list(named), [100.0 * share for share in named.values()], color=BLUE)
    parts.invert_yaxis()
    parts.set_xlabel("share of the dissipated energy [%]")
    return figure
