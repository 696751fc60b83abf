"""Results of a run, as summary.json keeps them and --json prints them."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from damper3d.case.case import DamperCase
from damper3d.case.host.host import COUNTED, FORGOTTEN, cycles_until
from damper3d.measures import efficiency, excitation, host, response
from damper3d.measures.counted import Cycles, harmonics
from damper3d.run.steady import (
    BLOCK,
    ENOUGH_BLOCKS,
    block_interval,
    interval,
    is_steady,
    judged,
    keeps_amplitude,
    verdict,
)
from granulab.campaign.runs.result import Results
from granulab.campaign.runs.trajectory import Trajectory


@dataclass(frozen=True)
class Result(Results):
    """Results of a run over the counted cycles; SI, None for what does not exist."""

    frequency_hz: float
    gamma: float
    orientation: str
    particles: str
    n_particles: int
    fill_ratio: float
    particle_mass_kg: float  # of one, or the mean
    mass_kg: float  # of all
    # of unlike particles: name, material, count, mass, sub-spheres and diameters of each kind
    kinds: list[dict[str, Any]] | None = field(default=None, kw_only=True)
    seed: int
    packing: dict[str, float]  # at rest: fraction, height_m, coordination, rms_speed_m_s
    cycles: int
    discarded: int
    # from the energy budget (thesis, eqs 6.8-6.10); None where much of it is the bed's settling
    efficiency: float | None
    efficiency_note: str | None = field(default=None, kw_only=True)  # why there is none
    # the same, whatever is the bed's own; None in runs of earlier versions
    efficiency_with_settling: float | None = field(default=None, kw_only=True)
    efficiency_interval: tuple[float, float] | None  # [low, high], of that with settling
    efficiency_contact_count: float  # the thesis's count: mu Fn times the whole sliding velocity
    efficiency_wall_work: float
    efficiency_per_cycle: list[float]  # of all cycles, those that do not count too
    shares: dict[str, dict[str, float | None]]  # of what is dissipated, by pair and mechanism
    # likewise, of the thesis's count; None in runs of earlier versions
    shares_contact_count: dict[str, dict[str, float | None]] | None = field(
        default=None, kw_only=True
    )
    law_term: float | None  # work of the changing stiffness over what is dissipated
    dissipated_power_w: float
    loss_factor: float | None
    equivalent_damping_n_s_per_m: float | None
    effective_mass: dict[str, float | None]  # in_phase_kg, out_of_phase_kg
    peak_wall_force_n: float
    bed_height_m: float | None
    energy_closure: float | None
    # Attractive normal forces at the ends of the cycles: their share of the contacts, and the
    # strongest over a particle's weight; None in runs of earlier versions.
    pulling: dict[str, float] | None = field(default=None, kw_only=True)
    max_impact_over_yield_velocity: dict[str, float | None]
    # Part of the impacts that are faster than it; None in runs of earlier versions.
    impacts_beyond_yield: dict[str, float | None] | None = field(default=None, kw_only=True)
    # (c/v)^(1/5) of the fastest impact (eqs 5.11, 5.12), which should be much greater than 1; None
    # without an impact, or in runs of earlier versions.
    hertz_validity: dict[str, float | None] | None = field(default=None, kw_only=True)
    # Response of the host that the enclosure rides on (measures/host.py); None without one.
    host: dict[str, Any] | None = field(default=None, kw_only=True)
    # Of several dampers on it, a row for each (run/several.py); None of a single one.
    dampers: list[dict[str, Any]] | None = field(default=None, kw_only=True)
    # What moved it, where that is no single sine (measures/excitation.py); None of a sine.
    excitation: dict[str, Any] | None = field(default=None, kw_only=True)
    phase: str | None  # of the particles' motion; None where too few frames were kept
    phase_next: (
        list[dict[str, str | float | None]] | None
    )  # phases across one threshold, nearest first
    phase_measures: dict[str, float | None] | None  # what the phase is named from
    steady: bool | None  # None of a few cycles against which nothing speaks, and of decays
    # What the counted cycles do, where that is not steady, and the cure; None also in earlier runs.
    steady_note: str | None = field(default=None, kw_only=True)
    time_step_s: float
    steps: int
    cpu_us_per_step: float  # of the vibration
    cpu_s: float  # of filling, settling and vibration
    state_digest: str
    reused: bool
    run_folder: str


_UNDAMPED = (
    "the host has no damping, so that its start dies away by the bed alone: the amplitude of ten "
    "cycles is that of the ten before, and may be of a beat; give a damping ratio"
)


def summarise(case: DamperCase, samples: Trajectory) -> dict[str, Any]:
    """Results from the samples of a run, by the names of Result; SI, None where none exists."""
    run, per_cycle = case.settings.run, case.settings.output.samples
    n_cycles = (len(samples["time"]) - 1) // per_cycle
    first = first_counted(case, n_cycles)
    cycles = Cycles(case, samples, first)
    measured, counted = efficiency.numbers(cycles), cycles.counted
    whole = np.array(measured["efficiency_per_cycle"])
    references = cycles.references[first:]
    eta = efficiency.efficiencies(counted, per_cycle, references)["efficiency"]
    strength = float(np.linalg.norm(case.gravity))
    up = -case.gravity / strength if strength else case.direction
    return {
        "frequency_hz": case.settings.motion.frequency,
        "gamma": cycles.gamma,
        "orientation": case.orientation,
        "particles": case.particle.name,
        "n_particles": case.count,
        "fill_ratio": case.fill_ratio,
        "particle_mass_kg": case.particle_mass,
        "mass_kg": case.mass,
        "kinds": None if case.bed is None else case.bed.described(),
        "seed": run.seed,
        "cycles": n_cycles,
        "discarded": first,
        **measured,
        "efficiency_interval": _interval(eta, run.steady),
        **response.numbers(cycles),
        "bed_height_m": response.bed_height(counted, up, case.enclosure.lowest(up)),
        "max_impact_over_yield_velocity": efficiency.impact_ratios(counted, case.yield_velocity),
        "impacts_beyond_yield": efficiency.impacts_beyond_yield(counted, case.yield_velocity),
        "hertz_validity": efficiency.hertz_validities(counted, case.wave_speed),
        "host": host.numbers(cycles) if case.modes is not None else None,
        "excitation": excitation.numbers(cycles) if case.excitation is not None else None,
        **_steadiness(cycles, whole, measured["efficiency_note"]),
        "time_step_s": case.time_step,
    }


def first_counted(case: DamperCase, n_cycles: int) -> int:
    """Number of cycles that do not count: the start-up; in a steady run all that was not judged."""
    run = case.settings.run
    if not run.steady:
        return run.discard
    if case.modes is not None:
        return max(n_cycles - COUNTED, 0)
    return n_cycles - min(judged(n_cycles - run.discard), n_cycles - run.discard)


def _steadiness(cycles: Cycles, eta: np.ndarray, note: str | None) -> dict[str, Any]:
    """Judge whether the counted cycles are steady, with a line where not; eta of all cycles.

    Of a run that went on until then: efficiency, or on a host the amplitude. Of another one on a
    host that is forced, whether its start may still count; of one that is let go, and of windows of
    a signal, nothing is said. note: why the run has no efficiency, which is not said twice.
    """
    case, run = cycles.case, cycles.case.settings.run
    if run.steady:
        sizes = np.abs(harmonics(cycles.samples["displacement"], cycles.per_cycle))
        done = is_steady(eta[run.discard :]) if case.modes is None else keeps_amplitude(sizes)
        early = too_early(case, len(eta))
        if done and early is not None:
            return {"steady": None, "steady_note": early}
        late = f"not steady after {len(eta)} cycles: give more --max-cycles"
        return {"steady": done, "steady_note": None if done else late}
    if case.modes is not None or case.excitation is not None:
        return {"steady": None, "steady_note": _left_out(case, cycles.first)}
    if note is not None:
        return {"steady": False, "steady_note": None}
    return dict(zip(("steady", "steady_note"), verdict(eta[cycles.first :]), strict=True))


def too_early(case: DamperCase, n_cycles: int) -> str | None:
    """Reason why an amplitude that ten cycles do not change may change yet; None without a host.

    The start of a host of damping ratio zeta changes it by 1 - exp(-20 pi zeta) of what is left.
    """
    if case.modes is None:
        return None
    takes = cycles_until(FORGOTTEN, case.modes.slowest, case.settings.motion.frequency)
    if takes is None:
        return _UNDAMPED
    if n_cycles >= takes + COUNTED:
        return None
    return (
        f"{n_cycles} cycles, and the bare host's start takes {takes} to fall to 1 %, before the "
        f"{COUNTED} that are judged: give --max-cycles {takes + COUNTED} or more, and no --discard"
    )


def _left_out(case: DamperCase, first: int) -> str | None:
    """Reason why cycles that count from the first on may hold a start; None of no forced host."""
    if case.modes is None or case.excitation is not None or case.is_decay:
        return None
    takes = cycles_until(FORGOTTEN, case.modes.slowest, case.settings.motion.frequency)
    if takes is None:
        return _UNDAMPED
    if first >= takes:
        return None
    return (
        f"{first} cycles are left out, and the bare host's start takes {takes} to fall to 1 %: the "
        f"amplitude may grow or fall yet; give no cycles, or --discard {takes} and more cycles"
    )


def _interval(eta: np.ndarray, steady: bool) -> tuple[float, float] | None:
    blocks = len(eta) >= BLOCK * (2 if steady else ENOUGH_BLOCKS)
    return block_interval(eta) if blocks else interval(eta)
