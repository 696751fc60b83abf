"""The answers of a slow test, as summary.json keeps them and --json prints them."""

from dataclasses import dataclass

from granulab.campaign.runs.result import Answers


@dataclass(frozen=True)
class Result(Answers):
    """What a test found; SI, None for what does not exist. See measure.py."""

    test: str
    particles: str
    n_particles: int
    seed: int
    preload_n: float
    preload_mean_n: float | None  # on the table during the test; None where it is not held
    preload_rms_deviation_n: float | None
    preload_displacement_m: float  # of the table, from the top of the bed to where it rests
    bed_height_m: float  # under the pre-load
    packing_fraction: float
    speed_m_per_s: float
    distance_m: float
    inertial_number: float
    at_m: float
    stiffness_n_per_m: float  # secant to at_m
    force_start_n: float
    force_end_n: float
    force_mean_n: float  # above that at the start, mean over the distance
    displacement_m: list[float]
    force_n: list[float]
    force_imbalance: float
    energy_closure: float | None
    law_term: float | None
    max_impact_over_yield_velocity: dict[str, float | None]
    time_step_s: float
    steps: int
    cpu_us_per_step: float
    cpu_s: float
    state_digest: str
    reused: bool
    run_folder: str
