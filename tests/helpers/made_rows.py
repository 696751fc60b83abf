"""Rows of a sweep as they come from run_cases, made up: their numbers are chosen by the test."""

from typing import Any

RESTITUTION = {
    "restitution.particle_particle.one_contact": 0.8,
    "restitution.particle_particle.face_to_face": 0.53,
}


def ended(outcome: str, time: float | None = None, **labels: Any) -> dict[str, Any]:
    """A run that came to an end."""
    results = {"outcome": outcome, "discharge_time_s": time, "t90_s": time and 0.9 * time}
    digest = "-".join(map(str, labels.values()))
    kept = {"state_digest": digest, "run_folder": "/somewhere", "reused": False}
    return {**labels, **results, **RESTITUTION, **kept, "state": "done", "reason": ""}


def failed(reason: str, **labels: Any) -> dict[str, Any]:
    """A run that did not."""
    return {**labels, "state": "failed", "reason": reason}


def emptied(silo: str, times: list[float], first_seed: int = 1) -> list[dict[str, Any]]:
    """Runs of a silo that emptied in these times [s]."""
    return [ended("empty", t, silo=silo, seed=k) for k, t in enumerate(times, first_seed)]


def clogged(
    silo: str, n: int, first_seed: int = 1, at_opening: bool = False
) -> list[dict[str, Any]]:
    """Runs of a silo that clogged."""
    outcome = "clogged_at_opening" if at_opening else "clogged"
    return [ended(outcome, silo=silo, seed=first_seed + k) for k in range(n)]


def line_of(text: str, start: str) -> str:
    """What the tables of a report say in their lines that begin so, one after the other."""
    lines = [line for line in text.splitlines() if line.split()[:1] == [start]]
    assert lines, text
    return "  ".join(lines)
