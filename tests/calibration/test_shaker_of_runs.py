"""A run of damper3d as a measured record: `calibrate shaker` finds the run's own efficiency."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from damper_runs import small
from fake_damper_run import write_fake_damper_run
from small_damper import damper3d

from calibration.shaker.measure import dissipation
from calibration.shaker.record import read_record
from damper3d.run.protocol import run
from damper3d.view.export import export
from damper3d.view.scene import read_scene
from granulab.errors import FolderError


@pytest.fixture(scope="module", params=[2.0, 10.0, 20.0])
def shaken(request, damper_reference, tmp_path_factory):
    """Folder of a run that is steady, its record and that of the empty enclosure."""
    out = tmp_path_factory.mktemp("shaken")
    shutil.copytree(damper_reference.path.parent / "packings", out / "packings")
    case = small(motion__gamma=request.param, run__cycles=108, run__discard=8,
                 output__samples=100, output__frames=0)  # fmt: skip
    folder = Path(run(case, out=out).run_folder)
    return folder, *map(read_record, export(folder, "shaker"))


def test_the_records_give_the_runs_own_efficiency(shaken):
    """Eqs 7.7 to 7.12 against the work of the walls, and within 1 % against the energy budget.

    They differ by what the bed's own energy has changed, which no transducer sees: in a hundred
    cycles, less than 1 %. Work within a sample is lost: an impact at its end, not its middle, has
    another velocity by pi/100 of the peak, and a hundred cycles average over that: 0.05 % is left.
    """
    folder, full, empty = shaken
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    mass = summary["n_particles"] * summary["particle_mass_kg"]
    found = dissipation(full, [empty], mass)
    assert found.efficiency.value == pytest.approx(summary["efficiency"], rel=0.01)
    assert found.efficiency.value == pytest.approx(summary["efficiency_wall_work"], rel=1e-3)
    assert found.gamma == pytest.approx(summary["gamma"], rel=2e-3)
    assert found.warnings == ()
    low, high = dissipation(full, [], mass).efficiency.interval
    assert low < summary["efficiency"] < high


def turned(record, path, angle):
    """A record whose force comes an angle [rad] earlier than it did; see Record."""
    force, moved = record.samples
    lines = np.fft.rfft(force) * np.exp(1j * angle * (np.fft.rfftfreq(len(force)) > 0))
    t = np.arange(len(force)) / record.rate
    np.savetxt(path, np.column_stack([t, np.fft.irfft(lines, len(force)), moved]), delimiter=",",
               comments="", header="time [s],force [N],acceleration [m/s2]")  # fmt: skip
    return read_record(path)


@pytest.mark.parametrize("degrees", [-1.0, 0.3, 1.0])
def test_a_phase_error_of_the_chain_is_taken_off_or_in_the_interval(shaken, tmp_path, degrees):
    _, full, empty = shaken
    truth = dissipation(full, [empty]).power.value
    wrong = [turned(one, tmp_path / f"{k}.csv", np.radians(degrees))
             for k, one in enumerate((full, empty))]  # fmt: skip
    assert dissipation(wrong[0], wrong[1:]).power.value == pytest.approx(truth, rel=0.01)
    low, high = dissipation(wrong[0]).power.interval
    assert low < truth < high


def test_force_is_that_of_the_shaker_on_the_enclosure(tmp_path):
    """m a - F_bed, of which the bed's weight is the mean; the first line says the masses."""
    write_fake_damper_run(tmp_path, cycles=5, discard=3)
    done = damper3d("export", tmp_path, "--to", "shaker", "--enclosure-mass", "50 g")
    assert (done.code, done.err) == (0, "")
    full, empty = (tmp_path / "export" / f"{name}.csv" for name in ("shaker", "shaker-empty"))
    assert done.out.splitlines() == [str(full), str(empty)]
    first = full.read_text(encoding="utf-8").splitlines()[0]
    assert first.startswith("# enclosure 0.05 kg, particles 0.0")
    (_, force, moved), (_, alone, same) = (
        np.loadtxt(path, delimiter=",", skiprows=2, unpack=True) for path in (full, empty)
    )
    np.testing.assert_array_equal(moved, same)
    np.testing.assert_allclose(alone, 0.05 * moved, rtol=1e-8)
    assert len(force) == 2 * 40
    assert (force - alone).mean() == pytest.approx(read_scene(tmp_path).mass * 9.81, rel=1e-6)


@pytest.mark.parametrize(
    ("made", "options", "words"),
    [
        ({}, ["--enclosure-mass", "0 g"], "--enclosure-mass = 0 kg: expected more than 0"),
        ({}, ["--enclosure-mass", "2 m"], "--enclosure-mass"),
        ({"keep": "summary"}, [], "only its summary was kept"),
        ({"finished": False, "cycles": 3, "discard": 3, "until": 70}, [], "no cycle that counts"),
    ],
)
def test_what_makes_no_record_is_refused_in_one_line(tmp_path, made, options, words):
    write_fake_damper_run(tmp_path, **({"cycles": 1} | made))
    done = damper3d("export", tmp_path, "--to", "shaker", *options)
    assert done.code == 2
    assert words in done.err
    assert len(done.err.splitlines()) == 1


def test_other_formats_have_no_enclosure_mass(tmp_path):
    write_fake_damper_run(tmp_path, cycles=1)
    done = damper3d("export", tmp_path, "--to", "csv", "--enclosure-mass", "50 g")
    assert (done.code, "of --to shaker" in done.err) == (2, True)


def test_a_folder_without_a_run_is_refused(tmp_path):
    with pytest.raises(FolderError):
        export(tmp_path, "shaker")
