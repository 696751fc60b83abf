"""From sample to sample: steps of all spheres of a slot, and lists where one has left its own."""

from typing import Any

import numpy as np

from damper3d.engine.batch.samples import forget, note_parts, write_column
from damper3d.engine.batch.slots import (
    DIRECTION,
    IN_USE,
    INTO,
    LEFT,
    MADE,
    OUTCOME,
    PER_SAMPLE,
    RAMP,
    SPHERES,
    STEP,
    TIME_STEP,
    WALLS,
    WANTED,
    WRITTEN,
    Slots,
    slot_of,
)
from damper3d.engine.batch.step import list_sphere, load_sphere, move_sphere, three
from damper3d.engine.motions import sines
from damper3d.engine.motions.sines import Sines
from damper3d.engine.state import DONE, N_BALANCE, N_COLUMNS
from granulab.contact.jit import njit
from granulab.contact.vectors import scale

_OVER = 32  # spheres over which the mean velocity of the bed is taken, about


@njit
def enclosure_of(one, time):
    """Displacement [m] and velocity [m/s] of an enclosure along its direction, at a time."""
    rows = one.sines
    motion = Sines(rows[0], rows[1], rows[2], one.numbers[RAMP])
    return sines.displacement(motion, time), sines.velocity(motion, time)


@njit
def mean_velocity(one, c):
    """Mean of a component of the velocity of some spheres, evenly chosen, for a list's drift."""
    n = one.clock[SPHERES]
    every = (n + _OVER - 1) // _OVER
    summed, counted = 0.0, 0.0
    for i in range(0, n, every):
        summed += one.velocity_now[i, c]
        counted += 1.0
    return summed / counted


@njit
def list_own(one, in_use, own, shift):
    """New lists of a thread's own spheres, the outcome of any that has no room, and the drift.

    shift: the enclosure's.
    """
    for i in range(own[0], own[1], own[2]):
        outcome = list_sphere(one, in_use, i, shift)
        if outcome != DONE:
            one.clock[OUTCOME] = outcome
    for c in range(own[0], 3, own[2]):
        one.drift[c] = mean_velocity(one, c)


def advancing(wait: Any) -> Any:
    """The loop of a thread of a slot, whose threads come together where they `wait`.

    advance(slots, s, thread, n_threads, most) takes most steps at most, and ends where all samples
    that are wanted are written, or where a list has no room or a state is beyond belief, which
    OUTCOME then says: nothing has been changed since the last step.
    """
    view = njit(slot_of)

    def advance(slots, s, thread, n_threads, most):
        one = view(slots, s)
        clock, numbers = one.clock, one.numbers
        dt = numbers[TIME_STEP]
        # Unsigned: numba then need not look for negative ones at each entry of an array.
        own = np.uintp(thread), np.uintp(clock[SPHERES]), np.uintp(n_threads)
        step, into, written = clock[STEP], clock[INTO], clock[WRITTEN]
        in_use, made = clock[IN_USE], clock[MADE]
        direction = three(numbers[DIRECTION : DIRECTION + 3])
        n_columns = N_COLUMNS + N_BALANCE + 3 * clock[WALLS]
        along, rate = enclosure_of(one, step * dt)
        wait()
        while True:
            shift, speed = scale(along, direction), scale(rate, direction)
            if clock[LEFT] == step:
                list_own(one, in_use, own, shift)
                wait()
                if clock[OUTCOME] != DONE:
                    break
                in_use, made = 1 - in_use, step
            if into == clock[PER_SAMPLE]:
                for i in range(own[0], own[1], own[2]):
                    note_parts(one, in_use, i, shift, speed)
                wait()
                for c in range(thread, n_columns, n_threads):
                    write_column(one, c, written, step * dt, along, rate)
                wait()
                for i in range(own[0], own[1], own[2]):
                    forget(one, i)
                into, written = 0, written + 1
            if written == clock[WANTED] or most == 0:
                break
            for i in range(own[0], own[1], own[2]):
                load_sphere(one, in_use, i, shift, speed)
            wait()
            step, into, most = step + 1, into + 1, most - 1
            along, rate = enclosure_of(one, step * dt)
            for i in range(own[0], own[1], own[2]):
                if move_sphere(one, i, step - made):
                    clock[LEFT] = step
            wait()
        wait()
        if thread == 0:
            clock[STEP], clock[INTO], clock[WRITTEN] = step, into, written
            clock[IN_USE], clock[MADE] = in_use, made

    return advance


def nothing_to_wait_for() -> None:
    """For the only thread of a slot."""


class Processor:
    """The slots worked by the processor, one after the other by one thread: see batch.Device."""

    def __init__(self, slots: Slots) -> None:
        self._slots = Slots(*(array.copy() for array in slots))
        self._advance = njit(advancing(njit(nothing_to_wait_for)))

    def bring(self, s: int, one: Slots) -> None:
        """Take over slot s from the arrays of a single slot."""
        for own, array in zip(self._slots, one, strict=True):
            if own is not self._slots.rows:
                own[s] = array[0]

    def go_on(self, clock: np.ndarray, which: np.ndarray, most: int) -> None:
        """Let these slots go on for so many steps at most; their rows of `clock` follow."""
        self._slots.clock[:] = clock
        for s in which:
            self._advance(self._slots, s, 0, 1, most)
        clock[which] = self._slots.clock[which]

    def fetch(self, slots: Slots, names: tuple[str, ...]) -> None:
        """Bring the named arrays of all slots into those of the host."""
        for name in names:
            getattr(slots, name)[:] = getattr(self._slots, name)
