"""The answers of a run, as summary.json keeps them and --json prints them."""

from dataclasses import dataclass, field

from granulab.campaign.runs.result import Answers


@dataclass(frozen=True)
class Result(Answers):
    """What a run found, over the counted cycles; SI, None for what does not exist."""

    frequency_hz: float
    gamma: float
    orientation: str
    particles: str
    n_particles: int
    fill_ratio: float
    particle_mass_kg: float  # of one
    mass_kg: float  # of all
    seed: int
    packing: dict[str, float]  # at rest: fraction, height_m, coordination, rms_speed_m_s
    cycles: int
    discarded: int
    efficiency: float  # from the energy budget (thesis, eqs 6.8-6.10)
    efficiency_interval: tuple[float, float] | None  # [low, high]
    efficiency_contact_count: float  # the thesis's count: mu Fn times the whole sliding velocity
    efficiency_wall_work: float
    efficiency_per_cycle: list[float]  # of all cycles, those that do not count too
    shares: dict[str, dict[str, float | None]]  # of what is dissipated, by pair and mechanism
    # likewise, of the thesis's count; None in runs of earlier versions
    shares_contact_count: dict[str, dict[str, float | None]] | None = field(
        default=None, kw_only=True
    )
    law_term: float | None  # the tangential spring's own gain, over what is dissipated
    dissipated_power_w: float
    loss_factor: float | None
    equivalent_damping_n_s_per_m: float | None
    effective_mass: dict[str, float | None]  # in_phase_kg, out_of_phase_kg
    peak_wall_force_n: float
    bed_height_m: float | None
    energy_closure: float | None
    max_impact_over_yield_velocity: dict[str, float | None]
    phase: str | None  # of the particles' motion; None where too few frames were kept
    phase_next: (
        list[dict[str, str | float | None]] | None
    )  # phases across one threshold, nearest first
    phase_measures: dict[str, float | None] | None  # what the phase is named from
    steady: bool | None
    time_step_s: float
    steps: int
    cpu_us_per_step: float  # of the vibration
    cpu_s: float  # of filling, settling and vibration
    state_digest: str
    reused: bool
    run_folder: str
