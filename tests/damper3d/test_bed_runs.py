"""Runs of unlike spheres: their bits, their books, what they keep."""

import random
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from damper_runs import CASE
from same_run import assert_same_run, results
from small_silo import the_run

from damper3d.case.case import DamperCase
from damper3d.run import protocol
from damper3d.run.fill import random_start
from damper3d.view.colouring import colouring
from damper3d.view.export import export
from damper3d.view.scene import read_scene
from granulab.campaign.runs.trajectory import read_trajectory
from granulab.errors import Stopped


def mixed(first: tuple[str, int], second: tuple[str, int], **changes: Any) -> DamperCase:
    """The small damper with two kinds of sphere: shape and count of each."""
    kinds = [{"shape": shape, "count": count} for shape, count in (first, second)]
    usual = {key: value for key, value in CASE.items() if key != "particles.count"}
    named = {key.replace("__", "."): value for key, value in changes.items()}
    return DamperCase.load("thesis", usual | {"particles.kind": kinds} | named)


def unlike() -> DamperCase:
    return mixed(("sphere:5mm", 8), ("sphere:3.4mm", 30))


@pytest.fixture(scope="module")
def run_of_unlike(tmp_path_factory) -> Path:
    root = tmp_path_factory.mktemp("unlike")
    protocol.run(unlike(), out=root)
    return the_run(root).path


@pytest.mark.validation  # compiles kernels of its own
def test_two_kinds_that_are_alike_are_filled_and_shaken_to_the_bits_of_one(
    damper_reference, tmp_path
):
    """Sizes by sphere and laws by pair give what one size and one law give."""
    found = protocol.run(mixed(("sphere:5mm", 12), ("sphere:5mm", 8)), out=tmp_path)
    assert found.state_digest == results(damper_reference)["state_digest"]
    assert [kind["count"] for kind in found.kinds] == [12, 8]
    assert results(damper_reference)["kinds"] is None


def test_unlike_spheres_begin_without_overlap():
    case = mixed(("sphere:5mm", 12), ("sphere:2.5mm", 100))
    centres, _ = random_start(case, case.count)
    apart = np.linalg.norm(centres[:, None] - centres[None], axis=2)
    np.fill_diagonal(apart, np.inf)
    assert (apart >= case.radii[:, None] + case.radii[None]).all()
    assert (case.enclosure.clearance(centres) >= case.radii).all()


def test_a_run_of_a_mixture_that_is_stopped_ends_with_the_same_bits(run_of_unlike, tmp_path):
    shutil.copytree(run_of_unlike.parent / "packings", tmp_path / "packings")
    chance, stops, result = random.Random(3), 0, None
    while result is None:
        try:
            result = protocol.run(unlike(), out=tmp_path, stop=lambda: chance.random() < 0.3)
        except Stopped:
            stops += 1
    assert stops >= 3
    assert_same_run(the_run(tmp_path), the_run(run_of_unlike.parent))


def test_the_books_of_a_mixture_close_and_its_folder_knows_the_kinds(run_of_unlike, tmp_path):
    """0.5 % at 1 us, some four times that at the 2 us of the small damper."""
    summary = results(the_run(run_of_unlike.parent))
    assert abs(summary["energy_closure"]) < 0.02
    large, little = summary["kinds"]
    assert (large["count"], little["count"], summary["n_particles"]) == (8, 30, 38)
    masses = read_trajectory(run_of_unlike).static["mass"]
    assert masses.sum() == pytest.approx(summary["mass_kg"], rel=1e-12)
    assert large["mass_kg"] == pytest.approx(masses[:8].sum(), rel=1e-12)
    export(run_of_unlike, "csv", tmp_path)
    head, *rows = (tmp_path / "bodies.csv").read_text(encoding="utf-8").splitlines()
    assert head == "id,radius_m,mass_kg,kind"
    assert [row.split(",")[-1] for row in rows] == ["0"] * 8 + ["1"] * 30
    colours = colouring(read_scene(run_of_unlike), "kind", [0]).of(0)
    assert len(np.unique(colours[:8], axis=0)) == len(np.unique(colours[8:], axis=0)) == 1
    assert (colours[0] != colours[8]).any()
