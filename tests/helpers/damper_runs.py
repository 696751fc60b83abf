"""A damper of twenty spheres that fills and is shaken in a second, and such of other particles."""

from typing import Any

from damper3d.case.case import DamperCase

# Its bed is two spheres deep; 80 Hz and 6300 steps a cycle.
CASE: dict[str, Any] = {
    "enclosure.diameter": "20 mm",
    "enclosure.height": "20 mm",
    "particles.count": 20,
    "motion.frequency": 80,
    "motion.gamma": 10,
    "law.restitution": 0.5,  # at rest the sooner
    "fill.settle_time": "0.15 s",
    "run.cycles": 4,
    "run.discard": 1,
    "run.time_step": "2 us",
    "output.samples": 20,
    "output.frames": 4,
}
# Particles times steps of three samples: a checkpoint each, so some 27 in the four cycles.
OFTEN = 3 * 20 * 315 + 1
# Particles of several spheres in the same enclosure.
SPHEROIDS = CASE | {
    "particles.shape": "prolate:1.5",
    "particles.equal_volume_radius": "2.2 mm",
    "particles.count": 30,
    "fill.settle_time": "60 ms",
    "run.cycles": 3,
}
# Spheres and particles of several spheres together.
MIXTURE = {key: value for key, value in SPHEROIDS.items() if not key.startswith("particles.")} | {
    "particles.kind": [
        {"shape": "sphere:4mm", "count": 12},
        {"shape": "prolate:1.5", "equal_volume_radius": "2.2 mm", "sub_spheres": 15, "count": 14},
    ],
    "run.discard": 1,
}
# Options of the command for a like one.
OPTIONS = ["--diameter", "20 mm", "--height", "20 mm", "--count", 20, "--frequency", 80,
           "--gamma", 10, "--cycles", 4, "--discard", 1, "--time-step", "2 us"]  # fmt: skip


def small(**changes: Any) -> DamperCase:
    """The case of spheres, with changes such as motion__gamma=5."""
    return _case(CASE, changes)


def small_spheroids(**changes: Any) -> DamperCase:
    """The case of particles of several spheres, with changes such as motion__gamma=5."""
    return _case(SPHEROIDS, changes)


def small_mixture(**changes: Any) -> DamperCase:
    """The case of spheres and spheroids together, with changes such as motion__gamma=5."""
    return _case(MIXTURE, changes)


def _case(usual: dict[str, Any], changes: dict[str, Any]) -> DamperCase:
    named = {key.replace("__", "."): value for key, value in changes.items()}
    return DamperCase.load("thesis", usual | named)
