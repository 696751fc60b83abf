"""The command calibrate piv: report, JSON, table, figure, refusals; strangers' particle pairs."""

import csv
import json
import os
from pathlib import Path

import cv2
import numpy as np
import pytest
from calibrating import calibrate
from made_pairs import grains, uniform

from calibration.piv import displacement
from calibration.piv.pictures import read_picture

MEDIA = Path(os.environ.get("GRANULAB_MEDIA") or Path(__file__).parents[3] / "shared" / "media")
needs_media = pytest.mark.skipif(not MEDIA.is_dir(), reason=f"no recordings in {MEDIA}")


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Particles that move by (1.5, 4.25) px; a mask that leaves out the left quarter."""
    folder = tmp_path_factory.mktemp("pair")
    pair = grains(uniform(1.5, 4.25), 8, shape=(128, 160))
    mask = np.full(pair.a.shape, 255, dtype=np.uint8)
    mask[:, :40] = 0
    for name, picture in (("a", pair.a), ("b", pair.b), ("mask", mask)):
        cv2.imwrite(str(folder / f"{name}.png"), picture)
    (folder / "no.png").write_text("no picture", encoding="utf-8")
    cv2.imwrite(str(folder / "small.png"), pair.a[:50])
    cv2.imwrite(str(folder / "blank.png"), np.full_like(pair.a, 80))
    return folder


def test_one_json_object_and_a_table_with_units_in_its_head(files, tmp_path):
    """0.1 mm/px and 2 ms: (1.5, 4.25) px are 0.2253 m/s."""
    given = ("--scale", "0.1 mm/px", "--dt", "2 ms", "--mask", files / "mask.png")
    result = calibrate(
        "piv", files / "a.png", files / "b.png", *given, "--json", "-o", tmp_path / "field"
    )
    assert (result.code, result.err) == (0, "")
    found = json.loads(result.out)
    assert (
        found["valid"] + sum(n for reason, n in found["reasons"].items() if reason != "measured")
        == found["vectors"]
        == 7 * 9
    )
    assert found["reasons"]["masked"] == 2 * 7
    # half the largest error of a vector that the tests of displacement allow
    assert found["u_px"]["mean"] == pytest.approx(1.5, abs=0.05)
    assert found["v_px"]["mean"] == pytest.approx(4.25, abs=0.05)
    assert found["speed_m_s"]["mean"] == pytest.approx(0.2253, abs=0.0025)
    assert 0 < found["sigma_px"]["median"] < 0.1
    assert Path(found["sheet"]).read_bytes()[:4] == b"\x89PNG"
    rows = list(csv.DictReader(Path(found["table"]).read_text(encoding="utf-8").splitlines()))
    assert len(rows) == found["vectors"]
    good = [row for row in rows if row["valid"] == "1"]
    assert len(good) == found["valid"]
    for row in good:
        assert float(row["u [m/s]"]) == pytest.approx(0.05 * float(row["u [px]"]), abs=1e-6)
        assert float(row["x [m]"]) == pytest.approx(1e-4 * float(row["x [px]"]), abs=1e-8)
        assert float(row["sigma_u [px]"]) > 0
    masked = [row for row in rows if row["reason"] == "masked"]
    assert all(row["u [px]"] == "" and row["valid"] == "0" for row in masked)


def test_the_report_says_how_many_and_how_far(files):
    result = calibrate("piv", files / "a.png", files / "b.png", "--method", "flow", "--dt", "0.5 s")
    assert result.code == 0
    assert "vectors valid, windows of 32 px" in result.out
    assert "px/s (mean)" in result.out


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (["a.png", "no.png"], "no.png: no picture that can be read"),
        (["a.png", "there.png"], "there.png: cannot be read (No such file"),
        (["a.png", "small.png"], "small.png: 160 x 50 pixels, and "),
        (["blank.png", "blank.png"], "nothing is found in both pictures (63 of 63: no texture)"),
        (["a.png", "b.png", "--mask", "small.png"], "small.png: 160 x 50 pixels"),
        (["a.png", "b.png", "--scale", "0.1 mm"], "a length per pixel, such as '0.81 mm/px'"),
        (["a.png", "b.png", "--dt", "0 s"], "--dt = 0 s: must be positive"),
        (["a.png", "b.png", "--window", "200"], "window = 200 px: must be from 8"),
        (["a.png", "b.png", "--mask", "blank.png", "--overlap", "1"], "overlap = 1.0: must be"),
    ],
)
def test_bad_input_is_one_line(files, given, words, monkeypatch):
    monkeypatch.chdir(files)
    result = calibrate("piv", *given)
    assert result.code == 2
    assert words in result.err
    assert result.err.count("\n") == 1


def pair(name, ends):
    return [read_picture(MEDIA / f"{name}{end}.bmp") for end in ends]


@needs_media
@pytest.mark.parametrize("method", ["piv", "flow"])
def test_openpiv_test14_moves_by_three_pixels(method):
    """(3.00, 3.00) px everywhere. OpenPIV's own result, v upwards, has an rms error of 0.018 px."""
    other = np.loadtxt(MEDIA / "openpiv_test14_disp_096a.bmp.txt")[:, 2:4] * (1, -1)
    field = displacement(*pair("openpiv_test14_disp_096", "ab"), window=32, method=method)
    assert field.valid.all()
    rms = [np.sqrt(((one - 3.0) ** 2).mean()) for one in (field.u, field.v)]
    assert max(rms) < np.sqrt(((other - 3.0) ** 2).mean(axis=0)).min()
    assert max(rms) < 0.01  # what windows that follow the motion reach: half of OpenPIV's


@needs_media
def test_openpiv_test1_both_methods_agree_within_their_sigma():
    """A real flow without a reference: two ways find the same, as far as they say (68 % within one
    joint sigma, but they share what the pictures do not hold, so that it may be more)."""
    pictures = pair("openpiv_test1_exp1_001_", "ab")
    one, other = (displacement(*pictures, window=32, method=m) for m in ("piv", "flow"))
    assert one.valid.mean() > 0.95
    assert other.valid.mean() > 0.9
    both = one.valid & other.valid
    apart = np.stack([one.u - other.u, one.v - other.v])[:, both]
    joint = np.hypot([one.sigma_u, one.sigma_v], [other.sigma_u, other.sigma_v])[:, both]
    assert (np.abs(apart) < joint).mean() > 0.6
    assert np.abs(np.median(apart, axis=1)).max() < 0.02
    # neighbouring windows share half their particles: smooth to a few sigma
    steps = np.abs(np.diff(one.v, axis=1))[one.valid[:, 1:] & one.valid[:, :-1]]
    assert np.median(steps) < 3 * np.median(one.sigma_v[one.valid])
