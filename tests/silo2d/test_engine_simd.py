"""The processor's vectors do what the plain form here does number by number: bit for bit."""

import numpy as np
import pytest
from inner_kernels import called

from silo2d.engine import simd
from silo2d.engine.state import BLOCK, FX, FY, INV_MASS, NOBODY, TORQUE, Forces

add_loads = called(simd.add_loads)  # only kernels call it

BODIES = 7
BEGIN = 5  # in the list, so that a place in the block is not one there


@pytest.mark.parametrize("kept", [0.0, 0.4])
@pytest.mark.parametrize("same", [None, 0, BODIES - 1])
@pytest.mark.parametrize("n", [*range(9), BLOCK - 1, BLOCK])
def test_loads_are_added_in_the_order_of_the_list(n, same, kept):
    """Also where one body has several of four pairs: sums of doubles depend on their order. Of some
    pairs nobody takes the load on one body or on both."""
    rng = np.random.default_rng(n)
    row = rng.normal(size=(BODIES, 16))
    bodies = np.array([rng.choice(BODIES, 2, replace=False) for _ in range(BEGIN + BLOCK)])
    if same is not None:
        bodies[(bodies != same).all(axis=1), 0] = same
    j, i = bodies.T.astype(np.uint32).copy()
    for bodies in (j, i):
        bodies[rng.random(len(bodies)) < kept] = NOBODY
    forces = Forces(*rng.normal(size=(len(Forces._fields), BLOCK)))
    plain = row.copy()
    for k in range(n):
        a, b = j[BEGIN + k], i[BEGIN + k]
        if a != NOBODY:
            plain[a, [FX, FY, TORQUE]] += forces.fx[k], forces.fy[k], forces.torque_j[k]
        if b != NOBODY:
            plain[b, [FX, FY]] -= forces.fx[k], forces.fy[k]
            plain[b, TORQUE] += forces.torque_i[k]
    aside = rng.normal(size=32) if kept else None
    sums = add_loads(row, aside, j, i, forces, BEGIN, n, (1.0, 2.0, 3.0))
    assert np.array_equal(row, plain)
    assert INV_MASS == TORQUE + 1  # the fourth of the row that is added to, by 0
    powers = forces.normal_power, forces.tangential_power, forces.lost
    for first, power, found in zip((1.0, 2.0, 3.0), powers, sums, strict=True):
        assert found == sum(power[:n].tolist(), first)
