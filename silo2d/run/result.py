"""The result of a run as it stands in summary.json."""

from dataclasses import dataclass, field
from typing import Any, Literal

from granulab.campaign.runs.result import Results


@dataclass(frozen=True)
class Result(Results):
    """Result of a run; SI, None for what does not exist."""

    silo: str
    seed: int
    engine: str
    outcome: Literal["empty", "dead_zones", "clogged", "clogged_at_opening", "time_limit"]
    n_particles: int  # in the silo at the opening
    n_out: int
    mass_kg: float  # in the silo at the opening
    mass_out_kg: float
    # In store at the opening; of runs of earlier versions the numbers above have it.
    n_store: int = field(default=0, kw_only=True)
    mass_store_kg: float = field(default=0.0, kw_only=True)
    n_refilled: int | None = field(default=None, kw_only=True)  # of the store, put on top so far
    # Whether it clogged, and when the last particle left before (0: none did); None in runs of
    # earlier versions.
    clogged: bool | None = field(default=None, kw_only=True)
    clogged_after_s: float | None = field(default=None, kw_only=True)
    discharge_time_s: float | None  # None if clogged, or cut off by the time limit
    t90_s: float | None
    mean_rate_per_s: float | None  # of those that left, also where the flow was cut off
    mean_mass_flow_kg_per_s: float | None
    packing_fraction: float | None  # None for beds of a few layers
    coordination: float
    time_step_s: float
    steps: int
    simulated_s: float
    cpu_us_per_step: float  # of the discharge
    cpu_s: float  # of filling, settling and discharge
    energy_closure: float | None  # unaccounted over dissipated, of the discharge; None: not known
    dissipated_j: dict[str, float | None]  # by mechanism and pair; None: not known of this engine
    # Attractive normal forces, a hundred times a second: share of the contacts, and the strongest
    # over a mean particle's weight; None of impulses, and in runs of earlier versions.
    pulling: dict[str, float] | None = field(default=None, kw_only=True)
    restitution: dict[str, dict[str, float]]
    published: dict[str, Any]
    state_digest: str
    reused: bool
    run_folder: str
    time_step_halvings: int = 0  # of the chosen one, see silo2d/run/ending.py
