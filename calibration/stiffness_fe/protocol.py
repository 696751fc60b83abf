"""The test: press two blocks together, then shear them; forces, stiffnesses and what balances.

kn = N/dx_n and kt = T/dx_t of the platens' travel, so that their ratio is eq. 3.3,
kt/kn = (sigma_t/sigma_n) (dx_n/dx_t), with sigma = force over nominal area. Travel counts from the
first touch.
"""

from dataclasses import dataclass

import numpy as np

from calibration.stiffness_fe.blocks import Array, Block, Elastic
from calibration.stiffness_fe.contact import OPEN, STICK
from calibration.stiffness_fe.stack import Stack, State
from calibration.stiffness_fe.surfaces import first_touch
from granulab.errors import InputError


@dataclass(frozen=True)
class Case:
    """Two like blocks, in SI: width and height of each, depth, sides, mesh and load steps.

    together: shear and compression grow at once, not one after the other.
    """

    material: Elastic
    width: float
    height: float
    depth: float
    sides: str = "periodic"
    columns: int = 160
    steps: int = 20  # of each of compression and shear
    together: bool = False

    def points(self) -> Array:
        """x of the columns, (columns + 1,) [m]."""
        return np.linspace(0.0, self.width, self.columns + 1)


@dataclass(frozen=True)
class Load:
    """Friction between the surfaces, and how far the platen goes across and along them [m]."""

    friction: float
    across: float
    along: float


@dataclass(frozen=True)
class Outcome:
    """Outcome of a test; per unit depth, N/m where nothing else is said.

    platen   (k, 2) travel along and towards each other [m], at the load steps, from 0 on
    force    (k, 2) T and N
    pressed  index of the end of compression
    """

    stack: Stack
    state: State
    platen: Array
    force: Array
    pressed: int
    touching: float  # share of the width, after compression
    sliding: float  # share of what touches, at the end

    @property
    def kn(self) -> float:
        """N/dx_n after compression [N/m2]."""
        return float(self.force[self.pressed, 1] / self.platen[self.pressed, 1])

    @property
    def kt(self) -> float:
        """T/dx_t at the end [N/m2]."""
        return float(self.force[-1, 0] / self.platen[-1, 0])

    @property
    def ratio(self) -> float:
        """kt/kn by eq. 3.3 at the end."""
        (along, across), (drag, press) = self.platen[-1], self.force[-1]
        return float(drag / press * across / along)

    @property
    def onset(self) -> float:
        """kt/kn of the first step of shear: before most of what slides does."""
        k = 1 if self.pressed == len(self.platen) - 1 else self.pressed + 1
        along, drag = (one[k, 0] - one[k - 1, 0] for one in (self.platen, self.force))
        return float(drag / along / self.kn)

    @property
    def unaccounted(self) -> float:
        """Work that is neither stored nor lost in friction, over the work."""
        state = self.state
        left = state.work - self.stack.stored(state) - state.dissipated
        return float(left / state.work)

    @property
    def imbalance(self) -> float:
        """Difference of the platens' reactions, from the elements, and the contact's force."""
        stack, state = self.stack, self.state
        bears = [
            block.reaction(block.displacements(forces))
            for block, forces in ((stack.upper, state.upper), (stack.lower, state.lower))
        ]
        drag, press = state.force
        expected = np.array([[drag, -press], [-drag, press]])
        return float(np.abs(np.array(bears) - expected).max() / press)


def press_and_shear(case: Case, load: Load, lower: Array, upper: Array) -> Outcome:
    """Press and shear blocks whose surfaces have these heights (columns + 1,) [m]."""
    stack = _stack(case, load.friction, lower, first_touch(lower, upper))
    state = stack.at_rest()
    platen, force = [np.zeros(2)], [np.zeros(2)]
    touching = 0.0
    pressed = 0
    for k, by in enumerate(_path(case, load)):
        state = stack.move(state, by)
        platen.append(state.platen * [1, -1])
        force.append(state.force)
        if by[1] != 0:
            pressed, touching = k + 1, float((state.doing != OPEN).mean())
    if state.force[1] <= 0:
        raise InputError(
            f"the surfaces lost touch after {load.along:g} m along: a longer travel across, or a "
            "shorter one along, would do"
        )
    touch = state.doing != OPEN
    sliding = float((np.abs(state.doing[touch]) > STICK).mean())
    return Outcome(stack, state, np.array(platen), np.array(force), pressed, touching, sliding)


def _path(case: Case, load: Load) -> list[Array]:
    """Steps of the upper platen."""
    down, right = np.array([0.0, -load.across]), np.array([load.along, 0.0])
    n = case.steps
    if case.together:
        return [(down + right) / (2 * n)] * (2 * n)
    return [down / n] * n + [right / n] * n


def _stack(case: Case, friction: float, lower: Array, upper: Array) -> Stack:
    """The blocks, each as high as the case says between its platen and its mean surface."""
    x, material = case.points(), case.material
    below = Block(x, lower, float(lower.mean()) - case.height, material, case.sides)
    above = Block(x, upper, float(upper.mean()) + case.height, material, case.sides)
    return Stack(above, below, friction)
