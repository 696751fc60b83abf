"""Several threads that share a bed's steps leave the bits of one thread.

So do more threads than cores, and parts of unlike size. The beds are cut into more parts than their
size would have, since what is compared are bits, and these depend on parts but not on threads.
"""

import cluster_beds
import damper_beds
import numpy as np
import pytest
from host_scenes import resolved

from damper3d.run.fill import resting

STEPS, PER_SAMPLE = 2400, 100  # lists are made anew some hundred times
PARTS = 5


def in_parts(sim, n_parts=PARTS):
    """A bed cut into so many parts."""
    parts = np.arange(n_parts + 1) * sim.n_particles // n_parts
    sim.world = sim.world._replace(parts=parts, first_pair=np.zeros(n_parts + 1, np.int64))
    return sim


def hosted():
    """Twenty balls in an enclosure on a host, which takes their force at each step."""
    host = {"mass": "0.1 kg", "frequency": "20 Hz", "damping": 0.02, "drive": "base"}
    case = resolved(host=host, motion={"amplitude": "2 mm", "frequency": "20 Hz"})
    x, y, z = np.meshgrid(*[6e-3 * np.array([-0.5, 0.5])] * 2, 2.6e-3 + 5.5e-3 * np.arange(4))
    places = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    sim = resting(case, places)
    sim.begin_phase(shaker=case.shaker, gravity=np.append(case.gravity, 0.0))
    return sim


BEDS = {
    "spheres in a cylinder": lambda: damper_beds.bed("cylinder", steps_per_sample=PER_SAMPLE),
    "spheres in a box": lambda: damper_beds.bed("box", steps_per_sample=PER_SAMPLE),
    "clusters": lambda: cluster_beds.bed(
        "box", cluster_beds.asymmetric(cluster_beds.particle()), steps_per_sample=PER_SAMPLE
    ),
    "clusters that share": lambda: cluster_beds.bed(
        "cylinder", treatment="scaled", steps_per_sample=PER_SAMPLE
    ),
}


def gone_on(sim, n_threads):
    """All that is kept of a bed, and its samples, after steps by so many threads."""
    assert sim.share(n_threads) == min(n_threads, PARTS)
    columns = sim.run(STEPS // PER_SAMPLE)
    sim.step(37)
    return {**columns, **{f"saved {name}": array for name, array in sim.save().items()}}


@pytest.mark.parametrize("n_threads", [2, 3, 8])
@pytest.mark.parametrize("name", BEDS)
def test_no_bit_depends_on_the_number_of_threads(name, n_threads):
    expected = gone_on(in_parts(BEDS[name]()), 1)
    found = gone_on(in_parts(BEDS[name]()), n_threads)
    assert expected["saved books"].any()
    for what, array in expected.items():
        assert np.array_equal(found[what], array), what
