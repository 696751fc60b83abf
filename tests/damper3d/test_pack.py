"""Random packing: forces in the periodic cell, jammed packings, what the onset takes from them."""

import itertools
import json
from pathlib import Path

import numpy as np
import pytest
from refusals import assert_refused
from small_damper import damper3d

from damper3d.case.case import DamperCase
from damper3d.case.random_packing import Fraction, close_packing, loose_packing
from damper3d.engine.growth.periodic import GYRATION, MOST, SIDE, list_pairs, push
from damper3d.reproduce.quantities.packing import shipped
from damper3d.shapes.multisphere import sphere
from damper3d.shapes.particle import parse_particle
from damper3d.studies.pack.compact import ALLOWED, cell_of, compact, coordination
from damper3d.studies.pack.shaken import softened
from damper3d.studies.predict.prediction import predict
from granulab.campaign.output.results import read_results
from granulab.contact.files.datafile import data_root
from granulab.errors import InputError

RESULTS = Path(__file__).parents[2] / "docs" / "results" / "damper3d"


def crowd(seed, side=4.0, bodies=5):
    """Rings of 12 sub-spheres that overlap, also through the faces of the cell."""
    rng = np.random.default_rng(seed)
    turns = rng.normal(size=(bodies, 4))
    turns /= np.linalg.norm(turns, axis=1)[:, None]
    ring = parse_particle("toroid:0.2", 1.0, sub_spheres=12)
    return cell_of(ring, rng.uniform(0, side, (bodies, 3)), turns, side)


def spheres_of(cell):
    """Centres (n, k, 3) by scipy's rotations."""
    from scipy.spatial.transform import Rotation

    turns = Rotation.from_quat(cell.turn, scalar_first=True)
    arms = [turn.apply(cell.offset[:, :3]) for turn in turns]
    return cell.position[:, None] + np.array(arms)


def energy(cell):
    """Sum of overlap^2/2 of all pairs of bodies and all images, over the cell's own scale."""
    centres, radii, side = spheres_of(cell), cell.offset[:, 3], cell.measure[SIDE]
    reach, total = radii[:, None] + radii[None, :], 0.0
    for a, b in itertools.combinations(range(len(centres)), 2):
        for image in itertools.product((-1, 0, 1), repeat=3):
            other = centres[b] + side * np.array(image)
            gap = np.linalg.norm(centres[a][:, None] - other[None], axis=2) - reach
            total += 0.5 * (np.minimum(gap, 0.0) ** 2).sum()
    return total / cell.tally[MOST]


def turned(q, axis, angle):
    """A unit quaternion after a turn about one of the laboratory's axes."""
    from scipy.spatial.transform import Rotation

    step = Rotation.from_rotvec(angle * np.eye(3)[axis])
    return (step * Rotation.from_quat(q, scalar_first=True)).as_quat(scalar_first=True)


def test_pushes_are_the_gradient_of_the_energy_of_all_overlaps():
    """F = -dU/dx, and torque/gyration = -dU/(gyration dangle), by central differences.

    The energy is summed over all pairs and images by brute force, so the list lacks none. Where an
    overlap begins, the second derivative jumps: steps of 1e-6 leave 1e-6 of stiffness 12 x 12.
    """
    cell = crowd(1)
    assert list_pairs(cell)
    force = np.zeros((5, 6))
    push(cell, force)
    step, gyration = 1e-6, cell.measure[GYRATION]
    found = np.zeros((5, 6))
    for b, c in itertools.product(range(5), range(6)):
        ends = []
        for sign in (1.0, -1.0):
            place, turn = cell.position[b].copy(), cell.turn[b].copy()
            if c < 3:
                cell.position[b, c] += sign * step
            else:
                cell.turn[b] = turned(turn, c - 3, sign * step / gyration)
            ends.append(energy(cell))
            cell.position[b], cell.turn[b] = place, turn
        found[b, c] = -(ends[0] - ends[1]) / (2 * step)
    np.testing.assert_allclose(force, found, atol=1e-5)
    assert np.abs(force).max() > 1e-2


def test_pushes_do_not_know_where_the_cell_begins():
    """A body and its image are one: moved by whole sides, all forces stay."""
    first, moved = crowd(2), crowd(2)
    moved.position[1] += [4.0, -8.0, 4.0]
    forces = []
    for cell in (first, moved):
        assert list_pairs(cell)
        forces.append(np.zeros((5, 6)))
        push(cell, forces[-1])
    np.testing.assert_allclose(forces[0], forces[1], atol=1e-12)


def test_jammed_spheres_are_isostatic_and_close_packed():
    """6 neighbours without rattlers (O'Hern et al. 2003), and 8 (3e-4)^0.5 = 0.14 more at 3e-4
    above jamming; that is resolved to 2e-4, and 2/60 lack of a finite cell. Fraction: their mean
    0.64 - 0.12 60^-0.47 = 0.62 with a width of 0.16 60^-0.55 = 0.017, to three of them.
    """
    packed = compact(sphere(1.0), 60, 1)
    assert packed.coordination == pytest.approx(6.0, abs=0.3)
    assert packed.fraction == pytest.approx(0.62, abs=0.05)
    assert packed.overlap <= ALLOWED
    assert packed.rattlers < 0.15


def test_spheroids_pack_closer_than_spheres_and_are_hypostatic():
    """Donev et al. 2004: 0.70 at 1.5, and below the 10 neighbours of five freedoms."""
    packed = compact(parse_particle("prolate:1.5", 1.0, sub_spheres=13), 40, 1)
    assert packed.fraction == pytest.approx(0.70, abs=0.03)
    assert 7.5 < packed.coordination < 10.0
    assert packed.overlap <= ALLOWED


def test_what_nothing_holds_is_left_out_of_the_coordination():
    """A tetrahedron of five that all touch, and a chain of two on it: the chain falls off."""
    neighbours = np.zeros((7, 7), bool)
    neighbours[:5, :5] = ~np.eye(5, dtype=bool)
    neighbours[4, 5] = neighbours[5, 4] = neighbours[5, 6] = neighbours[6, 5] = True
    assert coordination(neighbours) == (4.0, pytest.approx(5 / 7))


def test_too_few_particles_for_the_cell_are_refused():
    with pytest.raises(InputError, match=r"bodies = 3: must be at least .* of prolate:3"):
        compact(parse_particle("prolate:3", 1.0, sub_spheres=13), 3, 1)
    result = damper3d("pack", "--particles", "prolate:3", "--bodies", 3, "--no-enclosure")
    assert_refused(result)


def test_the_soft_particles_of_a_case_are_of_the_materials_file_beside_it(tmp_path, monkeypatch):
    """E of 6.6 GPa, and not of a file of that name where the command is called: hertz over 100."""
    for folder, modulus in (("own", "6.6 GPa"), ("called", "33 GPa")):
        (tmp_path / folder).mkdir()
        shipped_text = (data_root() / "materials" / "acrylic.toml").read_text(encoding="utf-8")
        text = shipped_text.replace("3.3 GPa", modulus)
        (tmp_path / folder / "mine.toml").write_text(text, encoding="utf-8")
    case = tmp_path / "own" / "case.toml"
    case.write_text('schema = 1\n[particles]\nmaterials = "mine.toml"\n', encoding="utf-8")
    monkeypatch.chdir(tmp_path / "called")
    hard, soft = DamperCase.load(case), softened(str(case), {})
    assert soft.wall_law.hertz == pytest.approx(hard.wall_law.hertz / 100, rel=1e-5)


# What is shipped


def test_spheres_keep_the_published_fractions_and_the_table_checks_them():
    """0.64 and 0.55 (thesis, below eq. 6.13); the uncertainty of 0.64 is how far ours is off."""
    assert close_packing("sphere:5mm").value == close_packing("prolate:1").value == 0.64
    assert loose_packing("toroid:0").value == 0.55
    assert loose_packing("prolate:1.5") is None
    assert close_packing("sphere:5mm").uncertainty < 0.02


def test_a_ratio_between_two_of_the_table_lies_between_their_fractions():
    low, high = close_packing("oblate:0.7"), close_packing("oblate:0.85")
    between = close_packing("oblate:0.8")
    assert min(low.value, high.value) < between.value < max(low.value, high.value)
    assert close_packing("prolate:4") is None
    assert close_packing("cylinder:1.5,0.2") is None


def test_the_shipped_table_is_made_of_the_committed_packings():
    """Made again by writing shipped(rows) to data/packings/random.csv."""
    rows = read_results(RESULTS / "reproduce-packing.csv")[1]
    text = (data_root() / "packings" / "random.csv").read_text(encoding="utf-8")
    assert text == shipped(rows)


# What the onset and the count take from it


def shaped(shape, **changes):
    return DamperCase.load("thesis", {"particles.shape": shape, **changes})


def test_the_onset_goes_by_the_close_packing_of_the_shape():
    """Eqs 6.11 and 6.13; its uncertainty is the derivative by the packing times that one's."""
    case = shaped("prolate:1.5")
    known = close_packing("prolate:1.5")
    best = predict(case).best
    assert (best.name, best.packing) == ("close", known.value)
    above, below = (
        predict(case, close=Fraction(known.value + off, 0.0, "")).best.onset(40.0)
        for off in (known.uncertainty, -known.uncertainty)
    )
    # The curvature, sigma/nu, of a difference over 2 sigma, is of second order: 1e-4.
    assert best.onset_uncertainty(40.0) == pytest.approx((above - below) / 2, rel=1e-3)


def test_a_shape_that_is_not_in_the_table_needs_a_packing_by_hand(tmp_path):
    command = ("predict", "--particles", "prolate:4", "--height", "40 mm", "--no-figures",
               "-o", tmp_path)  # fmt: skip
    result = damper3d(*command)
    assert_refused(result, "--pack")
    given = json.loads(damper3d(*command, "--packing", 0.7, "--json").out)
    found = {row["packing"]: row["gamma"] for row in given["fills"][0]["bouncing_bed"]}
    assert found["close"] == [None] * 3
    assert all(found["own"])


def test_the_count_may_fill_as_much_as_the_shape_packs():
    """140 of 90 at 0.41 are 0.640: too many spheres by a hair, but not spheroids."""
    assert shaped("prolate:1.5", **{"particles.count": 145}).count == 145
    with pytest.raises(InputError, match=r"above random close packing, 0\.64"):
        shaped("prolate:1", **{"particles.count": 145})


@pytest.mark.parametrize(
    ("command", "option", "cure"),
    [
        (["predict", "--frequency", "20"], "--frequency", "--frequencies"),
        (["predict", "--gamma", "3"], "--gamma", "--simulate"),
        (["map", "--gamma", "3"], "--gamma", "--gammas"),
        (["pack", "--seed", "2"], "--seed", "--packings"),
        (["pack", "--engine", "dask"], "--engine", "No such option"),
    ],
)
def test_option_that_a_command_does_not_take_is_refused_and_not_in_its_help(
    command, option, cure, tmp_path
):
    assert_refused(damper3d(*command), option, cure)
    told = damper3d(command[0], "--help").out
    assert f" {option} " not in told
