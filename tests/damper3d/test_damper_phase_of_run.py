"""A run's summary names its phase, and its folder gives the same again."""

import pytest
from small_damper import CASE

from damper3d import DamperCase, run
from damper3d.measures.phases.criteria import PHASES, phase_of_run
from granulab.errors import FolderError


def test_a_run_keeps_its_phase_and_the_folder_gives_it_again(tmp_path):
    """From the frames in single precision, before and after the trajectory is closed."""
    result = run(DamperCase.load("thesis", CASE), out=tmp_path)
    assert result.phase in PHASES["vertical"]
    again = phase_of_run(result.run_folder)
    assert again["phase"] == result.phase
    assert again["phase_measures"] == pytest.approx(result.phase_measures)


@pytest.mark.parametrize("frames", [0, 5])
def test_a_run_with_too_few_frames_has_no_phase(tmp_path, frames):
    result = run(DamperCase.load("thesis", {**CASE, "output.frames": frames}), out=tmp_path)
    assert result.phase is None
    assert result.phase_measures is None


def test_a_folder_without_a_run_is_refused(tmp_path):
    with pytest.raises((FolderError, ValueError), match=str(tmp_path.name)):
        phase_of_run(tmp_path)
