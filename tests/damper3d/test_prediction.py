"""Predictions of cases, compared with simulations."""

import math

import pytest
from made_map import made_runs

from damper3d.case import closed_forms
from damper3d.case.case import DamperCase
from damper3d.case.random_packing import close_packing
from damper3d.studies.predict import compare
from damper3d.studies.predict.chart import draw_predictions
from damper3d.studies.predict.prediction import (
    as_dict,
    as_text,
    fills,
    frequencies_for,
    inverted,
    inverted_words,
    predict,
)
from granulab.campaign.output.figure import write_figure
from granulab.errors import InputError

BOX = {"enclosure.shape": "box", "enclosure.width": "40 mm", "enclosure.depth": "20 mm"}


def predicted(changes=None, **own):
    return predict(DamperCase.load("thesis", changes or {}), **own)


def test_without_a_case_it_is_the_thesis_at_its_four_heights():
    """Table 6.1: 358 spheres of 5 mm at 40 to 55 mm."""
    cases = [DamperCase.load(*fill) for fill in fills(None, {})]
    assert [case.count for case in cases] == [358] * 4
    ratios = [predict(case).fill_ratio for case in cases]
    assert ratios == pytest.approx([0.466, 0.415, 0.373, 0.339], abs=7e-4)  # 0.4144 is the second
    assert len(fills("thesis", {})) == len(fills(None, {"enclosure.height": "45 mm"})) == 1


def test_onsets_are_those_of_the_formulas():
    own = predicted(packing=0.6, full_count=480)
    assert [c.name for c in own.clearances] == ["loose", "close", "own", "counted"]
    assert own.best.name == "own"
    clearance = (1 - own.fill_ratio / 0.6) * 0.04
    assert own.best.onset(40.0) == pytest.approx(closed_forms.bouncing_bed_onset(40.0, clearance))
    assert own.clearances[3].length == pytest.approx((1 - 358 / 480) * 0.04)
    assert predicted().best.name == "close"


def test_bed_denser_than_a_packing_has_no_onset_there():
    full = predicted({"particles.count": 440})  # fill ratio 0.573
    assert full.clearances[0].onset(40.0) is None
    assert as_dict(full, [40.0])["bouncing_bed"][0]["gamma"] == [None]
    line = next(line for line in as_text(full, [40.0]).splitlines() if "loose" in line)
    assert line.split() == ["loose", "0.55", "-", "-", "-"]


def test_threshold_follows_gravity_and_direction():
    assert predicted().threshold == 1.0
    across = predicted({"motion.orientation": "horizontal", "law.friction_wall": 0.3})
    assert (across.orientation, across.threshold) == ("horizontal", 0.3)
    assert across.fluidisation is None
    assert predicted({"motion.orientation": "none"}).threshold == 0.0
    oblique = predicted({"motion.gravity": [0.0, -1.0, -1.0]})
    assert (oblique.orientation, oblique.threshold) == ("oblique", None)
    assert "no closed form" in as_text(oblique, [40.0])


def test_length_is_that_between_the_walls_which_the_motion_meets():
    assert predicted({"enclosure.height": "45 mm"}).length == 0.045
    assert predicted({**BOX, "motion.direction": [0.0, -2.0, 0.0]}).length == 0.02


def test_a_case_with_a_frequency_has_its_onset_too():
    assert frequencies_for(DamperCase.load("thesis")) == (20.0, 40.0, 80.0)
    own = DamperCase.load("thesis", {"motion.frequency": 38.0})
    assert frequencies_for(own) == (20.0, 38.0, 40.0, 80.0)


@pytest.mark.parametrize(("bottom", "top"), [(40.0, 10.0), (10.0, 40.0)])
def test_clearance_of_a_frustum_is_over_the_level_of_its_bed(bottom, top):
    """A cone's volume goes with the cube of its width: the bed at close packing takes 0.3/0.64 of
    the volume from the bottom. To 1e-3: the walls that are seen are polygons of 48 sides.
    """
    found = predicted(
        {"enclosure.shape": "frustum", "enclosure.diameter": f"{bottom} mm",
         "enclosure.top_diameter": f"{top} mm", "enclosure.height": "40 mm",
         "particles.shape": "sphere:2mm", "particles.fill_ratio": 0.3}
    )  # fmt: skip
    width = (bottom**3 + 0.3 / 0.64 * (top**3 - bottom**3)) ** (1 / 3)
    level = 0.04 * (width - bottom) / (top - bottom)
    assert found.best.length == pytest.approx(0.04 - level, rel=1e-3)
    # d level/d part = V/A(level), of the packing's uncertainty
    packed = close_packing("sphere:2mm")
    volume = math.pi / 12 * 40 * (bottom**2 + bottom * top + top**2)  # [mm3]
    off = 0.3 / 0.64**2 * packed.uncertainty * volume / (math.pi / 4 * width**2) * 1e-3
    assert found.best.uncertainty == pytest.approx(off, rel=1e-2)
    assert inverted(found, 60.0, 5.0)["height_m"] is None


def test_a_map_of_an_enclosure_without_a_prediction_has_no_onsets(tmp_path):
    """Of a sphere, or of motion across a cylinder, no clearance is known, and none is needed."""
    (tmp_path / "round.toml").write_text(
        'schema = 1\n[enclosure]\nshape = "sphere"\ndiameter = "40 mm"\n[particles]\ncount = 9\n'
    )
    for given in (("thesis", {"motion.direction": [1.0, 0.0, 0.0]}), (tmp_path / "round.toml",)):
        case = DamperCase.load(*given)
        with pytest.raises(InputError, match="two parallel walls"):
            predict(case)
        found = predict(case, needed=False)
        assert [one.onset(40.0) for one in found.clearances] == [None, None]


@pytest.mark.parametrize(
    ("changes", "own", "words"),
    [
        (
            {
                "enclosure.shape": "frustum",
                "enclosure.diameter": "40 mm",
                "enclosure.top_diameter": "30 mm",
                "motion.orientation": "none",
            },
            {},
            "vertical motion",
        ),
        ({"motion.direction": [1.0, 0.0, 0.0]}, {}, "two parallel walls"),
        ({**BOX, "motion.direction": [1.0, 1.0, 0.0]}, {}, "two parallel walls"),
        ({}, {"packing": 0.4}, "fill ratio = 0.466"),
        ({}, {"packing": 1.5}, "packing = 1.5"),
        ({}, {"full_count": 300}, "full count = 300"),
    ],
)
def test_bad_input_is_one_line(changes, own, words):
    with pytest.raises(InputError, match=words) as error:
        predicted(changes, **own)
    assert "\n" not in str(error.value)


def test_simulations_stand_about_the_onset_next_to_both_ideal_curves(monkeypatch, tmp_path):
    monkeypatch.setattr(compare, "run_cases", made_runs)
    chosen = fills(None, {})[:2]
    predictions = [predict(DamperCase.load(*fill)) for fill in chosen]
    rows = compare.simulate(chosen, predictions, [20.0, 80.0], out=tmp_path)
    at_onset = [r for r in rows if r["over_onset"] and 1 <= r["over_onset"] < 1.001]
    assert {(r["fill"], r["frequency_hz"]) for r in at_onset} == {(0, 20.0), (0, 80.0), (1, 20.0)}
    # A rounding of 1e-3 above the onset costs ((2 pi 1e-3)^(2/3)...) less than 1 %.
    assert all(r["ideal_bouncing_bed"] > 0.99 for r in at_onset)
    below = [r for r in rows if r["over_onset"] < 1]
    assert all(r["ideal_bouncing_bed"] is None for r in below)
    fluid = [r for r in rows if r["gamma"] == 2.5]
    assert all(r["ideal_block"] == pytest.approx(0.563, abs=1e-3) for r in fluid)
    assert max(r["gamma"] for r in rows) <= compare.MOST
    figure = write_figure(
        tmp_path / "p.png", lambda: draw_predictions(predictions, [20.0, 80.0], rows)
    )
    assert figure.read_bytes().startswith(b"\x89PNG")
    assert len(compare.as_text(rows, predictions).splitlines()) == len(rows) + 1


def test_a_wanted_point_has_the_clearance_whose_onset_is_there():
    """Back through eqs 6.11 and 6.13: the height and the fill ratio that it names have it."""
    prediction = predicted({"enclosure.height": "45 mm", "particles.count": 300})
    found = inverted(prediction, 60.0, 5.0)
    higher = predicted({"enclosure.height": f"{found['height_m']!r} m", "particles.count": 300})
    assert higher.best.onset(60.0) == pytest.approx(5.0)
    fewer = closed_forms.effective_clearance(found["fill_ratio"], 0.045, higher.best.packing)
    assert closed_forms.bouncing_bed_onset(60.0, fewer) == pytest.approx(5.0)
    assert inverted(prediction, 1.0, 5.0)["fill_ratio"] is None  # wider than the enclosure is high
    assert f"{1e3 * found['height_m']:.4g} mm" in inverted_words(found)
