"""A damper of twenty spheres, and the command to run it."""

from pathlib import Path
from typing import Any

from small_silo import Completed, run_command, write_keys

from damper3d.commands.main import main

# Soft and large: a few hundred steps a cycle.
CASE: dict[str, Any] = {
    "enclosure.diameter": "20 mm",
    "enclosure.height": "25 mm",
    "particles.shape": "sphere:5mm",
    "particles.count": 20,
    "motion.frequency": 80.0,
    "motion.gamma": 10.0,
    "law.youngs_modulus": "0.1 GPa",
    "fill.settle_time": "20 ms",
    "run.cycles": 4,
    "run.discard": 2,
    "run.time_step": "5 us",
    "output.samples": 50,
    "output.frames": 10,
}
# Scripts rely on these names: to change one needs a reason in the changelog.
KEYS = {
    "frequency_hz", "gamma", "orientation", "particles", "n_particles", "fill_ratio",
    "particle_mass_kg", "cycles", "discarded", "efficiency", "efficiency_interval",
    "efficiency_contact_count", "efficiency_wall_work", "efficiency_per_cycle", "shares",
    "law_term", "dissipated_power_w", "loss_factor", "effective_mass", "peak_wall_force_n",
    "bed_height_m", "energy_closure", "max_impact_over_yield_velocity", "phase", "steady",
    "time_step_s", "steps", "cpu_us_per_step", "cpu_s", "state_digest", "reused", "run_folder",
    "seed",
}  # fmt: skip


def write_damper(folder: Path, changes: dict[str, Any] | None = None, name: str = "small") -> Path:
    """Write NAME.toml into a folder; a change to None takes a key out."""
    return write_keys(folder / f"{name}.toml", CASE | (changes or {}))


def damper3d(*arguments: object) -> Completed:
    """What the command gives back; see small_silo.run_command."""
    return run_command("damper3d", main, *arguments)
