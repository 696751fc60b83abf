"""All measures of a run's motion that its phase is named from: one flat dict, without dimension."""

from damper3d.measures.phases.bed_flow import flow_measures
from damper3d.measures.phases.bed_motion import bed_measures
from damper3d.measures.phases.motion import Motion
from damper3d.measures.phases.particle_motion import particle_measures

# Meaning of each measure, for tables and help; defined in bed_motion, particle_motion, bed_flow.
MEANING = {
    "low_impulse": "impulse of the lower end on the bed in a cycle, over 2 M V",
    "high_impulse": "likewise of the upper end",
    "low_burst": "share of it within 15 % of the cycle",
    "high_burst": "likewise of the upper end",
    "low_phase_deg": "phase of the cycle at the middle of the impulse of the lower end",
    "high_phase_deg": "likewise of the upper end",
    "contrast": "|b - a|/(b + a) of the lower end's impulses in cycles that follow each other",
    "stroke": "travel of the bed's mass in a cycle, over the clearance",
    "coherence": "share of the kinetic energy in the mean motion",
    "slip_energy": "kinetic energy relative to the enclosure, over that of moving with it",
    "carried_share": "share of particles that move with the enclosure",
    "deep_carried_share": "likewise of the fifth that lies deepest along gravity",
    "agitated_share": "share of particles that move against their neighbours",
    "fluidised_share": "share of particles that do so and return within a cycle",
    "convecting_share": "share of particles that do so and do not return",
    "agitation": "normalised kinetic energy of moving against neighbours, median",
    "travelling_share": "share of particles that do not return within a cycle",
    "travel": "displacement of a cycle over the farthest within it, median",
    "packed_share": "share of particles in contact, in the frame of each cycle with most of them",
    "neighbours_kept": "share of neighbours that are neighbours a cycle later",
    "cycle_displacement": "root mean square displacement of a cycle, in diameters",
    "flight_share": "share of the time in which a particle touches nothing",
    "free_path": "path from one touch to the next, in diameters",
    "hot_low": "energy of the lowest fifth of the particles over the middle fifth's",
    "hot_high": "likewise of the highest fifth",
    "low_density": "solid volume of the lowest diameter of height over that of the fullest one",
    "across_share": "share of the energy about the mean motion across it; 2/3: all alike",
    "bed_height": "mean height of the bed's mass over the length of the enclosure",
    "floor_gap_least": "gap between bed and lower end, least in the cycles, over the clearance",
    "floor_gap_largest": "likewise the largest",
    "ring_share": "share of the transport in a ring-shaped roll",
    "roll_share": "share of the transport in one roll across",
    "circulation": "the larger of the two",
}


def measure_motion(motion: Motion) -> dict[str, float | None]:
    """The measures of a run's counted cycles, by the names in MEANING."""
    return {**bed_measures(motion), **particle_measures(motion), **flow_measures(motion)}
