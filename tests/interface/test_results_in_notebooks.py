"""What a result gives to whoever has it in Python: series, frames, pictures, and itself as HTML."""

import base64
import math
import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from damper3d.case.case import GRAVITY
from damper3d.run.result import Result as DamperResult
from granulab.campaign.runs.folder import RunFolder
from granulab.errors import FolderError
from silo2d.run.result import Result as SiloResult


def copied(folder, tmp_path):
    """A copy of a finished run that pictures may be drawn into."""
    return RunFolder(shutil.copytree(folder.path, tmp_path / folder.path.name))


@pytest.fixture
def silo(reference, tmp_path):
    return SiloResult.read(copied(reference, tmp_path), reused=True)


@pytest.fixture
def damper(damper_reference, tmp_path):
    return DamperResult.read(copied(damper_reference, tmp_path), reused=True)


def test_series_of_a_silo_end_with_its_result_and_carry_its_weight(silo):
    """The walls' vertical forces are the weight at rest, before the door opens (Newton).

    A bed that counts as settled still vibrates, by 1 and 5 % of its weight on two processors, whose
    packings are other ones; a wall or an axis left out is off by a third or more.
    """
    found = silo.records()
    assert found.index.name == "time_s"
    assert found["n_out"].iloc[-1] == silo.n_out
    assert (np.diff(found.index) > 0).all()
    vertical = [name for name in found if re.fullmatch(r"wall_force_\w+_y", name)]
    assert "wall_force_door_y" in vertical
    held = -found[vertical].iloc[0].sum()
    assert held == pytest.approx(silo.mass_kg * GRAVITY, rel=0.2)


def test_series_of_a_damper_are_those_of_its_motion(damper):
    """The enclosure's velocity is Gamma g/omega at most, at t = 0 for the first time (eq. 6.2)."""
    found = damper.records()
    speed = damper.gamma * GRAVITY / (2 * math.pi * damper.frequency_hz)
    assert found["velocity"].iloc[0] == pytest.approx(speed, rel=1e-9)
    assert found["velocity"].abs().max() == pytest.approx(speed, rel=1e-9)
    assert {"mean_position_z", "wall_force_bottom_z", "wall_work"} <= set(found)


def test_frames_are_those_of_the_run_folder(silo, reference):
    frames = silo.trajectory()
    assert frames["x"].shape == (len(silo.records()), silo.n_particles)


def test_a_result_shows_its_numbers_and_its_first_picture(silo):
    shown = silo._repr_html_()
    assert "<td>outcome</td><td>empty</td>" in shown
    (image,) = re.findall(r'base64,([^"]+)"', shown)
    assert base64.b64decode(image).startswith(b"\x89PNG")
    paths = silo.plot()
    assert [path.name for path in paths] == [
        "silo.png",
        "discharge.png",
        "energy.png",
        "forces.png",
    ]


def test_a_result_shows_the_numbers_of_its_tables_and_intervals(damper):
    """By the names that they have as columns of a sweep; 0.4 as 0.4, and no series."""
    dissipated = replace(damper, shares={"wall": {"friction": 0.4}}, efficiency_interval=(0.1, 0.3))
    shown = dissipated._repr_html_()
    assert "<td>shares.wall.friction</td><td>0.4</td>" in shown
    assert "<td>efficiency_interval</td><td>0.1 to 0.3</td>" in shown
    assert "efficiency_per_cycle" not in shown


def test_a_film_is_drawn_on_request(damper):
    assert damper.film().stem == "film"


def test_a_run_without_frames_shows_its_numbers_and_refuses_its_series(damper):
    (Path(damper.run_folder) / "trajectory.h5").unlink()
    assert "<td>efficiency</td>" in damper._repr_html_()
    assert "base64" not in damper._repr_html_()
    with pytest.raises(FolderError):
        damper.records()
