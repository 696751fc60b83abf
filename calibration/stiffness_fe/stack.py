"""Two blocks between platens: what they bear when one platen moves, step by step.

The lower platen rests; the upper one is moved and does not rotate. Contacts are paired again from
the positions at the beginning of each step, so that surfaces may slide over each other; friction
remembers where it holds. Forces are per unit depth.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from calibration.stiffness_fe.blocks import Block
from calibration.stiffness_fe.contact import (
    OPEN,
    Array,
    NoContactStateError,
    Pairing,
    pair,
    solve_contact,
)
from granulab.errors import InputError

_HALVINGS = 6  # of a load step for which no state of the contacts is found


@dataclass(frozen=True)
class State:
    """State of the stack.

    platen        (2,) displacement of the upper platen [m]
    upper, lower  (2, n) forces on the surfaces' points [N/m]
    contact       (2, n) pressing force, and friction on the upper surface, of its points [N/m]
    doing         (n,) what each of them does: contact.OPEN, STICK, +-SLIDE; with periodic sides
                  the last point is the first one again
    work, dissipated   of the platen; in friction [J/m]
    """

    platen: Array
    upper: Array
    lower: Array
    contact: Array
    doing: NDArray[np.int64]
    work: float = 0.0
    dissipated: float = 0.0

    @property
    def force(self) -> Array:
        """(T, N) [N/m]: what drags the upper platen to the right, what presses it down."""
        x, y = self.upper.sum(axis=1)
        return np.array([-x, y])


class Stack:
    """An upper block on a lower one, with Coulomb's friction between them."""

    def __init__(self, upper: Block, lower: Block, friction: float) -> None:
        self.upper, self.lower, self.friction = upper, lower, friction
        periodic = "periodic" in (upper.sides, lower.sides)
        self._period = float(np.ptp(lower.points[:, 0])) if periodic else None

    @cached_property
    def _yields(self) -> tuple[Array, Array]:
        return self.upper.flexibility(), self.lower.flexibility()

    def at_rest(self) -> State:
        """Nothing moved, nothing borne."""
        n, m = len(self.upper.points), len(self.lower.points)
        idle = np.full(n, OPEN, dtype=np.int64)
        return State(np.zeros(2), np.zeros((2, n)), np.zeros((2, m)), np.zeros((2, n)), idle)

    def yielded(self, state: State) -> tuple[Array, Array]:
        """Displacements of the two surfaces' points by the forces on them, (2, n), (2, m) [m]."""
        up, low = self._yields
        return np.tensordot(up, state.upper), np.tensordot(low, state.lower)

    def stored(self, state: State) -> float:
        """Elastic energy of both blocks [J/m]."""
        up, low = self.yielded(state)
        return float((state.upper * up).sum() + (state.lower * low).sum()) / 2

    def move(self, state: State, by: Array, halvings: int = _HALVINGS) -> State:
        """The state after the upper platen went on by (2,) [m].

        Raises InputError where no state of the contacts is found, however small the steps.
        """
        try:
            return self._step(state, by)
        except NoContactStateError:
            if halvings == 0:
                raise InputError(
                    f"friction {self.friction:g}: the contacts find no state after a travel of "
                    f"{state.platen[1]:.3g} m across and {state.platen[0]:.3g} m along; a smaller "
                    "travel or a smoother profile would do"
                ) from None
        half = self.move(state, by / 2, halvings - 1)
        return self.move(half, by / 2, halvings - 1)

    def _step(self, state: State, by: Array) -> State:
        up, low = self.yielded(state)
        here = pair(
            self.upper.points + (up.T + state.platen), self.lower.points + low.T, self._period
        )
        # gap and slip of this step if the platen moved and the forces were gone: yielding
        # times ALL forces is added to it, so what the surfaces have yielded comes off
        onward = here.parted(np.repeat(by[:, None], up.shape[1], axis=1), np.zeros_like(low))
        free = onward - here.parted(up, low)
        free[0] += here.gap
        yielding = here.yielding(*self._yields)
        borne = state.contact[:, here.points]
        forces, doing = solve_contact(yielding, free.ravel(), self.friction, borne.ravel())
        slip = (free.ravel() + yielding @ forces).reshape(2, -1)[1]
        return self._after(state, by, here, forces.reshape(2, -1), doing, slip)

    def _after(
        self, state: State, by: Array, here: Pairing, forces: Array, doing: NDArray[np.int64],
        slip: Array,
    ) -> State:  # fmt: skip
        """The state with these forces (2, k) on the contacts, and the energy that the step took."""
        pushes = np.einsum("aci,ai->ci", here.rotation, forces)
        new = self.at_rest()
        new.upper[:, here.points], new.contact[:, here.points] = pushes, forces
        new.doing[here.points] = doing
        if self._period is not None:
            new.doing[-1], new.contact[:, -1] = new.doing[0], new.contact[:, 0]
        new = replace(
            new, platen=state.platen + by, lower=-here.handed_down(pushes, new.lower.shape[1])
        )
        drag, press = (state.force + new.force) / 2
        friction = (state.contact[1, here.points] + forces[1]) / 2
        lost = float(friction[doing != OPEN] @ slip[doing != OPEN])
        return replace(
            new, work=state.work + drag * by[0] - press * by[1], dissipated=state.dissipated - lost
        )
