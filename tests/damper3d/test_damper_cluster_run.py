"""A damper of clusters from its filling to its results: the start, runs, resumption, bad input."""

import math
import shutil
from pathlib import Path

import numpy as np
import pytest
from cluster_beds import rotation
from damper_runs import small_spheroids as small
from forking import forked
from refusals import assert_refused
from same_run import assert_same_run
from small_damper import damper3d
from small_silo import the_run

from damper3d.case.case import DamperCase
from damper3d.run import protocol, vibration
from damper3d.run.fill import fill, random_start
from damper3d.view.scene import read_scene
from granulab.campaign.runs.trajectory import read_tables
from granulab.errors import InputError


@pytest.mark.parametrize("shape", ["prolate:2", "toroid:0.2"])
def test_the_random_start_has_no_overlap_and_lies_inside(shape):
    """All spheres of all pairs, and all against the walls, by brute force; the seed gives it."""
    case = small(particles__shape=shape)
    centres, turns = random_start(case, 30)
    particle = case.particle
    spheres = np.array([x + particle.offsets @ rotation(q).T
                        for x, q in zip(centres, turns, strict=True)])  # fmt: skip
    for i in range(30):
        for j in range(i):
            gap = np.linalg.norm(spheres[i][:, None] - spheres[j][None], axis=2)
            assert (gap > particle.radii[:, None] + particle.radii[None]).all()
    assert (np.hypot(spheres[..., 0], spheres[..., 1]) + particle.radii < 0.01).all()
    assert (np.abs(spheres[..., 2] - 0.01) + particle.radii < 0.01).all()
    again, other = random_start(case, 30), random_start(small(particles__shape=shape,
                                                              run__seed=2), 30)  # fmt: skip
    assert again[0].tobytes() == centres.tobytes()
    assert again[1].tobytes() == turns.tobytes()
    assert abs(other[0] - centres).max() > 1e-3


def test_orientations_of_the_random_start_have_no_direction():
    """Mean square cosine between the axis and each direction is 1/3, with a standard error of
    2/sqrt(45 n) in an isotropic set; within four of them before walls align any."""
    from damper3d.engine.growth.multisphere import random_places

    case, n = small(), 60
    _, turns, _ = random_places(case.enclosure, case.particle, n, np.random.default_rng(1))
    axes = np.array([rotation(q)[:, 0] for q in turns])
    assert (axes**2).mean(axis=0) == pytest.approx(1 / 3, abs=4 * 2 / math.sqrt(45 * n))


def test_too_many_multi_sphere_particles_are_refused_with_the_number_that_fits():
    with pytest.raises(InputError, match=r"count = 88: fill ratio 0\.\d+; .* about \d\d; give"):
        fill(small(particles__count=88, particles__shape="prolate:2"), lambda *_: None)


def test_a_run_gives_results_and_keeps_the_orientations(spheroid_reference):
    """Energy balance closed, the mass of the smooth shape, unit quaternions in single precision."""
    results = spheroid_reference.read_summary()
    assert results["particles"] == "prolate:1.5"
    mass = 1190 * 4 / 3 * math.pi * 2.2e-3**3
    assert results["particle_mass_kg"] == pytest.approx(mass, rel=1e-12)
    assert abs(results["energy_closure"]) < 0.02  # 0.005 at 1 us, four times that at 2 us
    assert 0.0 < results["efficiency"] < 1.0
    assert 1.0 < results["packing"]["coordination"] < 10.0  # particles and walls, not spheres
    last = read_tables(spheroid_reference.path, "particles").at(-1)
    size = sum(last[f"turn_{c}"].astype(float) ** 2 for c in "wxyz")
    assert size == pytest.approx(1.0, abs=1e-6)


def test_pictures_show_the_spheres_where_they_are(spheroid_reference):
    """Those of each particle, turned by its quaternion, in single precision: 10 mm to 1e-9 m."""
    scene, particle = read_scene(spheroid_reference.path), small().particle
    table = read_tables(spheroid_reference.path, "particles").at(-1)
    arm, radius, whose = scene.spheres(len(scene.frame_sample) - 1)
    k = len(particle.radii)
    for n in (0, 17):
        turn = rotation([float(table[f"turn_{c}"][n]) for c in "wxyz"])
        assert arm[n * k : (n + 1) * k] == pytest.approx(particle.offsets @ turn.T, abs=1e-8)
        assert (whose[n * k : (n + 1) * k] == n).all()
    assert np.array_equal(radius[:k], particle.radii)


@pytest.mark.parametrize("write", [3, 6])
def test_a_run_that_is_killed_goes_on_to_the_same_bits(
    spheroid_reference, tmp_path, monkeypatch, write
):
    """Killed at its so many-th write, with a checkpoint every three samples."""
    monkeypatch.setattr(vibration, "CHECKPOINT_WORK", 3 * 30 * 315 + 1)
    shutil.copytree(spheroid_reference.path.parent / "packings", tmp_path / "packings")
    assert forked(lambda: protocol.run(small(), out=tmp_path), kill_at_write=write + 5) == -9
    protocol.run(small(), out=tmp_path)
    assert_same_run(the_run(tmp_path), spheroid_reference)


def test_the_multi_contact_model_names_runs_of_multi_sphere_particles_alone():
    """A ball has one contact with another: its runs keep their names."""
    names = {t: protocol.run_digest(small(law__contact_treatment=t)) for t in
             ("sum", "deepest", "scaled")}  # fmt: skip
    assert len(set(names.values())) == 3
    balls = [DamperCase.load("thesis", {"law.contact_treatment": t}) for t in ("sum", "deepest")]
    assert protocol.run_digest(balls[0]) == protocol.run_digest(balls[1])


def test_bad_multi_contact_models_are_refused_in_one_line(tmp_path):
    for options, word in (
        (["--contact-treatment", "mean"], "contact_treatment"),
        (["--contact-treatment", "scaled", "--yielding"], "yielding"),
    ):
        result = damper3d("run", "--particles", "prolate:1.5", *options, "-o", tmp_path, "--quiet")
        assert_refused(result, word)


def test_a_run_from_the_command_line(tmp_path):
    """Of a toroid, with its pictures; the packing lies next to it."""
    result = damper3d("run", "--particles", "toroid:0.2", "--equal-volume-radius", "2.2 mm",
                      "--diameter", "20 mm", "--height", "20 mm", "--count", 12, "--frequency",
                      200, "--cycles", 2, "--discard", 1, "--time-step", "2 us",
                      "--contact-treatment", "scaled", "--frames", 5, "-o", tmp_path,
                      "--quiet")  # fmt: skip
    assert (result.code, result.err) == (0, "")
    assert "12 of toroid:0.2" in result.out
    assert list((the_run(Path(tmp_path)).path / "figures").glob("*.png"))
