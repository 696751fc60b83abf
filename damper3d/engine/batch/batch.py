"""Requests of many threads for slots, brought together: all that wait go on at once."""

import queue
import threading
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from damper3d.engine.batch.slots import (
    INTO,
    MOVING,
    OUTCOME,
    TOO_MANY_NEIGHBOURS,
    WANTED,
    WRITTEN,
    Slots,
    empty,
    lacks_room,
    put,
    reason_against,
    take,
)
from damper3d.engine.simulation import Simulation
from damper3d.engine.state import DONE, World

_AT_A_TIME = 500  # steps of a launch, which hears no Ctrl-C and is as long as its longest slot


class Device(Protocol):
    """The worker of the slots: a GPU, or the processor by one thread a slot; see device.py."""

    def bring(self, s: int, one: Slots) -> None:
        """Take over slot s from the arrays of a single slot."""

    def go_on(self, clock: np.ndarray, which: np.ndarray, most: int) -> None:
        """Let these slots go on for so many steps at most; their rows of `clock` follow."""

    def fetch(self, slots: Slots, names: tuple[str, ...]) -> None:
        """Bring the named arrays of all slots into those of the host."""


@dataclass
class _Request:
    """A thread's request: to bring a slot, to fetch slots, to free one, or samples."""

    slot: int = -1
    one: Slots | None = None
    fetches: bool = False
    wanted: int = 0
    done: threading.Event = field(default_factory=threading.Event)
    answer: Any = None
    error: BaseException | None = None


class Batch:
    """Slots on a device of a name, and the thread that serves it.

    refused: how many simulations it could not take, by why, in words.
    """

    def __init__(self, device: Device, slots: Slots, name: str = "") -> None:
        self.device, self.slots, self.name = device, slots, name
        self.refused: Counter[str] = Counter()
        self._free = list(range(len(slots.clock)))
        self._asked: queue.SimpleQueue[_Request | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End the thread, when nobody waits any more."""
        self._asked.put(None)
        self._thread.join()

    def join(self, sim: Simulation) -> int | None:
        """Bring a simulation into a slot; its number, None where there is no room for it."""
        slots, sizes = self.slots, self.slots.position.shape
        one = empty(1, sizes[1], slots.planes.shape[1], n_sines=slots.sines.shape[2],
                    room=slots.near.shape[2], rows=1)  # fmt: skip
        why = reason_against(sim) or lacks_room(one, sim)
        if why is None and not put(one, 0, sim, 0):
            why = TOO_MANY_NEIGHBOURS
        slot: int | None = None if why else self._ask(_Request(one=one))
        if slot is None:
            self.refused[why or "all slots were taken"] += 1
        return slot

    def leave(self, s: int) -> None:
        """Free a slot."""
        self._ask(_Request(s))

    def run(self, s: int, n_samples: int) -> np.ndarray:
        """Let slot s write samples, as many as it holds at most; those written, by rows.

        Fewer: it cannot go on there, and its state is to be fetched.
        """
        rows: np.ndarray = self._ask(_Request(s, wanted=min(n_samples, self.slots.rows.shape[1])))
        return rows

    def fetch(self, s: int, sim: Simulation) -> None:
        """Give a simulation the state of its slot."""
        self._ask(_Request(s, fetches=True))
        take(self.slots, s, sim)

    def steps_over(self, s: int) -> int:
        """Steps that slot s is past its last sample."""
        return int(self.slots.clock[s, INTO])

    def can_go_on(self, s: int) -> bool:
        """False where slot s has no room for its contacts, or its state is beyond belief."""
        return bool(self.slots.clock[s, OUTCOME] == DONE)

    def _ask(self, request: _Request) -> Any:
        self._asked.put(request)
        request.done.wait()
        if request.error is not None:
            raise request.error
        return request.answer

    def _serve(self) -> None:
        running: list[_Request] = []
        while True:
            asked = self._asked_now(wait=not running)
            if None in asked:
                return
            new = [request for request in asked if request is not None]
            try:
                running = self._go_on(new, running)
            except Exception as error:  # the threads that wait raise it
                for request in (*new, *running):
                    request.error = error
                    request.done.set()
                running = []

    def _asked_now(self, wait: bool) -> list[_Request | None]:
        """All that is asked by now; the first that is, where there is none and one may wait."""
        asked: list[_Request | None] = []
        with suppress(queue.Empty):
            while True:
                asked.append(self._asked.get(block=wait and not asked))
        return asked

    def _go_on(self, asked: list[_Request], running: list[_Request]) -> list[_Request]:
        """Do what is asked, and let all slots that want samples go on; those that want more."""
        clock = self.slots.clock
        if any(request.fetches for request in asked):
            self.device.fetch(self.slots, MOVING)
        for request in asked:
            if request.wanted:
                clock[request.slot, [WANTED, WRITTEN]] = request.wanted, 0
                continue
            if request.one is not None:
                request.answer = self._bring(request.one)
            elif not request.fetches:
                self._free.append(request.slot)
            request.done.set()
        running = running + [request for request in asked if request.wanted]
        if running:
            self.device.go_on(clock, np.array([each.slot for each in running]), _AT_A_TIME)
            ended = [each for each in running if self._has_ended(each.slot)]
            if ended:
                self.device.fetch(self.slots, ("rows",))
            for request in ended:
                request.answer = self.slots.rows[
                    request.slot, : clock[request.slot, WRITTEN]
                ].copy()
                request.done.set()
        return [request for request in running if not request.done.is_set()]

    def _bring(self, one: Slots) -> int | None:
        if not self._free:
            return None
        s = self._free.pop()
        self.slots.clock[s] = one.clock[0]
        self.device.bring(s, one)
        return s

    def _has_ended(self, s: int) -> bool:
        clock = self.slots.clock[s]
        return bool(clock[WRITTEN] == clock[WANTED] or clock[OUTCOME] != DONE)


class Batched(Simulation):
    """A simulation that goes on in a batch, beside others, from its first sample on.

    Its state stays on the device until its world is asked for. Where the slot has no room for its
    contacts, or the state is beyond belief, it leaves and goes on by itself, as any does.
    """

    def __init__(self, sim: Simulation, batch: Batch) -> None:
        self._batch, self._slot = batch, -1
        self._stale = self._alone = self._went = False
        super().__init__(sim.world, sim.steps_per_sample)
        self._counts_impacts = sim._counts_impacts

    @property
    def world(self) -> World:
        """The world as it is now."""
        if self._stale:
            self._stale = False
            self._batch.fetch(self._slot, self)
        return self._world

    @world.setter
    def world(self, world: World) -> None:
        self._world = world

    def fill(self, rows: np.ndarray) -> None:
        """Go on by a sample for each row of `room`, and write them."""
        if self._slot < 0 and not self._alone:
            slot = self._batch.join(self)
            self._slot, self._alone = (-1, True) if slot is None else (slot, False)
        done = 0
        while done < len(rows) and not self._alone:
            new = self._batch.run(self._slot, len(rows) - done)
            self._stale = self._went = True
            rows[done : done + len(new)] = new[:, : rows.shape[1]]
            done += len(new)
            if not self._batch.can_go_on(self._slot):
                self._batch.refused[TOO_MANY_NEIGHBOURS] += 1
                taken = self._batch.steps_over(self._slot)
                self.leave()
                self.end_sample(rows[done], taken)
                done += 1
        if done < len(rows):
            super().fill(rows[done:])

    def leave(self) -> str | None:
        """Fetch the state and free the slot; the name of the device, None where it was not there.

        What follows is done here.
        """
        if self._slot >= 0:
            self._world = self.world
            self._batch.leave(self._slot)
        self._slot, self._alone = -1, True
        return self._batch.name if self._went else None
