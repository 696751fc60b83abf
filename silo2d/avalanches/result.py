"""The result of a run of avalanches as it stands in summary.json."""

from dataclasses import dataclass
from typing import Literal

from granulab.campaign.runs.result import Results


@dataclass(frozen=True)
class Avalanches(Results):
    """Avalanches of one outlet and seed; SI, None for what does not exist.

    sizes          particles that left in each, the first, from the opening, not among them
    cut            1 for those that ended without a clog: larger than that (censored); else 0
    durations_s    from the breaking of an arch to the last particle that left
    first_size     particles that left from the opening to the first clog or cut
    arch_...       of the clogs that ended those avalanches: particles, distance of the feet [m],
                   rise over span; of clogs whose arch was found
    waits          numbers of times between successive particles of an avalanche, by bins of WAITS
    """

    silo: str
    seed: int
    outlet_m: float
    diameter_m: float  # of the disc of the particles' mean area
    avalanches: int
    largest: int
    breaking: Literal["remove", "shake"]
    drop: float
    outcome: Literal["whole", "dead_zones", "rathole", "stuck", "time_limit"]
    n_particles: int
    sizes: list[int]
    cut: list[int]
    durations_s: list[float]
    first_size: int
    first_clogged: bool
    arch_particles: list[int]
    arch_span_m: list[float]
    arch_aspect: list[float]
    arches_not_found: int
    breaks: int  # of arches; more than avalanches where nothing left after one
    refilled: int  # particles that were put back on top, those of arches among them
    waits: list[int]
    time_step_s: float
    time_step_halvings: int
    steps: int
    simulated_s: float
    cpu_s: float
    state_digest: str
    reused: bool
    run_folder: str


_OUTCOMES = {
    "whole": "",
    "dead_zones": ", then nothing over the outlet",
    "rathole": ", then a flow through a channel around which the bed stands",
    "stuck": ", then no break let anything out",
    "time_limit": ", then nothing came out and nothing lay still",
}


def in_words(found: Avalanches) -> str:
    """The result in a few lines."""
    sizes, cut = found.sizes, sum(found.cut)
    clogs = len(sizes) - cut
    mean = f"mean {sum(sizes) / clogs:.1f} particles" if clogs else "no clog"
    first = "clogged" if found.first_clogged else "cut off"
    return (
        f"{len(sizes)} avalanches, {cut} of them cut off{_OUTCOMES[found.outcome]}; {mean}\n"
        f"  from the opening {found.first_size} particles, then {first}\n"
        f"  {found.breaks} breaks ({found.breaking}), {found.refilled} particles put back"
    )
