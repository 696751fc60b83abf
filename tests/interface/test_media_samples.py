"""Samples of data/media: rendered again they are the same, small, and measure to their truth."""

import subprocess
import sys
import tomllib

import numpy as np
import pytest

from calibration import measure_drop
from calibration.rendered.__main__ import main
from calibration.tracking.film.reader import open_film
from granulab.contact.files.datafile import data_file, data_root

SMALL = 300_000  # bytes: samples ship with every installation


def pictures(path):
    return np.array([frame.picture for frame in open_film(path).frames()], dtype=float)


@pytest.fixture(scope="module")
def rendered(tmp_path_factory):
    folder = tmp_path_factory.mktemp("media")
    assert main(["drop", str(folder)]) == 0
    return folder


def test_the_drop_is_rendered_again_as_it_ships(rendered):
    """Same truth; pictures to what another build of the codec may differ by: a grey level."""
    shipped = data_file("media", "drop")
    assert shipped.name == "drop.mp4"
    assert shipped.stat().st_size < SMALL
    facts = (rendered / "drop.toml").read_text(encoding="utf-8")
    assert facts == shipped.with_suffix(".toml").read_text(encoding="utf-8")
    here, there = pictures(shipped), pictures(rendered / "drop.mp4")
    assert here.shape == there.shape
    assert np.abs(here - there).mean() < 1


def test_the_drop_measures_to_its_truth():
    """Pooled value and contacts within four sigma; 0.01 frame for what compression does."""
    shipped = data_file("media", "drop")
    truth = tomllib.loads(shipped.with_suffix(".toml").read_text(encoding="utf-8"))
    drop = measure_drop(shipped)
    e = drop.restitution
    assert e.value == pytest.approx(truth["restitution"], abs=4 * e.sigma + 1e-4)
    assert e.sigma < 0.005
    contacts = np.array([drop.frame(t) for t in drop.bounces.contacts[:, 0]])
    expected = np.array(truth["contact_frames"][: len(contacts)])
    assert len(contacts) >= 4
    assert np.all(np.abs(contacts - expected) < 4 * drop.bounces.contacts[:, 1] + 0.01)
    times = drop.to_dict()["contact_times_s"]  # as a player counts: the film starts at zero
    assert times == pytest.approx(truth["contact_times_s"][: len(times)], abs=1e-3)
    assert drop.scale.value == pytest.approx(1e-3, rel=0.01)  # 0.3 % of it is g's own sigma


def test_readme_names_every_sample():
    said = (data_root() / "media" / "README.md").read_text(encoding="utf-8")
    for path in (data_root() / "media").iterdir():
        assert path.stem == "README" or path.stem in said
        assert path.stat().st_size < SMALL


def test_an_unknown_sample_is_refused_in_one_line():
    found = subprocess.run(
        [sys.executable, "-m", "calibration.rendered", "ball", "x"],
        capture_output=True, text=True, check=False, cwd=data_root().parent,
    )  # fmt: skip
    assert found.returncode == 2
    assert found.stderr.count("\n") == 1
    assert "drop" in found.stderr
