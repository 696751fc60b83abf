"""The one way in which a command of calibrate ends: text, --json, figure, files, --into."""

import json
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from calibration.files.provenance import read_values
from calibration.result import Into, Parameter, finish
from calibration.statistics.uncertainty import Estimate
from granulab.errors import InputError


class Found:
    """A result with all that one can have."""

    def to_dict(self):
        """One number."""
        return {"restitution": {"value": 0.5}}

    def text(self):
        """The same."""
        return "restitution 0.5"

    def figure(self):
        """An empty one."""
        return Figure(figsize=(2, 2))

    def parameters(self):
        """The restitution."""
        return {"restitution": Parameter(Estimate(0.5, 0.01, 3), "drop test")}


def test_json_has_the_numbers_and_the_paths_of_all_files(tmp_path, capsys):
    tables = [tmp_path / "a.csv", tmp_path / "b.csv"]
    finish(Found(), as_json=True, out=tmp_path, name="drop", files={"tables": tables})
    said = capsys.readouterr()
    assert json.loads(said.out) == {
        "restitution": {"value": 0.5},
        "tables": [str(path) for path in tables],
        "sheet": str(tmp_path / "drop.png"),
    }
    assert said.err == ""
    assert (tmp_path / "drop.png").read_bytes()[:4] == b"\x89PNG"


def test_no_figure_without_a_folder(tmp_path, capsys):
    finish(Found(), as_json=True)
    assert json.loads(capsys.readouterr().out)["sheet"] is None
    finish(Found(), as_json=True, figure_key=None)
    assert "sheet" not in json.loads(capsys.readouterr().out)


@pytest.mark.parametrize("quiet", [False, True])
def test_text_goes_to_stdout_and_paths_to_stderr_unless_quiet(tmp_path, capsys, quiet):
    finish(Found(), as_json=False, quiet=quiet, out=tmp_path, name="drop",
           files={"tables": [Path("a.csv")], "annotated_film": Path("a.mp4")})  # fmt: skip
    said = capsys.readouterr()
    assert said.out == "restitution 0.5\n"
    lines = [] if quiet else [
        "table: a.csv", "annotated film: a.mp4", f"diagnostic figure: {tmp_path / 'drop.png'}"
    ]  # fmt: skip
    assert said.err.splitlines() == lines


def test_into_writes_what_the_result_has(tmp_path, capsys):
    track = tmp_path / "track.csv"
    track.write_text("x")
    into = Into(tmp_path / "wood.toml", "wood-steel", None, ("restitution",))
    finish(Found(), as_json=False, quiet=True, into=into, measured=[track])
    _, values, _ = read_values(into.path)
    written = values["pair.wood-steel", "restitution"]
    assert (written.value, written.method, written.source) == (0.5, "drop test", "track.csv")
    assert "added" in capsys.readouterr().err


def test_into_refuses_what_the_result_lacks_and_prints_nothing(tmp_path, capsys):
    into = Into(tmp_path / "wood.toml", "wood-steel", None, ("friction",))
    with pytest.raises(InputError, match="no friction"):
        finish(Found(), as_json=True, into=into)
    assert capsys.readouterr().out == ""
    assert not into.path.exists()
