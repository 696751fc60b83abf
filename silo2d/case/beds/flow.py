"""Limits of what acts after the opening: plates, gate, feeder, refilling, vibration."""

import math

from granulab.errors import InputError
from silo2d.case.filling import GRAVITY
from silo2d.case.settings import Settings
from silo2d.case.shape import ShapeSet

_FEWEST_STEPS = 20  # of a period of vibration
_STRONGEST = 50.0  # acceleration of vibrating walls, in g: beyond it particles are shot


def check_flow(settings: Settings, shapes: ShapeSet, time_step: float, where: str) -> None:
    """Raise InputError for keys that lack another, contradict each other, or are out of range."""
    law, flow, run = settings.law, settings.flow, settings.run
    if (law.mu_plates is None) != (law.plates_ratio is None):
        there, lacks = ("mu_plates", "plates_ratio = 0.4")
        if law.mu_plates is None:
            there, lacks = ("plates_ratio", "mu_plates = 0.44")
        raise InputError(f"{where}: [law] {there}: goes with the other; give {lacks} too")
    if (flow.vibration_amplitude is None) != (flow.vibration_frequency is None):
        lacks = "frequency = '30 Hz'" if flow.vibration_amplitude else "amplitude = '0.5 mm'"
        raise InputError(f"{where}: [flow] vibration: give vibration_{lacks} too")
    door = run.door_speed is not None
    closed = flow.feed_rate is not None
    for first, is_first, second, is_second in (
        ("feed_rate", closed, "[flow] gate_times", flow.gate_times is not None),
        ("feed_rate", closed, "[silo] outlets", bool(settings.silo.outlets)),
        ("feed_rate", closed, "[run] door_speed", door),
        ("gate_times", flow.gate_times is not None, "[run] door_speed", door),
        ("vibration_amplitude", flow.vibration_amplitude is not None, "[run] door_speed", door),
    ):
        if is_first and is_second:
            raise InputError(
                f"{where}: [flow] {first} does not go with {second}; leave one of them out"
            )
    if flow.feed_rate is not None and flow.feed_rate * run.rest_time < 2:
        raise InputError(
            f"{where}: [flow] feed_rate = {flow.feed_rate:g} 1/s: the silo would count as at rest "
            f"between two particles; more than {2 / run.rest_time:.3g} 1/s, or a longer rest_time"
        )
    if flow.feed_rate is not None and flow.feed_rate * time_step > 1:
        raise InputError(
            f"{where}: [flow] feed_rate = {flow.feed_rate:g} 1/s: more than a particle a time step "
            f"of {time_step:.3g} s; at most {1 / time_step:.3g} 1/s"
        )
    if flow.vibration_amplitude is not None and flow.vibration_frequency is not None:
        _check_vibration(flow.vibration_amplitude, flow.vibration_frequency, shapes, where)
        if flow.vibration_frequency * time_step * _FEWEST_STEPS > 1:
            most = 1 / (_FEWEST_STEPS * time_step)
            raise InputError(
                f"{where}: [flow] vibration_frequency = {flow.vibration_frequency:g} Hz: less than "
                f"{_FEWEST_STEPS} time steps a period; at most {most:.3g} Hz"
            )
    if run.engine == "pymunk":
        for key, given in (
            ("[law] mu_plates", law.mu_plates is not None),
            ("[flow] gate_times", flow.gate_times is not None),
            ("[flow] feed_rate", closed),
            ("[flow] refill", flow.refill > 0),
            ("[flow] vibration_amplitude", flow.vibration_amplitude is not None),
            ("[output] wall_interval", settings.output.wall_interval is not None),
        ):
            if given:
                raise InputError(f"{where}: {key} goes with engine = 'dem'; leave one of them out")


def _check_vibration(amplitude: float, frequency: float, shapes: ShapeSet, where: str) -> None:
    largest = min(shape.width for shape in shapes.shapes)
    if amplitude > largest:
        raise InputError(
            f"{where}: [flow] vibration_amplitude = {1e3 * amplitude:g} mm: more than the "
            f"narrowest particle, {1e3 * largest:.3g} mm"
        )
    acceleration = amplitude * (2 * math.pi * frequency) ** 2 / GRAVITY
    if acceleration > _STRONGEST:
        most = math.sqrt(_STRONGEST * GRAVITY / amplitude) / (2 * math.pi)
        raise InputError(
            f"{where}: [flow] vibration_frequency = {frequency:g} Hz: an acceleration of "
            f"{acceleration:.3g} g; at most {_STRONGEST:g} g, which is {most:.3g} Hz"
        )
