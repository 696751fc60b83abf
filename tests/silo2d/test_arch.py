"""The clogging arch: found where it was built, and only where there is one."""

import numpy as np
import pytest
import scenes
from hand_built import GRAVITY, moment_of, scene_of, simulation_in, write_run
from refusals import assert_refused, assert_refuses
from small_silo import silo2d

from granulab.errors import FolderError, InputError
from silo2d.case.outline import hopper
from silo2d.measures import arch
from silo2d.measures.basics.contacts import read_moments

BLOCK = scenes.block(20e-3, 10e-3)
SQUEEZED = 10e-6  # [m] that a row of three blocks is too long for the gap
# A gap without a floor: what stands in it is wedged between its walls.
GAP = hopper(0.0, 60e-3 - SQUEEZED, 60e-3 - SQUEEZED, 0.12, "gap")
SETTLING = 20000  # steps, 40 ms


def row(height: float) -> list[tuple[float, float, float]]:
    """Three blocks side by side that fill the gap."""
    step = 20e-3 - SQUEEZED / 3
    return [(k * step, height, 0.0) for k in (-1, 0, 1)]


def settled(tmp_path, poses, outcome="clogged"):
    shapes = [BLOCK] * len(poses)
    sim = simulation_in(GAP, shapes, poses)
    sim.run(SETTLING)
    return write_run(tmp_path / "run", sim, GAP, shapes, outcome)


def test_three_wedged_blocks_are_an_arch(tmp_path):
    """The row, from left to right, and not what lies on it; its span is the gap, it is flat, and
    what it carries is the weight of the two blocks on top."""
    poses = [*row(0.05), (-9e-3, 0.06, 0.0), (12e-3, 0.06, 0.0)]
    order = [4, 1, 3, 0, 2]  # the number of a particle means nothing
    folder = settled(tmp_path, [poses[k] for k in order])
    found = arch.measure(folder)
    assert found["grains"] == [order.index(k) for k in (0, 1, 2)]
    assert found["n_grains"] == 3
    assert found["span_m"] == pytest.approx(GAP.width, rel=1e-3)
    # The line passes the contact points, which lie anywhere on the faces: within half a block.
    assert abs(found["rise_m"]) < 5e-3
    weight = 54.0 * BLOCK.area * GRAVITY
    assert found["load_n"] == pytest.approx(2 * weight, rel=0.02)
    assert (found["left_foot"], found["right_foot"]) == ("left wall", "right wall")


def test_thrust_of_the_wedged_row(tmp_path):
    """Springs in series: two contacts at each wall, eight between two blocks (spec), so that
    F = s/(2/(2 kn) + 2/(8 kn)) for a row that is s too long."""
    found = arch.measure(settled(tmp_path, row(0.05)))
    thrust = SQUEEZED * scenes.KN / (2 / 2 + 2 / 8)
    assert found["mean_force_n"] == pytest.approx(thrust, rel=0.02)
    assert found["weakest_over_weight"] > 100


def test_of_two_arches_the_lower_is_found(tmp_path):
    folder = settled(tmp_path, [*row(0.08), *row(0.03)])
    assert arch.measure(folder)["grains"] == [3, 4, 5]


def test_a_particle_that_rests_on_one_wall_is_no_arch(tmp_path):
    """A row that does not reach the other side: the chain is not closed."""
    folder = settled(tmp_path, row(0.05)[:2])
    with pytest.raises(FolderError, match="no chain of load-bearing contacts"):
        arch.measure(folder)


def test_a_silo_with_inserts_has_no_arch_between_its_walls(tmp_path, monkeypatch):
    folder = settled(tmp_path, row(0.05))
    (moment,) = read_moments(folder)
    moment.scene.wall_names[0] = "insert 1 side 1"
    monkeypatch.setattr(arch, "read_moments", lambda _: [moment])
    assert_refuses(["inserts", "between its walls"], arch.measure, folder)


def weighed(bodies, force, x, y):
    """Contacts of given normal forces [N] between particles at points; bodies 0 ... n - 1, then
    the right wall n, the left wall n + 1."""
    scene = scene_of([BLOCK], np.zeros(len(x), int), GAP, np.array(x), np.array(y))
    places = np.vstack([np.column_stack([x, y]), [[0.03, 0.05], [-0.03, 0.05]]])
    normal = np.array([places[b] - places[a] for a, b in bodies])
    normal /= np.hypot(*normal.T)[:, None]
    points = np.array([(places[a] + places[b]) / 2 for a, b in bodies])
    return moment_of(
        scene,
        {"bodies": bodies, "point": points, "force": np.array(force)[:, None] * normal,
         "normal": normal},
    )  # fmt: skip


def keystone(across, besides):
    """A row 0 1 2 between the walls, and particle 3 below, between 0 and 1; forces on 0-1 and 3."""
    return weighed(
        [(1, 2), (0, 5), (2, 4), (0, 1), (0, 3), (1, 3)],
        [10.0, 10.0, 10.0, across, besides, besides],
        [-0.02, 0.0, 0.02, -0.01],
        [0.05, 0.05, 0.05, 0.04],
    )


@pytest.mark.parametrize(
    ("across", "besides", "chain"),
    [(10.0, 1.0, [0, 1, 2]), (1.0, 10.0, [0, 3, 1, 2]), (0.0, 10.0, [0, 3, 1, 2])],
)
def test_a_particle_between_two_belongs_to_the_arch_if_it_carries_the_thrust(
    across, besides, chain
):
    """Below them, it hangs where they press each other; where they do not, it is the keystone."""
    assert arch.find_arch(keystone(across, besides)).particles.tolist() == chain


def test_a_contact_that_bears_next_to_nothing_joins_nothing():
    """The threshold is a tenth of a mean particle's weight, 0.1 N here."""
    weight = 54.0 * BLOCK.area * GRAVITY
    bodies, x, y = [(0, 1), (0, 2)], [0.0], [0.05]
    assert arch.find_arch(weighed(bodies, [0.11 * weight] * 2, x, y)).particles.tolist() == [0]
    with pytest.raises(FolderError, match="no chain"):
        arch.find_arch(weighed(bodies, [0.11 * weight, 0.09 * weight], x, y))
    with pytest.raises(FolderError, match="no chain"):
        arch.find_arch(weighed(bodies, [0.11 * weight, -1.0], x, y))


def test_shape_of_a_gable():
    """Two particles that lean on each other: rise and span by hand."""
    moment = weighed([(0, 1), (0, 3), (1, 2)], [5.0] * 3, [-0.01, 0.01], [0.06, 0.06])
    found = arch.find_arch(moment)
    # Feet half way to the walls, (-20, 55) and (20, 55) mm; crown at 60 mm.
    assert found.span == pytest.approx(0.04)
    assert found.rise == pytest.approx(0.005)
    assert found.forces.tolist() == pytest.approx([5.0] * 3)


def test_a_run_that_did_not_clog_has_one_clear_line(reference):
    """Exit code 2, and what would do."""
    result = silo2d("observe", reference.path, "arch", "--no-figures")
    assert_refused(result, "did not clog (outcome empty)")
    with pytest.raises(InputError, match="did not clog"):
        arch.measure(reference.path)


def test_the_arch_is_drawn(tmp_path):
    folder = settled(tmp_path, row(0.05))
    result = silo2d("observe", folder, "arch")
    assert result.code == 0, result.err
    assert (folder / "figures" / "arch.png").stat().st_size > 10_000
    assert len(read_moments(folder)) == 1
