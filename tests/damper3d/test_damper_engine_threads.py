"""Several threads that share a bed's steps leave the bits of one thread.

So do more threads than cores, and parts of unlike size. The beds are cut into more parts than their
size would have, since what is compared are bits, and these depend on parts but not on threads.
"""

import cluster_beds
import damper_beds
import numpy as np
import pytest
from host_scenes import resolved

from damper3d.case.plan import most_threads
from damper3d.engine import state, world
from damper3d.engine.laws.cohesion import Dmt
from damper3d.engine.laws.table import Contact, law_table
from damper3d.engine.motions import Turning
from damper3d.run.fill import resting

STEPS, PER_SAMPLE = 2400, 100  # lists are made anew some hundred times
PARTS = 7


def in_parts(sim, n_parts=PARTS):
    """A bed cut into so many parts."""
    bounds = np.arange(n_parts + 1) * sim.n_particles // n_parts
    sim.world = sim.world._replace(**world.in_parts(bounds))
    return sim


def hosted():
    """Sixteen balls in an enclosure on a host, which takes their force at each step."""
    host = {"mass": "0.02 kg", "frequency": "40 Hz", "damping_ratio": 0.02, "force": "4 N"}
    case = resolved(host=host, motion={"frequency": "40 Hz"})
    x, y, z = np.meshgrid(*[6e-3 * np.array([-0.5, 0.5])] * 2, 2.6e-3 + 5.5e-3 * np.arange(4))
    places = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    sim = resting(case, places)
    sim.begin_phase(shaker=case.shaker, gravity=np.append(case.gravity, 0.0))
    return sim


def of_kinds():
    """Spheres whose contacts have the law of their kinds, with DMT's cohesion."""
    law = Contact(damper_beds.acrylic(), surface=0.05)
    laws = law_table([law], np.zeros((2, 2), int), np.zeros(36, int), np.full(36, 2.5e-3), Dmt(),
                     walls=np.array([1, 1, 1]))  # fmt: skip
    return damper_beds.bed("cylinder", pair_law=laws, wall_law=laws, steps_per_sample=PER_SAMPLE)


BEDS = {
    "spheres in a cylinder": lambda: damper_beds.bed("cylinder", steps_per_sample=PER_SAMPLE),
    "spheres in a box": lambda: damper_beds.bed("box", steps_per_sample=PER_SAMPLE),
}
MORE = {  # each has kernels of its own, half a minute to compile
    "kinds": of_kinds,
    "host": hosted,
    "clusters": lambda: cluster_beds.bed(
        "box", cluster_beds.asymmetric(cluster_beds.particle()), steps_per_sample=PER_SAMPLE
    ),
    "clusters that share": lambda: cluster_beds.bed(
        "cylinder", treatment="scaled", steps_per_sample=PER_SAMPLE
    ),
}


def gone_on(sim, n_threads):
    """All that is kept of a bed, and its samples, after steps by so many threads.

    Looks at the bed now and then make lists without the threads.
    """
    assert sim.share(n_threads) == min(n_threads, PARTS)
    columns = {}
    for k in range(4):
        new = sim.run(STEPS // PER_SAMPLE // 4)
        columns |= {f"{name} {k}": array for name, array in new.items()}
        sim.step(37)
        sim.contacts()
        sim.world.counts[[state.STALE_INNER, state.STALE_WALL]] = 1
        sim.refresh()
    sim.step(37)
    return {**columns, **{f"saved {name}": array for name, array in sim.save().items()}}


def compare(make, n_threads):
    expected, found = gone_on(in_parts(make()), 1), gone_on(in_parts(make()), n_threads)
    assert expected["saved books"].any()
    for what, array in expected.items():
        assert np.array_equal(found[what], array), what


@pytest.mark.parametrize(("name", "n_threads"), list(zip(BEDS, (2, 3), strict=True)))
def test_no_bit_depends_on_the_number_of_threads(name, n_threads):
    compare(BEDS[name], n_threads)


@pytest.mark.validation
@pytest.mark.parametrize("n_threads", [2, 5])
@pytest.mark.parametrize("name", MORE)
def test_no_bit_of_other_beds_depends_on_the_number_of_threads(name, n_threads):
    compare(MORE[name], n_threads)


def test_a_look_at_a_bed_that_was_put_back_does_not_show():
    """The threads' lists are those of before, though as many were made."""
    sims = [in_parts(BEDS["spheres in a box"]()) for _ in range(2)]
    for sim, n_threads in zip(sims, (1, 2), strict=True):
        sim.share(n_threads)
        sim.run(2)
        kept = sim.save()
        sim.compile()
        sim.restore(kept)
        sim.contacts()
        sim.run(4)
    assert sims[0].state_digest() == sims[1].state_digest()


def test_an_enclosure_that_begins_to_turn_is_left_to_one_thread():
    """Its torque is one number, to which all contacts add."""
    sim = in_parts(BEDS["spheres in a cylinder"]())
    assert sim.share(2) == sim.n_threads == 2
    sim.begin_phase(shaker=Turning(damper_beds.STILL, 1.0, np.zeros(1)))
    assert sim.n_threads == 1


ROLLS = {"rolling_friction": 0.01, "rolling_stiffness": "1 N/m", "rolling_damping": "1 mN s/m"}
TURNS = {"kind": "rotation", "frequencies": [80], "amplitudes": ["20 deg"]}


@pytest.mark.parametrize(
    ("tables", "shares"),
    [
        ({}, True),
        ({"law": {"cohesion": "dmt", "surface_energy": "0.05 J/m2"}}, True),
        ({"law": {"cohesion": "jkr", "surface_energy": "0.05 J/m2"}}, False),
        ({"law": ROLLS}, False),
        ({"excitation": TURNS}, False),
    ],
    ids=["plain", "DMT", "JKR", "rolling resistance", "turning"],
)
def test_the_threads_that_are_told_share_the_steps(tables, shares):
    """The echo tells them before there is a bed."""
    n, room = 1500, {"diameter": "20 mm", "height": "2 m"}
    case = resolved(particles={"shape": "sphere:5mm", "count": n}, enclosure=room, **tables)
    sim = resting(case, np.random.default_rng(1).uniform(0.0, 0.03, (n, 3)))
    sim.share(1000)
    sim.world = sim.world._replace(shaker=case.shaker)
    assert sim.n_threads == most_threads(case)
    assert (sim.n_threads > 1) == shares


def test_a_bed_goes_on_with_another_number_of_threads():
    """Also by one thread after several."""
    expected, found = (in_parts(BEDS["spheres in a box"]()) for _ in range(2))
    expected.run(24)
    for n_threads in (2, 1, 3):
        again = in_parts(BEDS["spheres in a box"]())
        again.restore(found.save())
        again.share(n_threads)
        again.run(8)
        found = again
    assert found.state_digest() == expected.state_digest()
    assert np.array_equal(found.world.balance, expected.world.balance)
