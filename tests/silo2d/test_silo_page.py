"""The page of a discharge shows what the run folder holds, to the steps that it is packed in."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from fake_run import write_fake_run
from read_page import Page, read_page
from refusals import assert_refused
from small_silo import silo2d

from granulab.campaign.runs.trajectory import read_tables
from silo2d.measures.basics.contacts import moment_at, particle_stress
from silo2d.view import player as player_module
from silo2d.view.player import player_page
from silo2d.view.scene import Scene, read_scene

LENGTH = 0.12  # [m] of the wood's prisms


@pytest.fixture(scope="module")
def scene(reference) -> Scene:
    return read_scene(reference.path)


@pytest.fixture(scope="module")
def page(reference) -> Page:
    return read_page(player_page(reference.path, 2.5e6)[0])


def test_particles_stand_where_the_run_has_them(page, scene):
    """Places to 2^-17 of the window, angles to half of 1/4096 turn, while a particle is shown."""
    arrays, run = page.arrays, scene.trajectory
    shown = arrays["inside"] == 1
    reach = scene.window[2] - scene.reach
    np.testing.assert_array_equal(shown, run["inside"] & (run["y"] > reach))
    step = 0.5 * max(scene.window[1] - scene.window[0], scene.window[3] - scene.window[2]) / 2**16
    for axis in "xy":
        assert np.abs(arrays[axis] - run[axis])[shown].max() <= 1.01 * step
    assert np.abs(arrays["angle"] - run["angle"])[shown].max() <= 1.01 * np.pi / 4096
    np.testing.assert_allclose(arrays["time"], scene.time, atol=1e-5)
    np.testing.assert_array_equal(arrays["counted"], run["n_out"])


def test_speeds_come_to_a_thousandth_of_the_scale(page, scene):
    run, (colour,) = scene.trajectory, [c for c in page.data["colours"] if c["label"] == "speed"]
    shown = page.arrays["inside"] == 1
    speed = np.hypot(run["vx"], run["vy"])[shown]
    found = page.arrays["speed"][shown]
    np.testing.assert_allclose(found, speed, atol=0.51e-3 * colour["high"])
    assert colour["unit"] == "m/s"
    assert 0.9 < (speed < colour["high"]).mean() < 1, "but the fastest, which end the scale"


def test_the_network_is_that_of_the_stored_contacts(page, scene, reference):
    """Each pair once; its force the sum over its contacts, to half of 1.2 %; branches to walls."""
    tables, arrays = read_tables(reference.path, "contacts"), page.arrays
    start = np.concatenate([[0], np.cumsum(arrays["moment_length"])]).astype(int)
    walls = np.cumsum(arrays["second"] >= scene.n_particles)
    assert len(start) == len(tables) + 1
    for k in (0, 2):
        moment, rows = moment_at(scene, tables, k), slice(start[k], start[k + 1])
        found = np.column_stack([arrays["first"], arrays["second"]])[rows].astype(int)
        pairs, _ = moment.pairs
        np.testing.assert_array_equal(found, pairs)
        for (a, b), size in list(zip(found, arrays["force"][rows], strict=True))[::7]:
            of = (moment.bodies == (a, b)).all(axis=1)
            assert size == pytest.approx(np.hypot(*moment.force[of].sum(axis=0)), rel=6e-3)
        row = start[k] + int(np.argmax(found[:, 1] >= scene.n_particles))
        a, b = found[row - start[k]]
        assert b >= scene.n_particles
        point = moment.point[(moment.bodies == (a, b)).all(axis=1)].mean(axis=0)
        branch = arrays["branch"][walls[row] - 1]
        np.testing.assert_allclose(branch, point - moment.centres[a], atol=1e-4)


def test_stress_is_the_pressure_over_the_prisms_length(page, scene, reference):
    """Half the trace of particle_stress [N/m] over 120 mm where it presses; to half of 1.2 %."""
    (colour,) = [c for c in page.data["colours"] if c["array"] == "stress"]
    assert colour["unit"] == "Pa"
    tables = read_tables(reference.path, "contacts")
    stress = particle_stress(scene, tables, 0)
    pressure = np.trace(stress, axis1=1, axis2=2) / 2 / LENGTH
    found = page.arrays["stress"][0]
    large = pressure > 1e-4 * page.arrays["stress"].max()
    np.testing.assert_allclose(found[large], pressure[large], rtol=6e-3)
    assert large.sum() > 20


def test_without_a_length_stress_is_of_the_plane(reference, tmp_path):
    folder = tmp_path / "copy"
    shutil.copytree(reference.path, folder)
    text = (folder / "materials.toml").read_text("utf-8")
    lines = [line for line in text.splitlines() if not line.startswith("length")]
    (folder / "materials.toml").write_text("\n".join(lines), "utf-8")
    page = read_page(player_page(folder, 2.5e6)[0])
    assert [c["unit"] for c in page.data["colours"] if c["array"] == "stress"] == ["N/m"]


def test_curves_and_wall_forces_are_the_run_s(page, scene):
    """Curves to a thousandth of their span; the published times of A4 as marks of another run."""
    curves = {curve["name"]: curve for curve in page.data["curves"]}
    out = page.arrays[curves["particles out"]["series"][0]["array"]]
    np.testing.assert_allclose(out, scene.trajectory["n_out"], atol=1e-3 * out.max())
    forces = scene.trajectory["wall_force"]
    step = np.abs(forces).max() / 2000
    found = page.arrays["wall_force"].reshape(forces.shape)
    np.testing.assert_allclose(found, forces, atol=0.51 * step)
    assert [wall["name"] for wall in page.data["walls"]] == scene.wall_names
    dissipated = curves["energy dissipated"]
    total = page.arrays[dissipated["series"][0]["array"]][-1]
    assert total == pytest.approx(sum(scene.summary["dissipated_j"].values()), rel=1e-3)


def test_a_gate_comes_with_its_times_its_door_and_its_force(reference, scene, monkeypatch):
    gated = read_scene(reference.path)
    gated.trajectory.attributes["gate_times"] = np.array([0.05, 0.1])
    monkeypatch.setattr(player_module, "read_scene", lambda folder: gated)
    page = read_page(player_page(reference.path, 2.5e6)[0])
    (left, right), (door,) = scene.trajectory.attributes["lips"], page.data["plane"]["doors"]
    np.testing.assert_allclose(door, [left, right], atol=1e-6)
    assert page.data["plane"]["gateTimes"] == [0.05, 0.1]
    assert page.data["walls"][-1] == {"name": "door", "middle": [0.0, 0.0]}
    (force,) = [c for c in page.data["curves"] if c["name"] == "downward force on the walls"]
    assert [line["label"] for line in force["series"]][-1] == "door"


def test_published_times_are_marked(tmp_path):
    """A4: 0.99 s of the experiment, 1.00 s of SPOLY."""
    page = read_page(player_page(write_fake_run(tmp_path / "a4").path, 2.5e6)[0])
    spans = page.data["curves"][0]["spans"]
    assert [span["label"] for span in spans] == ["experiment 0.99 \u00b1 0.03 s", "SPOLY 1.00 s"]
    assert spans[1]["from"] == spans[1]["to"] == 1.0
    assert "first" not in page.arrays, "a run without contacts has no network"


def test_the_command_writes_a_page_beside_the_pictures(finished):
    run = next(finished.glob("small-*"))
    done = silo2d("view", run)
    assert (done.code, done.err) == (0, "")
    assert Path(done.out.strip()) == run / "figures" / "page.html"
    elsewhere = silo2d("view", run, "-o", finished / "there" / "mine.html", "--size", 0.2)
    assert (finished / "there" / "mine.html").read_text("utf-8")
    assert elsewhere.code == 0


def test_run_page_says_in_its_last_line_where_the_page_is(finished):
    run = next(finished.glob("small-*"))
    done = silo2d("run", "--resume", run, "--page", "--no-figures", "--quiet")
    assert done.code == 0, done.err
    last = done.out.strip().rpartition("  page ")[2]
    assert " ".join(last.split()).endswith("page.html: open it in a browser")
    assert (run / "figures" / "page.html").stat().st_size > 1e4


def _unfinished(run: Path) -> str:
    (run / "summary.json").unlink()
    return "unfinished; wait for it, or go on with it: silo2d run --resume"


def _damaged(run: Path) -> str:
    whole = (run / "trajectory.h5").read_bytes()
    (run / "trajectory.h5").write_bytes(whole[: len(whole) // 2])
    return "use --again to compute the run again"


def _no_outcome(run: Path) -> str:
    summary = json.loads((run / "summary.json").read_text("utf-8"))
    (run / "summary.json").write_text(json.dumps({**summary, "outcome": 3}), "utf-8")
    return "damaged"


def _no_run(run: Path) -> str:
    (run / "case.toml").unlink()
    return "neither a run folder (it has no case.toml) nor a sweep or map (no table.csv)"


@pytest.mark.parametrize("spoil", [_unfinished, _damaged, _no_outcome, _no_run])
def test_a_run_that_cannot_be_played_is_refused_with_the_cure(finished, spoil):
    run = next(finished.glob("small-*"))
    words = spoil(run)
    assert_refused(silo2d("view", run), str(run), words)
    assert not (run / "figures").exists()


def test_options_that_do_not_go_are_refused(finished):
    run = next(finished.glob("small-*"))
    assert_refused(silo2d("view", run, "--runs"), "--runs is of a sweep or map")
    assert_refused(silo2d("view", run, "--size", 0.06), "--size: 60 kB hold no two frames")
    assert_refused(silo2d("view", run, "--size", "little"), "little")
